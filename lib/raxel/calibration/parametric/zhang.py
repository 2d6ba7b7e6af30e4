"""The thesis's "standard perspective method": Zhang's calibration, through OpenCV.

A pinhole with two radial terms (2.1-2.4), no tangential ones, fitted to views of a
plane by minimising the reprojection error. Source: Z. Zhang, A flexible new technique
for camera calibration, IEEE TPAMI 22(11), 2000, doi:10.1109/34.888718.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.views.correspondence import check_view
from raxel.calibration.views.parallel import refuse_parallel
from raxel.cameras.lenses.perspective import PerspectiveCamera
from raxel.errors import CalibrationError, InputError
from raxel.geometry.homography import homography_dlt
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import pose, rotation_from_vector

MAX_STEPS, MIN_STEP = 200, 1e-8
MIN_CORNERS = 6  # a view's six pose parameters and something left to fit


class ZhangCalibration(NamedTuple):
    """camera; T_camera_grid (n, 4, 4), one pose per view in the board's unit; rms_px:
    root mean square distance of the corners from the model's.
    """

    camera: PerspectiveCamera
    T_camera_grid: np.ndarray
    rms_px: float


def calibrate_zhang(views, width, height):
    """Pinhole camera with two radial terms from views of a planar board.

    views: two or more BoardViews or DenseViews (three or more advised), of which only
    the corners (the lattice's pixels) that were found count, all alike; width, height:
    the image in px. Focal lengths and the principal point are free.

    Raises InputError: one view only, corners that are not finite, fewer than six of a
    view, or on a line; CalibrationError: all boards parallel, or a fit that is no
    camera.
    """
    import cv2

    views = [found_corners(view) for view in views]
    if len(views) < 2:
        raise InputError(
            f"Zhang's method: {len(views)} view given; two or more boards at different"
            " tilts are needed"
        )
    flat = [on_plane(xy).astype(np.float32) for _, xy in views]
    corners = [pixels.astype(np.float32)[:, None] for pixels, _ in views]
    flags = cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_K3
    # Until a step is smaller than this share of the parameters: OpenCV's default stops
    # after 30 steps, converged or not.
    enough = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, MAX_STEPS, MIN_STEP)
    try:
        rms, K, distortion, turns, shifts = cv2.calibrateCamera(
            flat, corners, (int(width), int(height)), None, None,
            flags=flags, criteria=enough,
        )  # fmt: skip
    except cv2.error as error:
        raise CalibrationError(
            f"Zhang's method: OpenCV refuses: {error.err}", code="diverged"
        ) from None
    # OpenCV takes single precision only: exact corners come back to about 1e-5 px.
    radial = np.ravel(distortion)[:2]
    if not (np.isfinite(K).all() and np.isfinite(radial).all() and np.isfinite(rms)):
        raise CalibrationError(
            "Zhang's method: the fit diverged; tilt the boards more", code="diverged"
        )
    camera = PerspectiveCamera(K, radial, width, height)
    rotations = rotation_from_vector(np.array(turns).reshape(-1, 3))
    refuse_parallel(rotations, "Zhang's method", needed=2)
    poses = pose(rotations, np.array(shifts).reshape(-1, 3))
    return ZhangCalibration(camera, poses, float(rms))


def found_corners(view):
    """(pixels, points), (N, 2) each, of the corners that were found."""
    view = check_view(view)
    found = np.isfinite(view.pixels[:, 0])
    pixels, points = view.pixels[found], view.points[found]
    if len(pixels) < MIN_CORNERS:
        raise InputError(
            f"{view.name or 'board'}: corners: found {len(pixels)}; at least"
            f" {MIN_CORNERS} are needed"
        )
    try:
        homography_dlt(points, pixels)
    except InputError as error:
        raise InputError(f"{view.name or 'board'}: corners: {error}") from None
    return pixels, points
