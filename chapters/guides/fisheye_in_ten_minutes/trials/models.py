"""Three calibrations from the same corners, and their coverage."""

import numpy as np

from chapters.guides.fisheye_in_ten_minutes.trials.boards import rig_of
from raxel.calibration import calibrate_generic, calibrate_zhang
from raxel.calibration.parametric.opencv_fisheye import calibrate_opencv_fisheye
from raxel.errors import CalibrationError
from raxel.evaluation import angular_residual, evaluate_camera
from raxel.evaluation.benchmark import scoring_grid
from raxel.geometry import nearest_rotation


def model_scores(size, fit_views, kept_out, rng):
    """Return {model: scores} of cameras from `fit_views`, on held-out views."""
    rig = rig_of(size)
    return {"boards": len(fit_views)} | {
        name: scored(rig, build, fit_views, kept_out, rng)
        for name, build in MODELS.items()
    }


def scored(rig, build, fit_views, kept_out, rng):
    """Return the scores of one calibration, or the code of its error."""
    camera = rig.camera
    try:
        made = build(fit_views, camera.width, camera.height, rng=rng).camera
    except CalibrationError as refusal:
        return {"reason": refusal.code}
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
    """Return the share of the lens's pixels with a ray, and the angle to true rays."""
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
