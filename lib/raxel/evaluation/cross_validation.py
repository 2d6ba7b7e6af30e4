"""How well does a camera predict boards it has not seen? Poses are refitted, no more.

The board's pose is fitted twice, the same way for every model. Angles are judged at the
pose that fits the rays of its corners best: least squares of the sines of the angles
between rays and board corners. Pixels are judged at the pose with the smallest
reprojection error, reached from there. Each error is so the smallest that the camera
allows; at the other's pose a camera that does not fit would look worse than it is.

A corner is scored where the camera has a ray for it and can project it where the first
pose puts it. All others are counted: a score over few corners says so itself.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.pose.three_point import (
    pose_of_spread_triples,
    refine_pose_ray_point,
)
from raxel.calibration.views.correspondence import board_points, check_view
from raxel.errors import CalibrationError, InputError
from raxel.evaluation.distortion import refine_pose_in_pixels
from raxel.features.lattice import symmetries
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import transform

# Corners of one board against its true corners: each in its place, and in order?


RIM_PX = 4.0  # a corner this near to the image's end need not be found


def in_place(corners, truth, reach_px):
    """Whether every corner (N, 2) is at its own true one, of `truth` (N, 2).

    It is where it is nearer than `reach_px` to it, and nearer to it than to any other
    true corner: on a fine lattice a neighbour may be within reach, too. False for
    another number of corners, and where one is not finite.
    """
    corners, truth = np.asarray(corners, float), np.asarray(truth, float)
    if corners.shape != truth.shape or not np.isfinite(corners).all():
        return False
    apart = distances(corners, truth)
    own = np.arange(len(truth))
    return bool(
        (apart[own, own] < reach_px).all() and (apart.argmin(axis=1) == own).all()
    )


def in_order_of(truth, corners, columns, rows):
    """Corners (rows * columns, 2), row by row, begun where they fit `truth` best.

    A detector without clicks may begin at any outer corner and go along the columns
    either way. Rows stay rows, also on a square board. `truth` (rows * columns, 2).
    """
    upright = list(symmetries(corners, columns, rows))[:4]
    return min(
        (order for order, _ in upright),
        key=lambda order: np.linalg.norm(order - truth, axis=1).sum(),
    )


def share_in_order(partial, truth, columns, shape, reach_px):
    """Share (0 to 1) of the true corners in the image that a `Partial` has in order.

    `partial` (or None: nothing is in order) is what a refused `Detection` holds;
    `truth` (rows * columns, 2) the true corners in pixels, row by row; `shape` that of
    the image, (height, width). A corner is in order if it is nearer than `reach_px` to
    the true corner to which one of the eight symmetries of a lattice, and one shift,
    take its row and column; of these the one counts that fits most corners.
    """
    size = np.array(shape[1::-1])
    inside = np.all((truth > RIM_PX) & (truth < size - 1 - RIM_PX), axis=1)
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


def distances(points, others):
    """Distances (N, M) px between points (N, 2) and others (M, 2).

    Without others everything is infinitely far: (N, 1).
    """
    if not len(others):
        return np.full((len(points), 1), np.inf)
    return np.linalg.norm(points[:, None] - others[None], axis=2)


# Detected boards against reference corners of a set: how far off, and is it right?


def corner_errors(detection, reference):
    """Distances (N,) in px of a detection from the N certain reference corners.

    `detection` is a Detection, `reference` a ReferenceCorners of the same image. The
    symmetry of the lattice with the smallest largest distance counts, since the
    reference leaves open which corner is first; mirrored ones are allowed. A corner
    that the board lacks has no distance, so that fewer than N are given. None for a
    board that was not found, or of another size.
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


def is_right(errors, reference):
    """Whether a board with these `corner_errors` is right: each within the tolerance.

    False for None, the errors of a board that is not there or of another size.
    """
    return errors is not None and bool(_largest(errors) <= reference.tolerance_px)


def _known(errors):
    return errors[np.isfinite(errors)]


def _largest(errors):
    return errors.max(initial=0.0)


FEWEST_CORNERS = 6  # six pose parameters take three corners; the rest is judged


class ImageScore(NamedTuple):
    """Errors of one view.

    n_corners: corners found; n_without_ray: those of them that are not scored, as the
    camera has no ray for them, cannot project them where the pose puts them, or gives
    the board no pose; rms_px, median_px: of the distances in the image; mean_deg: of
    the angles at the rays. NaN, with the reason, where fewer than six corners have a
    ray, and in px where the camera projects none.
    T_camera_grid (4, 4): the pose that minimises the distances in px, at which rms_px,
    median_px and residuals_px are taken; T_camera_grid_by_angle (4, 4): the one that
    minimises the angles, at which mean_deg is taken; None where there is no pose. Where
    the camera projects none of the corners, both are the latter.
    residuals_px: (N, 2), found less projected, NaN where there is none. fold: which
    part of a cross-validation it was kept out in.
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


class Evaluation(NamedTuple):
    """images: list of ImageScore; over all scored corners: rms_px, median_px, mean_deg;
    share_with_ray: scored corners of those found, NaN where none was found; left_out:
    {fold: reason} for parts that gave no camera.
    """

    images: list
    rms_px: float
    median_px: float
    mean_deg: float
    share_with_ray: float
    left_out: dict

    @property
    def n_scored(self):
        """Corners that were scored, over all views."""
        return sum(image.n_corners - image.n_without_ray for image in self.images)


def evaluate_camera(camera, views, shape=None):
    """Score a camera on BoardViews or DenseViews, fitting nothing but each one's pose.

    Of a DenseView the lattice of pixels is scored, all alike. shape: the BoardShape of
    the board in all views, None for one that is as stated.

    Returns Evaluation. Raises InputError for views whose counts do not fit or an empty
    list.
    """
    return _summary([_score(camera, check_view(view), shape) for view in views], {})


def cross_validate(model_builder, views, folds):
    """Every view scored by a camera that was calibrated without it.

    model_builder: callable, list of views -> Camera, or (Camera, BoardShape or None)
    where the shape of the board was found with it. folds: number of parts, part
    i being views i, i + folds, ...; or the parts as lists of indices. Where a part's
    remaining views give no camera (CalibrationError), the part is left out, with the
    reason. Returns Evaluation. Raises InputError for parts that make no sense.
    """
    scores, left_out = [], {}
    for fold, kept_out in enumerate(_parts(folds, len(views))):
        rest = [view for i, view in enumerate(views) if i not in kept_out]
        try:
            built = model_builder(rest)
        except CalibrationError as error:
            left_out[fold] = str(error)
            continue
        camera, shape = built if isinstance(built, tuple) else (built, None)
        for i in kept_out:
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
    if np.count_nonzero(known) < FEWEST_CORNERS:
        return blank._replace(
            reason=f"{np.count_nonzero(known)} corners have a ray;"
            f" {FEWEST_CORNERS} are needed"
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


def fit_board_pose(directions, points, origins=(0.0, 0.0, 0.0), shape=None):
    """Pose (4, 4) of a board from rays: least squares of the sines of the angles.

    directions: (N, 3) unit; points: (N, 2); origins: (3,) or (N, 3). The start takes
    all rays from their mean origin, and the board for flat. shape: its BoardShape: a
    point of it counts as where its ray meets the plane, which moves it along the ray
    alone. Raises CalibrationError where no start is found.
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
