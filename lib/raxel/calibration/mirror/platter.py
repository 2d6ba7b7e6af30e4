"""Pose of a grid that a camera sees only in a flat reference mirror (5.26, 5.27).

A flat mirror of known thickness (in the thesis a hard-disk platter) is on a chessboard.
The board determines the plane of the mirror. The reflected image of a monitor
determines the pose of the monitor's mirror image, and reflection in the plane gives the
pose of the monitor.

Points x of the plane fulfil n.x + d = 0 with n the unit normal towards the camera and
d > 0 the camera's distance. Then T^R has -2 d n (E-5.10); for n.x = d it would be +2 d
n. A reflection changes handedness: the third column of T^R P^v changes its sign, which
moves no point of a flat grid.

Frame: that of the viewing camera. Sources: Bonfort, Sturm, Gargallo 2006, ACCV (grids
in known poses seen in a plane mirror); thesis 5.2.1.
"""

from __future__ import annotations

from collections.abc import Iterable, Sequence
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.calibration.mirror.observations import (
    Sighting,
    magnification,
    normalised,
    sighting,
    target_pose,
    wrong_matches,
)
from raxel.calibration.pose.three_point import (
    motion_of_points,
    moved_pose,
    placed_points,
)
from raxel.calibration.views.correspondence import BoardView
from raxel.calibration.views.dense import DenseView
from raxel.cameras.core.base import Camera
from raxel.errors import CalibrationError, InputError
from raxel.geometry.homography import apply_homography, homography_dlt
from raxel.geometry.least_squares import descend, gauss_newton
from raxel.geometry.poses import vector_from_rotation

# Outlier rejection for a monitor seen in a flat mirror. At the edge of a mirror, and in
# the dark area next to it, some pixels decode to wrong points. The undistorted image of
# a flat monitor in a flat mirror is a homography, which is robust to a few wrong
# pixels. The residuals of the other pixels give the actual decoding error, including
# errors that the decoder cannot estimate.


# Medians, and px as a minimum, beyond which a pixel is an outlier.
OUTLIER_MEDIANS, MIN_OUTLIER_PX, MAX_N_ROUNDS = 6.0, 0.5, 10
# Larger fractions of outliers are an error.
MAX_OUTLIER_FRACTION = 0.25


def flat_view(viewer: Camera, view: BoardView | DenseView) -> BoardView | DenseView:
    """Reject pixels of a view that do not fit a flat monitor in a flat mirror.

    Parameters
    ----------
    viewer : Camera
        Calibrated central camera.
    view : BoardView or DenseView
        View of the monitor in the flat reference mirror.

    Returns
    -------
    BoardView or DenseView
        The view with NaN for pixels whose points do not fit. All others have the
        standard deviation (px) that the image shows.

    Raises
    ------
    CalibrationError
        ``not-flat``: more than a quarter would be rejected.
    """
    pixels = np.asarray(view.pixels, float)
    image = normalised(viewer, pixels)
    seen = np.isfinite(image).all(axis=1)
    scale = np.full(len(pixels), np.nan)
    scale[seen] = magnification(viewer, pixels[seen])
    right = seen & ~wrong_matches(view.points, pixels)
    for _ in range(MAX_N_ROUNDS):
        H = homography_dlt(view.points[right], image[right])
        errors = scale * np.linalg.norm(
            apply_homography(H, view.points) - image, axis=1
        )
        fits = errors <= max(OUTLIER_MEDIANS * np.median(errors[right]), MIN_OUTLIER_PX)
        if np.array_equal(fits, right):
            break
        right = fits
    left, whole = np.count_nonzero(seen & ~right), np.count_nonzero(seen)
    if left > MAX_OUTLIER_FRACTION * whole:
        raise CalibrationError(
            f"{view.name}: {left} of {whole} pixels do not fit a flat monitor in a "
            "flat mirror; take new images of its patterns with a static scene",
            code="not-flat",
        )
    # Two components, from the median of their length.
    sd = np.median(errors[right]) / np.sqrt(2 * np.log(2))
    return view._replace(
        pixels=np.where(right[:, None], pixels, np.nan), sd=np.full(len(pixels), sd)
    )


MAX_N_STEPS, COST_TOL = 50, 1e-12
ROUNDING_PX = 1e-9
# Residual limits of correct correspondences: px, or multiples of their standard
# deviations where these are known and larger.
MAX_RMS_PX, MAX_RMS_SIGMAS = 5.0, 3.0


class FlatMirrorImage(NamedTuple):
    """Hold an image of the flat reference mirror on its chessboard and a grid in it.

    Images of one number share the position.

    Attributes
    ----------
    board, grid : BoardView or DenseView
        Views of the chessboard and of the reflected grid. Poses are in their
        coordinates.
    platter : int
        Number, from 0, of the position of the flat reference mirror.
    position : int
        Number, from 0, of the position of the grid.
    """

    board: object
    grid: object
    platter: int = 0
    position: int = 0


class GridMotion(NamedTuple):
    """Motion between two positions of a grid: shift (3,), mm, of a point of the grid,
    in the camera frame; rotation (3,), rotation vector in rad, in the frame of the
    first position; distance, angle: their lengths; their standard deviations."""

    shift: np.ndarray
    rotation: np.ndarray
    distance: float
    angle: float
    distance_sd: float
    angle_sd: float


class PlatterPoses(NamedTuple):
    """Hold the poses of a grid seen in a flat reference mirror.

    The error of a mirror's plane is common to all grids that were seen in it, so
    covariances between grids matter.

    Attributes
    ----------
    T_camera_grid : ndarray, shape (n, 4, 4)
        Pose for each position of the grid.
    T_camera_board : ndarray, shape (m, 4, 4)
        Pose of the chessboard for each position of the flat reference mirror.
    planes : ndarray, shape (m, 4)
        Planes (n, d) of the reflecting surfaces.
    covariance : ndarray, shape (6 (n + m), 6 (n + m))
        Covariance of (w, s), the errors of the poses as R exp([w]x), t + R s. Grids
        come first; rad and mm.
    rms_px : float
        Root mean square distance between corners and their positions by the fit, px.
    """

    T_camera_grid: np.ndarray
    T_camera_board: np.ndarray
    planes: np.ndarray
    covariance: np.ndarray
    rms_px: float

    def motion(self, first: int, second: int, point: ArrayLike) -> GridMotion:
        """Return the GridMotion between two positions, at a point (2,) of the grid.

        Use a point within those detected. Farther out, the error of the rotation adds
        to that of the shift.
        """
        return grid_motion(self.T_camera_grid, self.covariance, first, second, point)


def reflection(plane: Sequence[float] | NDArray[np.float64]) -> NDArray[np.float64]:
    """Return the reflection in a plane as a matrix.

    Parameters
    ----------
    plane : array_like, shape (4,)
        Plane (n, d) with n.x + d = 0 and unit n; d in mm.

    Returns
    -------
    ndarray, shape (4, 4)
        Matrix T^R.

    References
    ----------
    Thesis (5.26).

    Examples
    --------
    >>> from raxel.calibration import reflection
    >>> T = reflection([0.0, 0.0, -1.0, 300.0])
    >>> print((T @ [10.0, 20.0, 0.0, 1.0])[:3])
    [ 10.  20. 600.]
    """
    n, d = np.asarray(plane, float)[:3], float(plane[3])
    T = np.eye(4)
    T[:3, :3] -= 2 * np.outer(n, n)
    T[:3, 3] = -2 * d * n
    return T


def platter_plane(T_camera_board: ArrayLike, thickness: float) -> NDArray[np.float64]:
    """Return the plane of a flat mirror that lies on a chessboard.

    The normal n points to the camera, at whose side the mirror lies. The thickness is
    subtracted along it.

    Parameters
    ----------
    T_camera_board : array_like, shape (4, 4)
        Pose of the chessboard.
    thickness : float
        Thickness of the mirror, mm.

    Returns
    -------
    ndarray, shape (4,)
        Plane (n, d), d in mm.

    Raises
    ------
    InputError
        The camera is in the plane or behind the surface.
    """
    T = np.asarray(T_camera_board, float)
    n = T[:3, 2] * (-1.0 if T[:3, 2] @ T[:3, 3] > 0 else 1.0)
    d = -n @ T[:3, 3] - thickness
    if not (np.isfinite(thickness) and d > 0):
        raise InputError(
            f"platter: field 'thickness': {thickness} mm puts the surface {d:.1f} mm "
            "in front of the camera; give mm, and tilt the board towards the camera"
        )
    return np.append(n, d)


def reflected_pose(
    T_camera_virtual: ArrayLike, plane: Sequence[float] | NDArray[np.float64]
) -> NDArray[np.float64]:
    """Return the pose of a grid from the pose of its mirror image.

    The function is its own inverse: from the grid it gives the image.

    Parameters
    ----------
    T_camera_virtual : array_like, shape (4, 4)
        Right-handed pose of the image, as from a homography.
    plane : array_like, shape (4,)
        Plane (n, d) of the mirror.

    Returns
    -------
    ndarray, shape (4, 4)
        T_camera_grid, a proper motion.

    References
    ----------
    Thesis (5.27).
    """
    T = reflection(plane) @ np.asarray(T_camera_virtual, float)
    # Reverse the third axis: same points of the plane, other handedness.
    T[:3, 2] *= -1
    return T


def grid_poses_in_platter(
    viewer: Camera, images: Iterable[FlatMirrorImage], thickness: float
) -> PlatterPoses:
    """Estimate poses of a grid in its positions, seen in a flat reference mirror.

    All corners of all images are fitted at once. Each is weighted with its standard
    deviation where all have one. Several images of one position are thus averaged
    correctly.

    Parameters
    ----------
    viewer : Camera
        Calibrated central camera.
    images : iterable of FlatMirrorImage
        Images whose numbers start at 0 without gaps.
    thickness : float
        Distance from the chessboard's plane to the reflecting surface, mm.

    Returns
    -------
    PlatterPoses
        Poses, planes and covariance.

    Raises
    ------
    InputError
        The numbers have a gap.
    CalibrationError
        ``too-few-corners``: too few corners. ``image-before-mirror``: the grid was not
        seen in the mirror. ``poses-misfit``: the fit leaves MAX_RMS_PX.

    References
    ----------
    Thesis 5.2.1. Bonfort, Sturm, Gargallo 2006, ACCV.
    """
    images = list(images)
    boards = [sighting(viewer, p.board, f"platter: image {k}: board")
              for k, p in enumerate(images)]  # fmt: skip
    grids = [sighting(viewer, p.grid, f"platter: image {k}: grid")
             for k, p in enumerate(images)]  # fmt: skip
    platters = _numbered("platter", [p.platter for p in images])
    positions = _numbered("position", [p.position for p in images])
    if not all(np.isfinite(s.sd).all() for s in boards + grids):
        boards, grids = ([s.alike() for s in group] for group in (boards, grids))
    problem = _Problem(boards, grids, platters, positions, float(thickness))
    state, costs, _ = descend(
        problem.evaluate,
        problem.moved,
        problem.start(),
        iterations=MAX_N_STEPS,
        tolerance=COST_TOL,
        rounding=problem.rows * ROUNDING_PX**2,
    )
    return problem.result(state, costs[-1])


def grid_motion(T_camera_grid, covariance, first, second, point):
    """GridMotion between two of n poses, at a point (2,) of the grid.

    T_camera_grid: (n, 4, 4); covariance: (6 m, 6 m), m >= n, of (w, s) as in
    PlatterPoses.
    """
    T, U = T_camera_grid[first], T_camera_grid[second]
    point = np.asarray(point, float)[None]
    shift = (placed_points(point, U) - placed_points(point, T))[0]
    between = T[:3, :3].T @ U[:3, :3]
    rotation = vector_from_rotation(between)
    distance, angle = np.linalg.norm(shift), np.linalg.norm(rotation)
    J = np.zeros((6, len(covariance)))
    J[:3, 6 * first : 6 * first + 6] = -motion_of_points(point, T)[0]
    J[:3, 6 * second : 6 * second + 6] = motion_of_points(point, U)[0]
    # exp(-w1) B exp(w2): to first order B exp(w2 - B^T w1).
    J[3:, 6 * first : 6 * first + 3] = -between.T
    J[3:, 6 * second : 6 * second + 3] = np.eye(3)
    spread = J @ covariance @ J.T
    along = shift / max(distance, 1e-300)
    # Rounding can make the variance of equal errors negative.
    variances = along @ spread[:3, :3] @ along, np.trace(spread[3:, 3:])
    distance_sd, angle_sd = np.sqrt(np.maximum(variances, 0.0)).tolist()
    return GridMotion(
        shift, rotation, float(distance), float(angle), distance_sd, angle_sd
    )


class _Problem(NamedTuple):
    """Least squares of `grid_poses_in_platter`. A state is a stack of poses (n + m, 4,
    4): grids, then boards."""

    boards: list[Sighting]
    grids: list[Sighting]
    platters: np.ndarray
    positions: np.ndarray
    thickness: float

    @property
    def count(self):
        return self.positions.max() + 1

    @property
    def rows(self):
        return 2 * sum(len(s.points) for s in self.boards + self.grids)

    def start(self):
        """Poses of the first image of each number."""
        boards = [
            target_pose(self.boards[np.argmax(self.platters == j)])
            for j in range(self.platters.max() + 1)
        ]
        grids = []
        for i in range(self.count):
            k = np.argmax(self.positions == i)
            plane = platter_plane(boards[self.platters[k]], self.thickness)
            grids.append(reflected_pose(target_pose(self.grids[k]), plane))
            _check_in_front(self.grids[k].points, grids[-1], plane, k)
        return np.stack(grids + boards)

    def moved(self, state, step):
        steps = step.reshape(-1, 6)
        return np.stack([moved_pose(T, s) for T, s in zip(state, steps, strict=True)])

    def evaluate(self, state):
        residuals = np.concatenate([r for r, _ in self._blocks(state)])
        if not np.isfinite(residuals).all():
            return np.inf, None
        return gauss_newton(residuals, lambda: self.jacobian(state))

    def residuals(self, state):
        """(rows,) px, detected minus projected, over the standard deviations."""
        return np.concatenate([r for r, _ in self._blocks(state)])

    def jacobian(self, state):
        """(rows, 6 (n + m)): change of the residuals with (w, s) of each pose."""
        blocks = []
        for residuals, parts in self._blocks(state):
            J = np.zeros((len(residuals), 6 * len(state)))
            for place, part in parts().items():
                J[:, 6 * place : 6 * place + 6] = part
            blocks.append(J)
        return np.concatenate(blocks)

    def _blocks(self, state):
        for seen, j in zip(self.boards, self.platters, strict=True):
            yield self._board_block(seen, self.count + j, state)
        for seen, j, i in zip(self.grids, self.platters, self.positions, strict=True):
            yield self._grid_block(seen, self.count + j, i, state)

    def _board_block(self, seen, board, state):
        T = state[board]
        p = placed_points(seen.points, T)

        def parts():
            return {board: seen.change(p, motion_of_points(seen.points, T))}

        return seen.residuals(p), parts

    def _grid_block(self, seen, board, grid, state):
        T, T_board = state[grid], state[board]
        n, d = np.split(platter_plane(T_board, self.thickness), [3])
        mirror = np.eye(3) - 2 * np.outer(n, n)
        q = placed_points(seen.points, T)
        height = q @ n + d
        p = q - 2 * height[:, None] * n

        def parts():
            # n = +-R e3 and d = -n.t - thickness, for R exp([w]x), t + R s.
            R, sense = T_board[:3, :3], np.sign(n @ T_board[:3, 2])
            n_by = np.zeros((3, 6))
            n_by[:, 0], n_by[:, 1] = -sense * R[:, 1], sense * R[:, 0]
            d_by = -T_board[:3, 3] @ n_by
            d_by[3:] -= n @ R
            lifted = q @ n_by + d_by
            by_board = -2 * (
                lifted[:, None, :] * n[:, None] + height[:, None, None] * n_by
            )
            by_grid = mirror @ motion_of_points(seen.points, T)
            return {grid: seen.change(p, by_grid), board: seen.change(p, by_board)}

        return seen.residuals(p), parts

    def result(self, state, cost):
        grids, boards = state[: self.count], state[self.count :]
        sd = np.concatenate([s.sd for s in self.boards + self.grids])
        errors = self.residuals(state).reshape(-1, 2) * sd[:, None]
        rms_px = float(np.sqrt(np.mean(np.sum(errors**2, axis=1))))
        expected = 0.0
        if not self.boards[0].unknown_sd:
            expected = np.sqrt(2 * np.mean(sd**2))
        if not rms_px <= max(MAX_RMS_PX, MAX_RMS_SIGMAS * expected):
            raise CalibrationError(
                f"platter: corners deviate by {rms_px:.1f} px (rms) from the fitted "
                "poses; check the corner matches (mirror and grid must not move "
                "between images of one number)",
                code="poses-misfit",
            )
        J = self.jacobian(state)
        covariance = np.linalg.inv(J.T @ J)
        if self.boards[0].unknown_sd:
            covariance *= cost / max(self.rows - J.shape[1], 1)
        planes = np.stack([platter_plane(T, self.thickness) for T in boards])
        return PlatterPoses(grids, boards, planes, covariance, rms_px)


def _check_in_front(points, T_camera_grid, plane, index):
    """Raise CalibrationError for a grid that is not in front of the mirror."""
    height = placed_points(points, T_camera_grid) @ plane[:3] + plane[3]
    if not (height > 0).all():
        raise CalibrationError(
            f"platter: image {index}: the mirror image of the grid is "
            f"{-height.min():.0f} mm in front of the mirror; check that its corners "
            "are reflections (or board and grid are exchanged)",
            code="image-before-mirror",
        )


def _numbered(what, numbers):
    numbers = np.array(numbers, int)
    if len(numbers) == 0 or set(numbers) != set(range(numbers.max() + 1)):
        raise InputError(
            f"platter: field '{what}': found {sorted(set(numbers.tolist()))}; number "
            "the positions of the images from 0 without gaps"
        )
    return numbers
