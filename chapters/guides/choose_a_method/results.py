"""What each method leaves, read from results, and the numbers of the prose."""

from __future__ import annotations

import numpy as np

from chapters.shared.algorithm_1 import BOARDS, SIZE_PX
from chapters.shared.general_cameras import KINDS
from chapters.shared.zoom_readings import OF_SEEDS, ZoomCase
from chapters.shared.zoom_rigs import STAGE_ZOOM, ZOOMS, rig_of
from repro.judge.statistics import median_interval

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
    runs = any(condition.items() <= one.items() for one in result.conditions)
    if not runs:
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
    known = [] if values is None else values[np.isfinite(values)]
    return float(np.median(known)) if len(known) else np.nan


def share_kept_out(zoom, at):
    """Median share of the corners kept out that the generic camera has a ray for."""
    rig = rig_of(at).target
    stem = f"{METHODS[1]}.held_out"
    lost, boards = (
        zoom.column(f"{stem}.{what}", zoom=at) for what in ("left_out", "boards")
    )
    shares = 1 - lost / (boards * rig.columns * rig.rows)
    shares = shares[np.isfinite(shares)]
    return float(np.median(shares)) if len(shares) else np.nan


def named(results):
    """Numbers of the prose: name -> text."""
    fov, zoom = results["fig_2_3_fov"], results["table_2_2_redrawn"]
    out = {}
    for at in FOVS_DEG:
        for name in SIMULATED:
            found = of_both(fov, name, fov_deg=at, **PRIMARY)
            for method, estimate in zip(MODELS, found, strict=True):
                out[f"{method}.{name}.{at}"] = short(estimate)
    for at in ZOOMS:
        found = of_both(zoom, HELD_OUT, zoom=at)
        for method, estimate in zip(MODELS, found, strict=True):
            out[f"{method}.zoom.{at}"] = short(estimate)
    found = of_both(zoom, STEPS, zoom=STAGE_ZOOM)
    for method, estimate in zip(MODELS, found, strict=True):
        out[f"{method}.stage"] = short(estimate)
    out |= peer_facts(results)
    out |= recorded_facts(results["ext_calibration_record"])
    out |= fisheye_facts(results["ext_fisheye_scores"])
    out["boards"], out["size"] = str(BOARDS), str(SIZE_PX)
    out["pictures"] = str(zoom.settings["calibration_images"])
    out["noise"] = f"{fov.settings['fov_sweep']['noise']:g}"
    return out


def peer_facts(results):
    """What OpenCV's fisheye model leaves, in words."""
    out = {}
    for at in FOVS_DEG:
        for name in SIMULATED:
            found = of_peer(results["fig_2_3_fisheye"], name, fov_deg=at, **PRIMARY)
            out[f"peer.{name}.{at}"] = short(found)
    for at in ZOOMS:
        found = peer_in_zoom(results, HELD_OUT, at)
        out[f"peer.zoom.{at}"] = short(found)
    found = peer_in_zoom(results, STEPS, STAGE_ZOOM)
    return out | {"peer.stage": short(found)}


def recorded_facts(kept):
    """The widest real camera of the record, and what two methods leave on it."""

    def of(name, condition):
        return float(kept.column(name, **condition)[0])

    widest = max(kept.conditions, key=lambda one: of("widest_deg", one))
    out = {
        "record.name": widest["set"],
        "record.widest": f"{of('widest_deg', widest):.0f}",
    }
    for model in ("opencv_fisheye", "generic"):
        left = of(f"models.{model}.px", widest)
        told = f"{left:.2g} px" if np.isfinite(left) else "no camera"
        out[f"record.{model}"] = told
    return out


def motion_facts(wrong):
    """Ray error of the two-pose method for one unit of error of T_1."""
    out = {"motion.grids": wrong.settings["grids"]}
    for kind in KINDS:
        out[f"motion.{kind}"] = short(typical(wrong, "ray_deg.1", kind=kind))
    return out


def fisheye_facts(scores):
    """What the walk through a fisheye's calibration says, in words."""
    out = {}
    for use in ("inner", "all"):
        for model in ("zhang", "opencv_fisheye", "generic"):
            kept = scores.column(f"{model}.kept_out_px", boards=use)[0]
            told = f"{kept:.2g} px" if np.isfinite(kept) else "no camera"
            out[f"fisheye.{model}.{use}"] = told
        share = scores.column("generic.image_with_ray", boards=use)[0]
        out[f"fisheye.share.{use}"] = f"{100 * share:.0f} %"
        boards = scores.column("boards", boards=use)[0]
        out[f"fisheye.boards.{use}"] = f"{boards:.0f}"
    return out


def short(estimate):
    """A median in words, for a sentence."""
    if estimate is None:
        return "not measured"
    return f"{estimate.value:.2g}" if np.isfinite(estimate.value) else "∞"
