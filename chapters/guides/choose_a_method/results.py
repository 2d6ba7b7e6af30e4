"""What each method leaves, read from results, and the numbers of the prose."""

from __future__ import annotations

import numpy as np

from chapters.shared.algorithm_1 import BOARDS, SIZE_PX
from chapters.shared.general_cameras import KINDS
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


def typical(result, name, **condition):
    """Median over the trials; a failed one counts as the worst."""
    return median_interval(result.column(name, **condition))


def of_both(result, name, **condition):
    """The same value of Zhang's and of the generic method."""
    return [
        typical(result, f"{method}.{name}", **condition)
        for method in METHODS
    ]


def share_kept_out(zoom, at):
    """Median share of the corners kept out that the generic camera has a ray for."""
    rig = rig_of(at).target
    stem = f"{METHODS[1]}.held_out"
    lost, boards = (
        zoom.column(f"{stem}.{what}", zoom=at)
        for what in ("left_out", "boards")
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
        found = of_both(zoom, "held_out.corrected.rms_px", zoom=at)
        for method, estimate in zip(MODELS, found, strict=True):
            out[f"{method}.zoom.{at}"] = short(estimate)
    found = of_both(zoom, "stage.grid.deviation_mm", zoom=STAGE_ZOOM)
    for method, estimate in zip(MODELS, found, strict=True):
        out[f"{method}.stage"] = short(estimate)
    out |= fisheye_facts(results["ext_fisheye_scores"])
    out["boards"], out["size"] = str(BOARDS), str(SIZE_PX)
    out["pictures"] = str(zoom.settings["calibration_images"])
    out["noise"] = f"{fov.settings['fov_sweep']['noise']:g}"
    return out


def motion_facts(wrong):
    """Ray error of the two-pose method for one unit of error of T_1."""
    out = {"motion.grids": wrong.settings["grids"]}
    for kind in KINDS:
        out[f"motion.{kind}"] = short(
            typical(wrong, "ray_deg.1", kind=kind)
        )
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
    return f"{estimate.value:.2g}" if np.isfinite(estimate.value) else "∞"
