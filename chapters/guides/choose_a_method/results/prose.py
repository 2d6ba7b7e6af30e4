"""What each method leaves, read from results, and the numbers of the prose."""

import numpy as np

from chapters.shared.general_cameras import KINDS
from chapters.shared.zoom_readings import OF_SEEDS, ZoomCase
from chapters.shared.zoom_rigs import STAGE_ZOOM, ZOOMS, rig_of
from repro.judge.statistics import median_and_range, median_interval

METHODS = ("parametric", "generic_well_conditioned")
PRIMARY = {"domain": "px", "extent": "unbounded"}
FOVS_DEG = (60, 120, 150)
SIMULATED = {
    "clean.source.mean_px": "residual, clean (px)",
    "ray_deg": "ray error (deg)",
}
MODELS = {"zhang": METHODS[0], "general": METHODS[1]}
PEER = "opencv_fisheye"
HELD_OUT, STEPS = "held_out.corrected.rms_px", "stage.grid.deviation_mm"


def typical(result, name, **condition):
    """Median over the trials; a failed one counts as the worst."""
    return median_interval(result.column(name, **condition))


def of_both(result, name, **condition):
    """The same value of Zhang's and of the generic method."""
    return [typical(result, f"{method}.{name}", **condition) for method in METHODS]


def of_peer(result, name, **condition):
    """The same value of OpenCV's fisheye model; None where nobody ran it."""
    if not any(condition.items() <= one.items() for one in result.conditions):
        return None
    return typical(result, f"{PEER}.{name}", **condition)


def peer_in_zoom(results, name, at):
    """OpenCV's fisheye model on a set of the converter, over its own seeds."""
    found = peer_column(results, name, at)
    return None if found is None else median_interval(found)


def peer_column(results, name, at):
    """Its value in every seed; None where a build has no such seeds."""
    case = ZoomCase(
        {key: results[key] for key in OF_SEEDS}, {"interpolation": "smooth"}
    )
    asked = any(
        one["zoom"] == at and one.get("interpolation") == "smooth"
        for key in OF_SEEDS
        for one in results[key].conditions
    )
    return case.column(f"{PEER}.{name}", at) if asked else None


def picture_share(values):
    """Median share of a picture with a ray, over the seeds that have a camera."""
    return np.nan if values is None else median_and_range(values).value


def share_kept_out(zoom, at):
    """Median share of the corners kept out that the generic camera has a ray for."""
    rig = rig_of(at).target
    stem = f"{METHODS[1]}.held_out"
    lost, boards = (
        zoom.column(f"{stem}.{what}", zoom=at) for what in ("left_out", "boards")
    )
    return picture_share(1 - lost / (boards * rig.columns * rig.rows))


def named(results):
    """Numbers of the prose: name -> text."""
    fov, zoom = results["fig_2_3_fov"], results["table_2_2_redrawn"]
    out = peer_facts(results)
    for model, method in MODELS.items():
        for at in FOVS_DEG:
            found = typical(fov, f"{method}.ray_deg", fov_deg=at, **PRIMARY)
            out[f"{model}.ray_deg.{at}"] = short(found)
        for at in ZOOMS:
            found = typical(zoom, f"{method}.{HELD_OUT}", zoom=at)
            out[f"{model}.zoom.{at}"] = short(found)
        out[f"{model}.stage"] = short(
            typical(zoom, f"{method}.{STEPS}", zoom=STAGE_ZOOM)
        )
    out |= recorded_facts(results["ext_calibration_record"])
    out |= fisheye_facts(results["ext_fisheye_scores"])
    out["pictures"] = str(zoom.settings["calibration_images"])
    out["noise"] = f"{fov.settings['fov_sweep']['noise']:g}"
    return out


def peer_facts(results):
    """What OpenCV's fisheye model leaves, in words."""
    fisheye = results["fig_2_3_fisheye"]
    out = {"peer.stage": short(peer_in_zoom(results, STEPS, STAGE_ZOOM))}
    for at in FOVS_DEG:
        found = of_peer(fisheye, "ray_deg", fov_deg=at, **PRIMARY)
        out[f"peer.ray_deg.{at}"] = short(found)
    for at in ZOOMS:
        out[f"peer.zoom.{at}"] = short(peer_in_zoom(results, HELD_OUT, at))
    return out


def recorded_facts(kept):
    """The widest real camera of the record, and what two methods leave on it."""

    widest_deg = kept.select().column("widest_deg")
    widest = kept.conditions[int(widest_deg.argmax())]
    out = {"record.name": widest["set"], "record.widest": f"{widest_deg.max():.0f}"}
    for model in ("opencv_fisheye", "generic"):
        left = kept.column(f"models.{model}.px", **widest)[0]
        out[f"record.{model}"] = in_pixels(left)
    return out


def in_pixels(error):
    """An error in words, or that there is no camera to have one."""
    return f"{error:.2g} px" if np.isfinite(error) else "no camera"


def motion_facts(wrong):
    """Ray error of the two-pose method for one unit of error of T_1."""
    out = {"motion.grids": wrong.settings["grids"]}
    for kind in KINDS:
        out[f"motion.{kind}"] = short(typical(wrong, "ray_deg.1", kind=kind))
    return out


def fisheye_facts(scores):
    """What the walk through a fisheye's calibration says, in words."""
    out = {}
    for use, found in scores.by("boards").items():
        for model in ("zhang", "opencv_fisheye", "generic"):
            kept = found.column(f"{model}.kept_out_px")[0]
            out[f"fisheye.{model}.{use}"] = in_pixels(kept)
        share, boards = (
            found.column(name)[0] for name in ("generic.image_with_ray", "boards")
        )
        out[f"fisheye.share.{use}"] = f"{100 * share:.0f} %"
        out[f"fisheye.boards.{use}"] = f"{boards:.0f}"
    return out


def short(estimate):
    """A median in words, for a sentence."""
    if estimate is None:
        return "not measured"
    return f"{estimate.value:.2g}" if np.isfinite(estimate.value) else "∞"
