"""Tables of rays and corners of a bent lens, smoothed, and scored against the truth."""

import numpy as np

from chapters.shared.central import SETTINGS, SIDE, SIZE_PX, T_BASE_CAMERA, radial_lens
from raxel.calibration import (
    adjust_consistent,
    adjust_spline,
    linear_cgsp,
    smoothed_rays,
)
from raxel.cameras import RaySplineCamera, control_shape
from raxel.evaluation import distortion_residual
from raxel.geometry import nearest_rotation, pose

FOV_DEG = 90.0
BENT_PX = 1.0  # amplitude of the waves of the bent lens
SPACING_PX = 80.0
TRIALS = {"quick": 1, "full": 50}
CONDITIONS = (
    {"lens": "bent", "noise": 0.25, "grids": 3},
    {"lens": "bent", "noise": 0.5, "grids": 3},
    {"lens": "bent", "noise": 1.0, "grids": 3},
    {"lens": "bent", "noise": 0.5, "grids": 10},
    {"lens": "radial", "noise": 0.5, "grids": 3},
)
METHODS = ("table", "formula", "smooth", "direct")
SMOOTH_SETTINGS = SETTINGS | {
    "field_of_view_deg": FOV_DEG,
    "bent_lens": "waves of 1 px, about half as long as the image, on the radial lens",
}


def bent_lens():
    """The radial lens with waves in its image that no parametric model describes."""
    shape = control_shape(SIZE_PX, SIZE_PX, SPACING_PX)
    v, u = np.mgrid[: shape[0], : shape[1]] / shape[1]
    waves = np.stack([np.sin(1 + 9 * u + 4 * v), np.cos(2 + 8 * v - 5 * u)], axis=2)
    return RaySplineCamera(
        radial_lens(FOV_DEG), SPACING_PX, BENT_PX * waves, SIZE_PX, SIZE_PX
    )


LENSES = {"bent": bent_lens, "radial": lambda: radial_lens(FOV_DEG)}


def calibrate(scene):
    """Directions (N, 3) in the camera's axes by method, and the smooth fits.

    All start from the same CGSP solution with adjusted centre and poses.
    """
    start = linear_cgsp(scene.noisy, side=SIDE)
    found = adjust_consistent(scene.noisy, None, start.centre, start.T_base_grid)
    to_camera = T_BASE_CAMERA[:3, :3].T
    table = found.directions @ to_camera.T
    smooth = smoothed_rays(scene.pixels, table, SIZE_PX, SIZE_PX)
    # Axes of the trend, in which the grid poses and the field are adjusted.
    R = smooth.camera.T_camera_trend[:3, :3].T @ to_camera
    posed = pose(R, -R @ found.centre) @ found.T_base_grid
    grids = [(scene.pixels, points) for points in scene.noisy]
    direct = adjust_spline(smooth.trend, posed, grids, SIZE_PX, SIZE_PX)
    directions = {
        "table": table,
        "formula": smooth.trend.rays(scene.pixels).directions,
        "smooth": smooth.camera.rays(scene.pixels).directions,
        "direct": direct.camera.rays(scene.pixels).directions,
    }
    return directions, {"smooth": smooth, "direct": direct}


def off_px(camera, pixels, directions):
    """Image positions of the rays minus their pixels (N, 2), after the best rotation of
    all rays."""
    R = nearest_rotation(camera.rays(pixels).directions.T @ directions)
    return camera.project(directions @ R.T).pixels - pixels


def left_px(camera, pixels, directions):
    """Residual (N, 2) of the corrected view, px, after the best homography."""
    focal = radial_lens(FOV_DEG).K[0, 0]
    exact = camera.rays(pixels).directions
    R = nearest_rotation(exact.T @ directions)
    metric, corrected = (focal * d[:, :2] / d[:, 2:] for d in (exact, directions @ R.T))
    return distortion_residual(corrected, metric)


def rms(vectors):
    """Root mean square length of vectors (N, 2)."""
    return float(np.sqrt(np.mean(np.sum(vectors**2, axis=1))))


def normalised(off, covariance):
    """Mean squared error relative to the predicted variance, per coordinate."""
    squares = np.einsum("ni,nij,nj->n", off, np.linalg.inv(covariance), off)
    return float(np.mean(squares) / 2)


def scores(scene, directions, fits):
    """Errors of each method in both measures, and relative to the predicted ones."""
    out = {}
    for method, rays in directions.items():
        off = off_px(scene.camera, scene.pixels, rays)
        out[method] = {
            "off_px": rms(off),
            "left_px": rms(left_px(scene.camera, scene.pixels, rays)),
        }
        if method in fits:
            stated = fits[method].camera.pixel_covariance(scene.pixels)
            out[method]["normalised"] = normalised(off, stated)
            out[method]["cells"] = fits[method].cells
    return out
