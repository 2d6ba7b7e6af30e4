"""Errors of each method, read from results, and the numbers of the prose."""

import numpy as np

from chapters.shared.zoom_readings import OF_SEEDS, ZoomCase
from chapters.shared.zoom_rigs import rig_of
from repro.judge.statistics import median_and_range, median_interval

METHODS = ("parametric", "generic_well_conditioned")
PRIMARY = {"domain": "px", "extent": "unbounded"}
FOVS_DEG = (60, 120, 150)
NARROW_DEG = FOVS_DEG[0]
SIMULATED = {
    "clean.source.mean_px": "residual, clean (px)",
    "ray_deg": "ray error (deg)",
}
MODELS = {"zhang": METHODS[0], "general": METHODS[1]}
PEER = "opencv_fisheye"
HELD_OUT, STEPS = "held_out.corrected.rms_px", "stage.grid.deviation_mm"


def typical(result, name, **condition):
    """Return the median over the trials; a failed one counts as the worst."""
    return median_interval(result.column(name, **condition))


def of_both(result, name, **condition):
    """Return the same value of Zhang's and of the generic method."""
    return [typical(result, f"{method}.{name}", **condition) for method in METHODS]


def of_peer(result, name, **condition):
    """Return the same value of OpenCV's fisheye model; None where it was not run."""
    if not any(condition.items() <= one.items() for one in result.conditions):
        return None
    return typical(result, f"{PEER}.{name}", **condition)


def peer_in_zoom(results, name, at):
    """Return the value of OpenCV's fisheye model on a set of the converter."""
    found = peer_column(results, name, at)
    return None if found is None else median_interval(found)


def peer_column(results, name, at):
    """Return its value in every simulated run; None where a build has none."""
    case = ZoomCase(
        {key: results[key] for key in OF_SEEDS}, {"interpolation": "smooth"}
    )
    asked = any(
        one["zoom"] == at and one.get("interpolation") == "smooth"
        for key in OF_SEEDS
        for one in results[key].conditions
    )
    return case.column(f"{PEER}.{name}", at) if asked else None


def image_share(values):
    """Return the median share of an image with a ray, over the runs with a camera."""
    return np.nan if values is None else median_and_range(values).value


def held_out_share(zoom, at):
    """Return the median share of held-out corners with a ray of the generic camera."""
    rig = rig_of(at).target
    stem = f"{METHODS[1]}.held_out"
    lost, boards = (
        zoom.column(f"{stem}.{what}", zoom=at) for what in ("left_out", "boards")
    )
    return image_share(1 - lost / (boards * rig.columns * rig.rows))


def named(results):
    """Return the numbers of the prose: name -> text."""
    fov = results["fig_2_3_fov"]
    out = recorded_facts(results["ext_calibration_record"])
    out |= fisheye_facts(results["ext_fisheye_scores"])
    for model, method in MODELS.items():
        found = typical(fov, f"{method}.ray_deg", fov_deg=NARROW_DEG, **PRIMARY)
        out[f"{model}.ray_deg.{NARROW_DEG}"] = short(found)
    return out


def recorded_facts(kept):
    """Return the errors of two methods on the widest real lens of the record."""
    widest = kept.conditions[int(kept.select().column("widest_deg").argmax())]
    return {
        f"record.{model}": in_pixels(kept.column(f"models.{model}.px", **widest)[0])
        for model in ("opencv_fisheye", "generic")
    }


def in_pixels(error):
    """Return an error as text, or that there is no camera."""
    return f"{error:.2g} px" if np.isfinite(error) else "no camera"


def fisheye_facts(scores):
    """Return the share of the image circle with a ray, by the boards used."""
    shares = {
        use: 100 * found.column("generic.image_with_ray")[0]
        for use, found in scores.by("boards").items()
    }
    return {f"fisheye.share.{use}": f"{share:.0f} %" for use, share in shares.items()}


def short(estimate):
    """Return a median as text."""
    if estimate is None:
        return "not measured"
    return f"{estimate.value:.2g}" if np.isfinite(estimate.value) else "∞"
