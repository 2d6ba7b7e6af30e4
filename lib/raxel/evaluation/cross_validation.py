"""Errors of a camera on boards that it was not fitted to: only poses are refitted.

The pose of a board is fitted twice, the same way for every model. Angles are evaluated
at the pose that fits the rays of its corners best: least squares of the sines of the
angles between rays and board corners. Distances in px are evaluated at the pose with
the smallest reprojection error, starting from there. Each error is thus the smallest
that the camera allows. At the other pose a camera that does not fit would have larger
errors.

A corner is scored where the camera has a ray for it and can project it at the first
pose. All others are counted, which shows how few corners a score is based on.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable, Sequence
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.calibration.pose.three_point import (
    pose_of_spread_triples,
    refine_pose_ray_point,
)
from raxel.calibration.views.correspondence import (
    BoardShape,
    BoardView,
    board_points,
    check_view,
)
from raxel.calibration.views.dense import DenseView
from raxel.cameras.core.base import Camera
from raxel.errors import CalibrationError, InputError
from raxel.evaluation.diagnoses import known
from raxel.evaluation.distortion import refine_pose_in_pixels
from raxel.features.detector import Detection, Partial
from raxel.features.lattice import symmetries
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import transform
from raxel.sets.reference import ReferenceCorners

# Corners of one board compared with its true corners: position and order.


BORDER_PX = 4.0  # a corner this near to the edge of the image may be missing


def in_place(corners: ArrayLike, truth: ArrayLike, reach_px: float) -> bool:
    """Return whether every corner is at its own true corner.

    A corner must be nearer than `reach_px` to its own true corner, and nearer to it
    than to any other. On a fine lattice a neighbour may be within reach, too.

    Parameters
    ----------
    corners, truth : array_like, shape (N, 2)
        Detected and true corners, px.
    reach_px : float
        Limit of the distance, px.

    Returns
    -------
    bool
        False also for another number of corners, and where one is not finite.

    Examples
    --------
    >>> from raxel.evaluation import in_place
    >>> truth = [[0.0, 0.0], [10.0, 0.0]]
    >>> in_place([[0.2, 0.1], [10.0, 0.3]], truth, reach_px=1.0)
    True
    >>> in_place([[10.0, 0.0], [0.0, 0.0]], truth, reach_px=1.0)
    False
    """
    corners, truth = np.asarray(corners, float), np.asarray(truth, float)
    if corners.shape != truth.shape or not np.isfinite(corners).all():
        return False
    apart = distances(corners, truth)
    own = np.arange(len(truth))
    return bool(
        (apart[own, own] < reach_px).all() and (apart.argmin(axis=1) == own).all()
    )


def in_order_of(
    truth: np.ndarray, corners: np.ndarray, columns: int, rows: int
) -> np.ndarray:
    """Return corners row by row, started where they fit the true ones best.

    A detector without clicks may start at any outer corner and follow the columns in
    either direction. Rows stay rows, also on a square board.

    Parameters
    ----------
    truth, corners : ndarray, shape (rows * columns, 2)
        True and detected corners, px.
    columns, rows : int
        Number of interior corners along each direction.

    Returns
    -------
    ndarray, shape (rows * columns, 2)
        The detected corners, reordered.
    """
    upright = list(symmetries(corners, columns, rows))[:4]
    return min(
        (order for order, _ in upright),
        key=lambda order: np.linalg.norm(order - truth, axis=1).sum(),
    )


def share_in_order(
    partial: Partial | None,
    truth: np.ndarray,
    columns: int,
    shape: tuple[int, ...],
    reach_px: float,
) -> float:
    """Return the share of the true corners in the image that a `Partial` has in order.

    A corner is in order if it is nearer than `reach_px` to its true corner. One of the
    eight symmetries of a lattice, and one shift, map its row and column to that corner.
    Of these mappings the one that fits most corners counts.

    Parameters
    ----------
    partial : Partial or None
        What a rejected `Detection` holds; None: nothing is in order.
    truth : ndarray, shape (rows * columns, 2)
        True corners, px, row by row.
    columns : int
        Number of interior corners along a row.
    shape : tuple of int
        Shape of the image, (height, width).
    reach_px : float
        Limit of the distance, px.

    Returns
    -------
    float
        Share, 0 to 1.
    """
    size = np.array(shape[1::-1])
    inside = np.all((truth > BORDER_PX) & (truth < size - 1 - BORDER_PX), axis=1)
    if partial is None or not inside.any():
        return 0.0
    apart = distances(partial.corners, truth)
    nearest = apart.argmin(axis=1)
    good = (apart.min(axis=1) < reach_px) & inside[nearest]
    place = np.column_stack(np.divmod(nearest[good], columns))
    best = 0
    for turned in (partial.indices[good], partial.indices[good][:, ::-1]):
        for sign in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            shifts = place - turned * sign
            _, counts = np.unique(shifts, axis=0, return_counts=True)
            best = max(best, counts.max(initial=0))
    return float(best / inside.sum())


def distances(points: np.ndarray, others: np.ndarray) -> NDArray[np.float64]:
    """Return the distances between all points and all others.

    Parameters
    ----------
    points : ndarray, shape (N, 2)
        Points, px.
    others : ndarray, shape (M, 2)
        Other points, px.

    Returns
    -------
    ndarray, shape (N, M)
        Distances, px. Without others every point is infinitely far: shape (N, 1).
    """
    if not len(others):
        return np.full((len(points), 1), np.inf)
    return np.linalg.norm(points[:, None] - others[None], axis=2)


# Detected boards compared with reference corners of a set: errors and correctness.


def corner_errors(
    detection: Detection, reference: ReferenceCorners
) -> np.ndarray | None:
    """Return the distances of a detection from the N certain reference corners.

    The symmetry of the lattice with the smallest maximum distance counts, since the
    reference does not define which corner is first. Mirrored ones are allowed. A corner
    that the board lacks has no distance, so that fewer than N are returned.

    Parameters
    ----------
    detection : Detection
        The detected corners.
    reference : ReferenceCorners
        Reference corners of the same image.

    Returns
    -------
    ndarray, shape (N,), or None
        Distances, px. None for a board that was not found, or of another size.
    """
    if not detection.found:
        return None
    orders = symmetries(detection.corners, detection.columns, detection.rows)
    size = reference.columns, reference.rows
    errors = [
        _known(np.linalg.norm(order - reference.corners, axis=1)[reference.certain])
        for order, order_size in orders
        if order_size == size
    ]
    return min(errors, key=_largest, default=None)


def is_right(errors: np.ndarray | None, reference: ReferenceCorners) -> bool:
    """Return whether a board is correct: each of its errors within the tolerance.

    Parameters
    ----------
    errors : ndarray or None
        From `corner_errors`, px. None for a missing board or one of another size.
    reference : ReferenceCorners
        Reference corners with the tolerance.

    Returns
    -------
    bool
        False for None.
    """
    return errors is not None and bool(_largest(errors) <= reference.tolerance_px)


def _known(errors):
    return errors[np.isfinite(errors)]


def _largest(errors):
    return errors.max(initial=0.0)


MIN_N_CORNERS = 6  # three corners determine a pose; the others are scored


class ImageScore(NamedTuple):
    """Hold the errors of one view.

    Values are NaN, with the reason, where fewer than six corners have a ray. Those in
    px are NaN, too, where the camera projects none of the corners.

    Attributes
    ----------
    name : str
        Name of the view.
    n_corners : int
        Number of corners that were found.
    n_without_ray : int
        Number of those that are not scored: the camera has no ray for them, cannot
        project them where the pose puts them, or gives the board no pose.
    rms_px, median_px : float
        Root mean square and median of the distances in the image, px.
    mean_deg : float
        Mean of the angles at the rays, degrees.
    T_camera_grid : ndarray, shape (4, 4), or None
        Pose that minimises the distances in px, for `rms_px`, `median_px` and
        `residuals_px`. None where there is no pose.
    T_camera_grid_by_angle : ndarray, shape (4, 4), or None
        Pose that minimises the angles, for `mean_deg`. Where the camera projects none
        of the corners, both poses are this one.
    residuals_px : ndarray, shape (N, 2)
        Found less projected corners, px; NaN for missing ones.
    reason : str
        Why there is no score, or ''.
    fold : int or None
        Part of a cross-validation in which the view was held out.
    """

    name: str
    n_corners: int
    n_without_ray: int
    rms_px: float
    median_px: float
    mean_deg: float
    T_camera_grid: np.ndarray | None
    T_camera_grid_by_angle: np.ndarray | None
    residuals_px: np.ndarray
    reason: str = ""
    fold: int | None = None

    def fields(self) -> dict[str, Any]:
        """Return the errors for JSON."""
        return {
            "file": self.name,
            "n_corners": int(self.n_corners),
            "n_without_ray": int(self.n_without_ray),
            **_errors(self),
            "T_camera_grid": _plain_pose(self.T_camera_grid),
            "T_camera_grid_by_angle": _plain_pose(self.T_camera_grid_by_angle),
            "reason": self.reason,
        }


class Evaluation(NamedTuple):
    """Hold the errors of a camera over several views.

    Attributes
    ----------
    images : list of ImageScore
        Errors of each view.
    rms_px, median_px : float
        Root mean square and median distance over all scored corners, px.
    mean_deg : float
        Mean angle over all scored corners, degrees.
    share_with_ray : float
        Scored corners as a share of those found; NaN where none was found.
    left_out : dict of int to str
        Reason for each part of a cross-validation that gave no camera.
    """

    images: list
    rms_px: float
    median_px: float
    mean_deg: float
    share_with_ray: float
    left_out: dict

    @property
    def n_scored(self) -> int:
        """Return the number of scored corners over all views."""
        return sum(image.n_corners - image.n_without_ray for image in self.images)

    def totals(self) -> dict[str, float | None]:
        """Return the errors over all views, for JSON; None for unknown."""
        return _errors(self) | {"share_with_ray": known(self.share_with_ray)}

    def fields(self) -> dict[str, Any]:
        """Return all errors for JSON: `images`, and the totals."""
        return {"images": [image.fields() for image in self.images], **self.totals()}


def _errors(scored):
    keys = "rms_px", "median_px", "mean_deg"
    return {key: known(getattr(scored, key)) for key in keys}


def _plain_pose(T):
    return None if T is None else T.tolist()


def evaluate_camera(
    camera: Camera,
    views: Sequence[BoardView | DenseView],
    shape: BoardShape | None = None,
) -> Evaluation:
    """Score a camera on views, with only the pose of each view fitted.

    Of a DenseView the lattice of pixels is scored, all alike.

    Parameters
    ----------
    camera : Camera
        Any camera.
    views : sequence of BoardView or DenseView
        The views.
    shape : BoardShape or None
        Shape of the board in all views; None for a board that is as stated.

    Returns
    -------
    Evaluation
        The errors.

    Raises
    ------
    InputError
        If the counts of a view do not fit, or the list is empty.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.calibration import BoardView
    >>> from raxel.cameras import PerspectiveCamera
    >>> from raxel.evaluation import evaluate_camera
    >>> from raxel.sets import Chessboard
    >>> K = np.array([[800.0, 0, 320], [0, 800.0, 240], [0, 0, 1]])
    >>> camera = PerspectiveCamera(K, (0, 0), width=640, height=480)
    >>> points = Chessboard(9, 6, 20.0).points()
    >>> solid = np.column_stack([points - [80, 50], np.full(54, 400.0)])
    >>> pixels = camera.project(solid).pixels + [3.0, -2.0]
    >>> found = evaluate_camera(camera, [BoardView(pixels, points, 9, 6, "a")])
    >>> found.n_scored, found.rms_px < 0.1
    (54, True)
    """
    return _summary([_score(camera, check_view(view), shape) for view in views], {})


def cross_validate(
    model_builder: Callable[[list], Any],
    views: Sequence[BoardView | DenseView],
    folds: int | Iterable[Iterable[int]],
) -> Evaluation:
    """Score every view with a camera that was calibrated without it.

    A part is excluded, with the reason, where the remaining views give no camera.

    Parameters
    ----------
    model_builder : callable
        Maps a list of views to a Camera, or to (Camera, BoardShape or None) where the
        shape of the board was found with it.
    views : sequence of BoardView or DenseView
        The views.
    folds : int or iterable of iterable of int
        Number of parts, part i being views i, i + folds, ...; or the parts as lists of
        indices.

    Returns
    -------
    Evaluation
        The errors on the held-out views.

    Raises
    ------
    InputError
        If the parts are not valid.
    CalibrationError
        If no part gave a camera (code ``no-camera``).
    """
    scores, left_out = [], {}
    for fold, held_out in enumerate(_parts(folds, len(views))):
        rest = [view for i, view in enumerate(views) if i not in held_out]
        try:
            built = model_builder(rest)
        except CalibrationError as error:
            left_out[fold] = str(error)
            continue
        camera, shape = built if isinstance(built, tuple) else (built, None)
        for i in held_out:
            score = _score(camera, check_view(views[i]), shape)
            scores.append(score._replace(fold=fold))
    if not scores:
        raise CalibrationError(
            f"cross-validation: no part gave a camera: {left_out[0]}", code="no-camera"
        )
    return _summary(scores, left_out)


def _parts(folds, count):
    if isinstance(folds, int):
        if not 2 <= folds <= count:
            raise InputError(
                f"cross-validation: folds: found {folds} for {count} views; give 2 to"
                f" {count}"
            )
        return [list(range(i, count, folds)) for i in range(folds)]
    parts = [list(part) for part in folds]
    if not parts or any(not 0 <= i < count for part in parts for i in part):
        raise InputError(
            f"cross-validation: folds: give lists of indices from 0 to {count - 1}"
        )
    return parts


def _score(camera, view, shape):
    n_corners = int(np.count_nonzero(np.isfinite(view.pixels[:, 0])))
    residuals = np.full(view.pixels.shape, np.nan)
    rays = camera.rays(view.pixels)
    known = rays.valid
    blank = ImageScore(
        view.name, n_corners, n_corners, np.nan, np.nan, np.nan, None, None, residuals
    )
    if np.count_nonzero(known) < MIN_N_CORNERS:
        return blank._replace(
            reason=f"{np.count_nonzero(known)} corners have a ray;"
            f" {MIN_N_CORNERS} are needed"
        )
    pixels, points = view.pixels[known], view.points[known]
    origins, directions = rays.origins[known], rays.directions[known]
    try:
        by_angle = fit_board_pose(directions, points, origins, shape)
    except CalibrationError as error:
        return blank._replace(reason=str(error))
    solid = board_points(points, shape)
    T, residuals[known] = refine_pose_in_pixels(camera, pixels, solid, by_angle)
    sight = transform(by_angle, solid) - origins
    across = np.linalg.norm(np.cross(directions, sight), axis=1)
    angles = np.arctan2(across, np.sum(directions * sight, axis=1))
    scored = np.isfinite(residuals[:, 0])
    return blank._replace(
        n_without_ray=n_corners - int(np.count_nonzero(scored)),
        T_camera_grid=T,
        T_camera_grid_by_angle=by_angle,
        mean_deg=float(np.degrees(np.mean(angles))),
        **_pixel_errors(residuals[scored]),
    )


def fit_board_pose(
    directions: np.ndarray,
    points: np.ndarray,
    origins: ArrayLike = (0.0, 0.0, 0.0),
    shape: BoardShape | None = None,
) -> NDArray[np.float64]:
    """Return the pose of a board from rays: least squares of the sines of the angles.

    The start assumes that all rays leave their mean origin, and that the board is flat.

    Parameters
    ----------
    directions : ndarray, shape (N, 3)
        Unit directions, camera frame.
    points : ndarray, shape (N, 2)
        Points on the board.
    origins : array_like, shape (3,) or (N, 3)
        Origins of the rays, camera frame, in the unit of `points`.
    shape : BoardShape or None
        Shape of the board. A point of it counts as where its ray meets the plane, which
        moves it along the ray alone.

    Returns
    -------
    ndarray, shape (4, 4)
        Pose T_camera_grid.

    Raises
    ------
    CalibrationError
        If no start is found.
    """
    origins = np.broadcast_to(np.asarray(origins, float), (len(points), 3))
    middle = origins.mean(axis=0)
    T = pose_of_spread_triples(directions, points)
    T[:3, 3] += middle
    for _ in range(3):
        flat = points
        if shape is not None:
            flat = shape.seen_on_plane(points, directions @ T[:3, :3])
        # Distances over lengths are sines; the lengths hardly change in the fit.
        sight = transform(T, on_plane(flat)) - origins
        weights = 1.0 / np.linalg.norm(sight, axis=1)
        T, _ = refine_pose_ray_point(
            directions, flat, T, origins=origins, weights=weights
        )
    return T


def _pixel_errors(residuals):
    distances = np.linalg.norm(residuals, axis=1)
    if len(distances) == 0:
        return {"rms_px": np.nan, "median_px": np.nan}
    return {
        "rms_px": float(np.sqrt(np.mean(distances**2))),
        "median_px": float(np.median(distances)),
    }


def _summary(scores, left_out):
    if not scores:
        raise InputError("evaluation: no views given")
    residuals = np.concatenate([s.residuals_px for s in scores])
    residuals = residuals[np.isfinite(residuals[:, 0])]
    corners = sum(s.n_corners for s in scores)
    scored = np.array([s.n_corners - s.n_without_ray for s in scores], float)
    degrees = np.array([s.mean_deg for s in scores])
    posed = np.isfinite(degrees)
    mean_deg = np.nan
    if scored[posed].sum() > 0:
        mean_deg = float(np.average(degrees[posed], weights=scored[posed]))
    return Evaluation(
        images=scores,
        **_pixel_errors(residuals),
        mean_deg=mean_deg,
        share_with_ray=scored.sum() / corners if corners else np.nan,
        left_out=left_out,
    )
