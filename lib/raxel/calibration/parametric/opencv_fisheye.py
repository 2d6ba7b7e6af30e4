"""OpenCV's own calibration of a fisheye lens: the peer that users of wide lenses know.

Its model is Kannala and Brandt's symmetric one with k1 = 1: r = theta + k2 theta^3 +
... + k5 theta^9, fitted by minimising the reprojection error. Source: J.
Kannala and S. Brandt, IEEE TPAMI 28(8), 2006, doi:10.1109/TPAMI.2006.153; the fit is
`cv2.fisheye.calibrate`.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.parametric.zhang import found_corners
from raxel.cameras.lenses.kannala_brandt import KannalaBrandtCamera
from raxel.errors import CalibrationError, InputError
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import pose, rotation_from_vector

MAX_STEPS, MIN_STEP = 200, 1e-10
# Angles that the longer side of the image may span, in radians: OpenCV's own start
# (pi) does not lead everywhere, and a user would try others.
SPANS = (np.pi, 2.0, 1.2)


class FisheyeCalibration(NamedTuple):
    """camera; T_camera_grid (n, 4, 4), one pose per view in the board's unit; rms_px:
    root mean square distance of the corners from the model's.
    """

    camera: KannalaBrandtCamera
    T_camera_grid: np.ndarray
    rms_px: float


def calibrate_opencv_fisheye(views, width, height):
    """Kannala-Brandt camera with four radial terms, fitted by OpenCV to planar boards.

    views: two or more BoardViews or DenseViews, of which only the corners (the
    lattice's pixels) that were found count, all alike;
    width, height: the image in px. There is no skew. Of fits from three focal lengths,
    the one with the smallest residual is returned. OpenCV begins with a homography of
    each board in a pinhole's image plane, so boards that reach 90 degrees from the axis
    can keep it from converging.

    Raises InputError as `calibrate_zhang` does; CalibrationError: OpenCV refuses every
    start, or what it fitted is no camera.
    """
    views = [found_corners(view) for view in views]
    if len(views) < 2:
        raise InputError(
            f"OpenCV's fisheye model: {len(views)} view given; two or more boards at"
            " different tilts are needed"
        )
    fits, faults = [], []
    for span in SPANS:
        try:
            fits.append(_fitted(views, width, height, max(width, height) / span))
        except CalibrationError as error:
            faults.append(error)
    if not fits:
        raise faults[0]
    return min(fits, key=lambda fit: fit.rms_px)


def _fitted(views, width, height, focal_px):
    """FisheyeCalibration of (pixels, points) pairs, from a first focal length in px."""
    import cv2

    flat = [on_plane(points)[None] for _, points in views]
    corners = [pixels[None] for pixels, _ in views]
    start = np.diag([focal_px, focal_px, 1.0])
    start[:2, 2] = (width - 1) / 2, (height - 1) / 2
    flags = (
        cv2.CALIB_RECOMPUTE_EXTRINSIC
        | cv2.CALIB_FIX_SKEW
        | cv2.CALIB_USE_INTRINSIC_GUESS
    )
    enough = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, MAX_STEPS, MIN_STEP)
    try:
        rms, K, k, turns, shifts = cv2.fisheye.calibrate(
            flat, corners, (int(width), int(height)), start, np.zeros((4, 1)),
            flags=flags, criteria=enough,
        )  # fmt: skip
    except cv2.error as error:
        message = " ".join(str(error.err).split())
        raise CalibrationError(
            f"OpenCV's fisheye model: it refuses: {message}", code="diverged"
        ) from None
    numbers = np.concatenate([np.ravel(part) for part in (rms, K, k, turns, shifts)])
    if not np.isfinite(numbers).all():
        raise CalibrationError(
            "OpenCV's fisheye model: the fit diverged", code="diverged"
        )
    rotations = rotation_from_vector(np.reshape(turns, (-1, 3)))
    poses = pose(rotations, np.reshape(shifts, (-1, 3)))
    return FisheyeCalibration(_camera(K, k, width, height), poses, float(rms))


def _camera(K, k, width, height):
    try:
        return KannalaBrandtCamera(
            [1.0, *np.ravel(k)], (K[0, 0], K[1, 1]), K[:2, 2], width, height
        )
    except InputError as error:
        raise CalibrationError(
            f"OpenCV's fisheye model: what it fitted is no camera: {error}",
            code="no-camera",
        ) from None
