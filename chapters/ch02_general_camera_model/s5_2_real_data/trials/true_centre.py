"""Two small experiments of section 2.5.2: the true centre, and a homography."""

import numpy as np

from chapters.shared.methods import STARTS
from chapters.shared.three_planes import (
    PRINCIPAL,
    about_principal_ray,
    adjusted_rays,
    central_focal,
    measure,
    score,
    targets,
    view,
)
from raxel.errors import CalibrationError, InputError
from raxel.evaluation import distortion_residual
from raxel.geometry import inverse_pose

SCENE = {
    "law": "equidistance",
    "fov_deg": 120,
    "noise": 0.5,
    "domain": "px",
    "extent": "unbounded",
}
POINTS = 200


def centre_trial(condition, rng):
    """Return the RMS residual with the estimated and with the true centre."""
    data, _ = measure(SCENE, rng)
    true_centre = inverse_pose(data.grids[0])[:3, 3]
    out = {}
    for name, start in STARTS.items():
        try:
            linear = start(data.noisy_points)
            estimated = rms_of(data, linear.centre, linear.T_base_grid)
            true = rms_of(data, true_centre, linear.T_base_grid)
        except (CalibrationError, InputError) as error:
            out[name] = {"failed": error.code}
            continue
        out[name] = {"centre_error_mm": np.linalg.norm(linear.centre - true_centre)}
        for scoring, scales in estimated.items():
            out[name][scoring] = {
                scale: {
                    "estimated_px": rms,
                    "true_px": true[scoring][scale],
                    "ratio": true[scoring][scale] / rms,
                }
                for scale, rms in scales.items()
            }
    return out


def rms_of(data, centre, T_base_grid):
    """Return the RMS residual (px) by scoring and scale, for a given centre.

    The rays and all grids except the base grid are adjusted to that centre.
    """
    directions = adjusted_rays(data, centre, T_base_grid)
    focal = central_focal(data.camera)
    corrected = view(about_principal_ray(directions, data.pixels), focal)
    return {
        scoring: {
            scale: np.sqrt(np.nanmean(lengths**2))
            for scale, lengths in score(corrected, target, data.camera, focal).items()
        }
        for scoring, target in targets(data, focal).items()
    }


def homography_trial(condition, rng):
    """Return the RMS residual (px) of perspective points and of distorted ones."""
    points = rng.uniform(-300, 300, (POINTS, 2))
    H = np.eye(3) + rng.uniform(-1, 1, (3, 3)) * [
        [0.3, 0.3, 200],
        [0.3, 0.3, 200],
        [3e-4, 3e-4, 0],
    ]
    lifted = np.column_stack([points, np.ones(POINTS)]) @ H.T
    seen = lifted[:, :2] / lifted[:, 2:]
    offset = seen / np.abs(seen).max()
    k1 = rng.uniform(0.02, 0.2)
    bent = seen * (1 + k1 * np.sum(offset**2, axis=1, keepdims=True))
    residuals = {
        "without_px": distortion_residual(seen, points),
        "with_px": distortion_residual(bent + PRINCIPAL, points),
    }
    return {
        name: np.sqrt(np.mean(np.sum(vectors**2, axis=1)))
        for name, vectors in residuals.items()
    }
