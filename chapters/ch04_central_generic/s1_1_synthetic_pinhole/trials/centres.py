"""Pictures on the base grid, and the centres that two solvers find in them."""

from functools import partial

import numpy as np

from chapters.ch04_central_generic.s1_1_synthetic_pinhole.trials.cameras import (
    CAMERAS,
    camera_of,
    draw_points,
)
from chapters.shared.wide_angle import (
    CENTRE_MM,
    SETTINGS,
    SIDE,
    draw_poses,
    draw_scene,
    wide_lens,
)
from raxel.calibration import linear_cgsp
from raxel.errors import CalibrationError
from raxel.geometry import apply_homography, homography_dlt
from raxel.geometry.homography import normalising
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

# CGSP's linear stage with two plane-based solvers.
SOLVERS = {"CGSP": linear_cgsp, "CGSP circle": partial(linear_cgsp, pinhole="circle")}
TRIALS = {"quick": 8, "full": 60}
NOISES_PX = {"quick": [0.1, 0.5, 2.0], "full": [0.1, 0.25, 0.5, 1.0, 2.0]}
FIELDS_DEG = {"quick": [60, 150], "full": [60, 90, 120, 150]}
NOISE_PX = 0.5


def picture_trial(condition, rng):
    """How far the picture on the base grid is from a homography of each grid."""
    points = draw_points(camera_of(condition["camera"]), draw_poses(rng), rng)
    largest, in_mm = [], []
    scale = normalising(points[0])[0, 0]
    for own in points[1:]:
        H = homography_dlt(own, points[0])
        gap = np.linalg.norm(apply_homography(H, own) - points[0], axis=1)
        in_mm.append(gap.max())
        largest.append(scale * gap.max())
    return {"residual": max(largest), "residual_mm": max(in_mm)}


@experiment("exp_c4_synth_pinhole", artefact="fig_4_1")
def synthetic_pictures(effort):
    """Noise-free cameras: is the picture on the base grid one of a pinhole?"""
    return Plan(picture_trial, crossed(camera=CAMERAS), TRIALS[effort], SETTINGS)


def centre_off(solver, points):
    """Distance (mm) of the found centre from the true one; None if refused."""
    try:
        found = SOLVERS[solver](points, side=SIDE)
    except CalibrationError:
        return None
    return float(np.linalg.norm(found.centre - CENTRE_MM))


def noisy_trial(condition, rng):
    """The centre's error of both solvers, with noise."""
    fov_deg = condition["fov_deg"]
    seen = draw_scene(wide_lens(fov_deg), condition["noise_px"], rng)
    return {solver: centre_off(solver, seen.noisy) for solver in SOLVERS}


@experiment("exp_c4_sm_vs_wl", artefact="sec_4_1_1")
def pinhole_methods(effort):
    """Sturm-Maybank and the circles on the same noisy points."""
    conditions = [{"fov_deg": 100, "noise_px": noise} for noise in NOISES_PX[effort]]
    conditions += [{"fov_deg": fov, "noise_px": NOISE_PX} for fov in FIELDS_DEG[effort]]
    return Plan(noisy_trial, conditions, TRIALS[effort], SETTINGS)


def count_trial(condition, rng):
    """Equations of n grids: how many unknowns of the conic they leave open."""
    points = draw_points(
        camera_of(CAMERAS[0]), draw_poses(rng, condition["grids"]), rng
    )
    try:
        found = linear_cgsp(points, side=SIDE)
    except CalibrationError:
        return {"found": 0, "centre_mm": None}
    off = np.linalg.norm(found.centre - CENTRE_MM)
    return {"found": 1, "centre_mm": float(off)}


@experiment("sec_4_1_1_grids", artefact="sec_4_1_1")
def fewest_grids(effort):
    """Two grids, three, four: from when on is there a centre?"""
    return Plan(count_trial, crossed(grids=(2, 3, 4)), TRIALS[effort], SETTINGS)
