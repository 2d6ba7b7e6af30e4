"""Calibrations by OpenCV: Zhang's method and the fisheye model.

OpenCV's calibration of fisheye lenses is the reference that users of wide lenses know.
Its model is Kannala and Brandt's symmetric one with k1 = 1: r = theta + k2 theta^3 +
... + k5 theta^9, fitted by minimising the reprojection error. Source: J. Kannala and S.
Brandt, IEEE TPAMI 28(8), 2006, doi:10.1109/TPAMI.2006.153; the fit is
`cv2.fisheye.calibrate`.
"""

from __future__ import annotations

from collections.abc import Sequence
from typing import NamedTuple

import cv2
import numpy as np

from raxel.calibration.views.correspondence import BoardView, check_view
from raxel.calibration.views.dense import DenseView
from raxel.cameras.lenses.fisheye import KannalaBrandtCamera
from raxel.cameras.lenses.perspective import PerspectiveCamera
from raxel.errors import CalibrationError, InputError
from raxel.geometry.homography import homography_dlt
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import pose, rotation_from_vector

# The thesis's "standard perspective method": Zhang's calibration, through OpenCV. A
# pinhole camera with two radial terms (2.1-2.4) and no tangential ones, fitted to views
# of a plane by minimising the reprojection error. Source: Z. Zhang, A flexible new
# technique for camera calibration, IEEE TPAMI 22(11), 2000, doi:10.1109/34.888718.


MAX_ZHANG_STEPS, MIN_ZHANG_STEP = 200, 1e-8
MIN_N_CORNERS = 6  # twelve equations, for a view's six pose parameters and the camera


class ZhangCalibration(NamedTuple):
    """Hold a camera from `calibrate_zhang`.

    Attributes
    ----------
    camera : PerspectiveCamera
        The camera.
    T_camera_grid : ndarray, shape (n, 4, 4)
        One pose per view, in the unit of the board.
    rms_px : float
        Root mean square distance of the corners from those of the model, px.
    """

    camera: PerspectiveCamera
    T_camera_grid: np.ndarray
    rms_px: float


def calibrate_zhang(
    views: Sequence[BoardView | DenseView], width: int, height: int
) -> ZhangCalibration:
    """Calibrate a pinhole camera with two radial terms from views of a planar board.

    Focal lengths and the principal point are free. Three or more views are advised.

    Parameters
    ----------
    views : sequence of BoardView or DenseView
        Two or more views. Only the corners (the pixels of the lattice) that were found
        count, all alike.
    width, height : int
        Size of the image, px.

    Returns
    -------
    ZhangCalibration
        The camera and the poses.

    Raises
    ------
    InputError
        If there is one view only, or corners of a view are not finite, fewer than six,
        or on a line.
    CalibrationError
        If the fit is no camera. Parallel boards, which do not determine the focal
        length, may lead to any camera: `raxel.evaluation.focal_length` tests them.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.calibration import BoardView, calibrate_zhang
    >>> from raxel.cameras import PerspectiveCamera
    >>> from raxel.geometry import pose, rotation_from_vector, transform
    >>> from raxel.sets import Chessboard
    >>> K = np.array([[800.0, 0, 320], [0, 800.0, 240], [0, 0, 1]])
    >>> true = PerspectiveCamera(K, (0, 0), width=640, height=480)
    >>> points = Chessboard(9, 6, 20.0).points()
    >>> solid = np.column_stack([points, np.zeros(54)])
    >>> views = []
    >>> for tilt in ([0.4, 0, 0], [-0.4, 0.1, 0], [0, 0.4, 0], [0.1, -0.4, 0]):
    ...     T = pose(rotation_from_vector(tilt), [-80.0, -50.0, 400.0])
    ...     pixels = true.project(transform(T, solid)).pixels
    ...     views.append(BoardView(pixels, points, 9, 6))
    >>> found = calibrate_zhang(views, 640, 480)
    >>> found.camera.K.round(2).tolist()
    [[800.0, 0.0, 320.0], [0.0, 800.0, 240.0], [0.0, 0.0, 1.0]]
    """
    views = [found_corners(view) for view in views]  # type: ignore[misc]
    if len(views) < 2:
        raise InputError(
            f"Zhang's method: found {len(views)} view; give two or more boards at "
            "different tilts"
        )
    flat = [on_plane(xy).astype(np.float32) for _, xy in views]  # type: ignore[misc]
    corners = [pixels.astype(np.float32)[:, None] for pixels, _ in views]  # type: ignore[misc]
    flags = cv2.CALIB_ZERO_TANGENT_DIST | cv2.CALIB_FIX_K3
    # Smallest relative step of the parameters: OpenCV's default stops after 30 steps,
    # converged or not.
    criteria = (
        cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS,
        MAX_ZHANG_STEPS,
        MIN_ZHANG_STEP,
    )
    try:
        rms, K, distortion, turns, shifts = cv2.calibrateCamera(
            flat, corners, (int(width), int(height)), None, None,
            flags=flags, criteria=criteria,
        )  # fmt: skip
    except cv2.error as error:
        raise CalibrationError(
            f"Zhang's method: OpenCV reports an error ({error.err}); check the corners",
            code="diverged",
        ) from None
    # OpenCV uses single precision: exact corners return to about 1e-5 px.
    radial = np.ravel(distortion)[:2]
    if not (np.isfinite(K).all() and np.isfinite(radial).all() and np.isfinite(rms)):
        raise CalibrationError(
            "Zhang's method: the fit diverged; tilt the boards more", code="diverged"
        )
    camera = PerspectiveCamera(K, radial, width, height)
    rotations = rotation_from_vector(np.array(turns).reshape(-1, 3))
    poses = pose(rotations, np.array(shifts).reshape(-1, 3))
    return ZhangCalibration(camera, poses, float(rms))


def found_corners(view: BoardView | DenseView) -> tuple[np.ndarray, np.ndarray]:
    """Return the corners of a view that were found.

    Parameters
    ----------
    view : BoardView or DenseView
        The view.

    Returns
    -------
    pixels, points : ndarray, shape (N, 2)
        Corners in the image, px, and on the board.

    Raises
    ------
    InputError
        If there are fewer than six, or they do not determine a homography.
    """
    view = check_view(view)
    found = np.isfinite(view.pixels[:, 0])
    pixels, points = view.pixels[found], view.points[found]
    if len(pixels) < MIN_N_CORNERS:
        raise InputError(
            f"{view.name or 'board'}: corners: found {len(pixels)}; give at least "
            f"{MIN_N_CORNERS}"
        )
    try:
        homography_dlt(points, pixels)
    except InputError as error:
        raise InputError(f"{view.name or 'board'}: corners: {error}") from None
    return pixels, points


MAX_STEPS, MIN_STEP = 200, 1e-10
# Initial angles of view along the longer side of the image: OpenCV's own start (pi)
# does not always converge.
START_SPANS_RAD = (np.pi, 2.0, 1.2)


class FisheyeCalibration(NamedTuple):
    """Hold a camera from `calibrate_opencv_fisheye`.

    Attributes
    ----------
    camera : KannalaBrandtCamera
        The camera.
    T_camera_grid : ndarray, shape (n, 4, 4)
        One pose per view, in the unit of the board.
    rms_px : float
        Root mean square distance of the corners from those of the model, px.
    """

    camera: KannalaBrandtCamera
    T_camera_grid: np.ndarray
    rms_px: float


def calibrate_opencv_fisheye(
    views: Sequence[BoardView | DenseView], width: int, height: int
) -> FisheyeCalibration:
    """Calibrate a Kannala-Brandt camera with four radial terms by OpenCV.

    There is no skew. Of fits from three focal lengths, the one with the smallest
    residual is returned. OpenCV starts with a homography of each board in the image
    plane of a pinhole. Therefore boards that reach 90 degrees from the axis can prevent
    convergence.

    Parameters
    ----------
    views : sequence of BoardView or DenseView
        Two or more views. Only the corners (the pixels of the lattice) that were found
        count, all alike.
    width, height : int
        Size of the image, px.

    Returns
    -------
    FisheyeCalibration
        The camera and the poses.

    Raises
    ------
    InputError
        As `calibrate_zhang`.
    CalibrationError
        If OpenCV fails from every start, or its fit is no camera.
    """
    views = [found_corners(view) for view in views]  # type: ignore[misc]
    if len(views) < 2:
        raise InputError(
            f"OpenCV's fisheye model: found {len(views)} view; give two or more boards "
            "at different tilts"
        )
    fits, faults = [], []
    for span in START_SPANS_RAD:
        try:
            fits.append(_fitted(views, width, height, max(width, height) / span))
        except CalibrationError as error:
            faults.append(error)
    if not fits:
        raise faults[0]
    return min(fits, key=lambda fit: fit.rms_px)


def _fitted(views, width, height, focal_px):
    """FisheyeCalibration of (pixels, points) pairs, from an initial focal length,
    px."""
    flat = [on_plane(points)[None] for _, points in views]
    corners = [pixels[None] for pixels, _ in views]
    start = np.diag([focal_px, focal_px, 1.0])
    start[:2, 2] = (width - 1) / 2, (height - 1) / 2
    flags = (
        cv2.CALIB_RECOMPUTE_EXTRINSIC
        | cv2.CALIB_FIX_SKEW
        | cv2.CALIB_USE_INTRINSIC_GUESS
    )
    criteria = (cv2.TERM_CRITERIA_COUNT + cv2.TERM_CRITERIA_EPS, MAX_STEPS, MIN_STEP)
    try:
        rms, K, k, turns, shifts = cv2.fisheye.calibrate(
            flat, corners, (int(width), int(height)), start, np.zeros((4, 1)),
            flags=flags, criteria=criteria,
        )  # fmt: skip
    except cv2.error as error:
        message = " ".join(str(error.err).split())
        raise CalibrationError(
            f"OpenCV's fisheye model: OpenCV reports an error ({message}); check the "
            "corners, or tilt the boards more",
            code="diverged",
        ) from None
    numbers = np.concatenate([np.ravel(part) for part in (rms, K, k, turns, shifts)])
    if not np.isfinite(numbers).all():
        raise CalibrationError(
            "OpenCV's fisheye model: the fit diverged; tilt the boards more",
            code="diverged",
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
            f"OpenCV's fisheye model: no camera has the fitted parameters ({error}); "
            "tilt the boards more",
            code="no-camera",
        ) from None
