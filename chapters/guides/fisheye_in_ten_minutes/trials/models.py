"""Three calibrations on the same corners, and how much of the picture they know."""

from functools import cache

import numpy as np

from chapters.guides.fisheye_in_ten_minutes.trials.boards import (
    held_at,
    inner_boards,
    places_of,
    rig_of,
    true_corners,
)
from raxel.calibration import BoardView, calibrate_generic, calibrate_zhang
from raxel.calibration.parametric.opencv_fisheye import calibrate_opencv_fisheye
from raxel.cameras.core.base import pixel_grid
from raxel.errors import CalibrationError
from raxel.evaluation import angular_residual, evaluate_camera
from raxel.evaluation.benchmark import scoring_grid
from raxel.evaluation.coverage import board_counts
from raxel.geometry import nearest_rotation

PLANNED, ANYWHERE = "by the plan", "anywhere"
# Boards drawn anywhere, and how often each way of holding them is drawn.
MOST = {"quick": 10, "full": 40}
DRAWS = {"quick": 1, "full": 8}
CORNER_SD_PX = 0.1
# A fit whose rays are this far off at the median has not converged.
LOST_DEG = 1.0


def model_scores(size, fit_views, kept_out, rng):
    """{model: scores} of cameras from `fit_views`, on views that they never saw."""
    rig = rig_of(size)
    return {"boards": len(fit_views)} | {
        name: scored(rig, build, fit_views, kept_out, rng)
        for name, build in MODELS.items()
    }


def scored(rig, build, fit_views, kept_out, rng):
    """Scores of one calibration; where it gives no camera, the reason."""
    camera = rig.camera
    try:
        made = build(fit_views, camera.width, camera.height, rng=rng).camera
    except CalibrationError as refusal:
        return {"reason": str(refusal)}
    fitted = evaluate_camera(made, fit_views)
    kept = evaluate_camera(made, kept_out)
    return {
        "reason": "",
        "fitted_px": fitted.rms_px,
        "kept_out_px": kept.rms_px,
        "kept_out_deg": kept.mean_deg,
        "corners_with_ray": kept.share_with_ray,
        **against_truth(made, camera),
    }


def against_truth(made, true):
    """Share of the lens's pixels with a ray, and the angle to the true rays."""
    pixels = scoring_grid(true.width, true.height)
    truly = true.rays(pixels)
    rays = made.rays(pixels[truly.valid])
    found = rays.directions[rays.valid]
    wanted = truly.directions[truly.valid][rays.valid]
    turned = found @ nearest_rotation(wanted.T @ found).T
    angles = np.degrees(angular_residual(turned, wanted, aligned=False))
    return {
        "image_with_ray": float(rays.valid.mean()),
        "ray_deg": float(np.median(angles)),
    }


MODELS = {
    "zhang": lambda views, *size, rng: calibrate_zhang(views, *size),
    "opencv_fisheye": lambda views, *size, rng: calibrate_opencv_fisheye(views, *size),
    "generic": calibrate_generic,
}


def coverage_trial(size, held, most, rng):
    """Share of the lens's picture under the first 1, 2, ... boards.

    held: PLANNED or ANYWHERE. OpenCV's fisheye model is fitted to corners with noise:
    to as many boards as the plan has, and to as many as its inner rings have.
    """
    rig = rig_of(size)
    places = places_of(size.plan)
    if held == PLANNED:
        poses = [held_at(rig, place, rng) for place in places]
    else:
        poses = rig.draw_poses(rng, most)
    views = [board_at(rig, T, rng) for T in poses]
    seen = np.zeros((rig.camera.height, rig.camera.width), bool)
    shares = []
    for view in views:
        seen |= board_counts([view], rig.camera.width, rig.camera.height) > 0
        shares.append(np.count_nonzero(seen & lit(size)) / lit(size).sum())
    return {
        "shares": np.array(shares),
        "inner": fit_outcome(rig, views[: inner_boards(size.plan)]),
        "all": fit_outcome(rig, views[: len(places)]),
    }


def board_at(rig, T, rng):
    """BoardView of a pose, its corners with the noise of a detector."""
    true = true_corners(rig, T)
    noisy = true + rng.normal(0, CORNER_SD_PX, true.shape)
    board = rig.target
    return BoardView(noisy, board.points(), board.columns, board.rows)


def fit_outcome(rig, views):
    """What became of OpenCV's fisheye model on these boards, and their reach."""
    camera = rig.camera
    rays = camera.rays(np.concatenate([view.pixels for view in views]))
    reach = np.degrees(np.arccos(np.nanmin(rays.directions[:, 2])))
    try:
        made = calibrate_opencv_fisheye(views, camera.width, camera.height)
    except CalibrationError:
        return {"outcome": "refused", "reach_deg": reach}
    off = against_truth(made.camera, camera)["ray_deg"]
    outcome = "right" if off < LOST_DEG else "lost"
    return {"outcome": outcome, "reach_deg": reach, "ray_deg": off}


@cache
def lit(size):
    """Which pixels (height, width) the lens puts light on."""
    camera = rig_of(size).camera
    rays = camera.rays(pixel_grid(camera.width, camera.height))
    return rays.valid.reshape(camera.height, camera.width)
