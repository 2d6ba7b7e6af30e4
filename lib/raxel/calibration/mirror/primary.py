"""Primary calibration: first shape of the mirror, from grids in known poses (5.2.1).

This is phase-measuring deflectometry. A grid is seen in the mirror in two or more known
positions. Each pixel sees a point of every position, so its scene ray is known without
a model (2.3.3). The mirror is where the scene ray is closest to the viewing ray. The
normals of the ray pairs give a spline up to scale (5.15, 5.16), and the mirror points
give the scale. The refinement minimises the distances of all grid points from their
scene rays.

Frame: that of the viewing camera; mm.
"""

from __future__ import annotations

from collections.abc import Iterable
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.calibration.generic.known_motion import (
    KnownMotionRays,
    rays_from_known_motion,
)
from raxel.calibration.mirror.observations import (
    RayPoints,
    need_support,
    normalised,
    support_of,
    wrong_matches,
)
from raxel.calibration.mirror.platter import PlatterPoses, grid_motion
from raxel.calibration.mirror.refine import (
    reflection_normals,
    scaled_to_points,
    shape_up_to_scale,
)
from raxel.calibration.pose.three_point import motion_of_points, placed_points
from raxel.calibration.views.correspondence import BoardView
from raxel.calibration.views.dense import DenseView, sample_boards
from raxel.calibration.views.interpolation import interpolated_view
from raxel.cameras.core.base import Camera
from raxel.cameras.mirrors.spline import SplineMirrorCamera
from raxel.errors import CalibrationError, InputError
from raxel.geometry.least_squares import descend, gauss_newton
from raxel.geometry.spline_grids import spline_grid

# Linear stage of the primary calibration, with rejection of wrongly decoded points.


# Sine of the angle between viewing ray and scene ray, for a well-determined point.
MIN_RAY_ANGLE_SINE = 0.02
# Mean distance between viewing rays and scene rays of one mirror.
MAX_MISS_MM = 20.0
# Medians, and mm as a minimum, beyond which grid points are outliers. Larger fractions
# of outliers are an error.
OUTLIER_MEDIANS, MIN_OUTLIER_MM, MAX_N_ROUNDS, MAX_OUTLIER_FRACTION = 6.0, 0.01, 6, 0.25


class MirrorPoints(NamedTuple):
    """Hold points where viewing rays and scene rays come nearest to each other.

    Attributes
    ----------
    points : ndarray, shape (N, 3)
        Middle of the shortest line between both rays, mm.
    misses : ndarray, shape (N,)
        Distance of the point from either ray, mm, half of that line. It is the thesis's
        ray-point distance of 5.3.3.
    directions : ndarray, shape (N, 3)
        Unit directions of the scene rays, away from the mirror.
    valid : ndarray of bool, shape (N,)
        Elsewhere the others are NaN.
    """

    points: np.ndarray
    misses: np.ndarray
    directions: np.ndarray
    valid: np.ndarray


def mirror_points(viewing: NDArray[np.float64], rays: KnownMotionRays) -> MirrorPoints:
    """Return the mirror points of pixels from their viewing and scene rays.

    A pixel is not valid where a ray is missing, both are nearly parallel, or the point
    lies behind the camera.

    Parameters
    ----------
    viewing : ndarray, shape (N, 3)
        Unit directions of viewing rays, from the origin.
    rays : KnownMotionRays
        Scene rays, whose sense does not matter. Their origins, on a grid, lie ahead of
        the mirror.

    Returns
    -------
    MirrorPoints
        Points, distances and directions, N each.
    """
    o, d = rays.origins, rays.directions
    cosine = np.sum(viewing * d, axis=1)
    with np.errstate(invalid="ignore", divide="ignore"):
        square = 1 - cosine**2
        # Minimise |a v - o - b d|: two equations for a and b.
        along_v, along_d = np.sum(viewing * o, axis=1), np.sum(d * o, axis=1)
        a = (along_v - cosine * along_d) / square
        b = (cosine * along_v - along_d) / square
        valid = rays.valid & (square > MIN_RAY_ANGLE_SINE**2) & (a > 0) & np.isfinite(a)
    keep = valid[:, None]
    first, second = a[:, None] * viewing, o + b[:, None] * d
    # The grid's point is beyond the mirror point: b < 0 if the ray points away from it.
    away = -np.sign(b)[:, None] * d
    return MirrorPoints(
        np.where(keep, (first + second) / 2, np.nan),
        np.where(valid, np.linalg.norm(first - second, axis=1) / 2, np.nan),
        np.where(keep, away, np.nan),
        valid,
    )


class PrimaryStart(NamedTuple):
    """Linear stage: coefficients (K,) on a grid, from the MirrorPoints of those pixels,
    `common` (N,) bool, that see two grids, and their points (n, M, 2)."""

    grid: object
    coefficients: np.ndarray
    mirror: MirrorPoints
    common: np.ndarray
    points: np.ndarray
    flags: list


def robust_start(seen, given, T, spline, span):
    """(PrimaryStart, observations of each grid for the refinement, flags), without
    outliers.

    seen, given: (normalised image points (N, 2), points (N, 2) mm) of each grid, for
    the linear stage and for the refinement, where they differ; spline: shape, degree,
    angle, quantity. The first round excludes points that deviate from a smooth image,
    later rounds those that deviate from the linear stage, which improves without them.
    It tolerates a third of independently wrong points in one grid, and a sixth of
    consistently wrong points along a border.
    """
    every = [seen] if given is None else [seen, given]
    wrong = [[_smooth_outliers(*grid) for grid in one] for one in every]
    for left in reversed(range(MAX_N_ROUNDS + 1)):
        retained = [_without(*pair) for pair in zip(every, wrong, strict=True)]
        sighted = [_known(*grid) for grid in retained[-1]]
        start = _linear_stage(retained[0], sighted, T, spline, span)
        # Test all points: a poor initial shape can reject correct ones.
        pairs = zip(every, wrong, strict=True)
        found = [_far(start, *pair, T, spline[-1]) for pair in pairs]
        if not left or np.array_equal(np.hstack(found[0]), np.hstack(wrong[0])):
            break
        wrong = found
    whole = sum(len(_known(*grid)[0]) for grid in every[-1])
    out = whole - sum(len(xy) for _, xy in sighted)
    if out > MAX_OUTLIER_FRACTION * whole:
        raise CalibrationError(
            f"primary calibration: {out} of {whole} grid points are outliers; take new "
            "images of the grids with a static scene",
            code="wrong-matches",
        )
    flags = [f"{out} of {whole} grid points rejected as outliers"] if out else []
    return start, sighted, flags


def _linear_stage(seen, sighted, T, spline, span):
    """PrimaryStart from observations of grids in poses T (n, 4, 4); the knots span
    them, the pixels of the refinement, and `span`."""
    shape, degree, angle, quantity = spline
    p, points = seen[0][0], np.stack([xy for _, xy in seen])
    common = np.count_nonzero(np.isfinite(points).all(axis=2), axis=0) >= 2
    p, points = p[common], points[:, common]
    along = np.column_stack([p, np.ones(len(p))])
    unit = along / np.linalg.norm(along, axis=1, keepdims=True)
    mirror = mirror_points(unit, rays_from_known_motion(points, T))
    _check_meeting(mirror)
    good = mirror.valid
    spanned = np.concatenate([p[good], *(image for image, _ in sighted)])
    box = spanned if span is None else np.concatenate([spanned, span])
    grid = spline_grid(box, shape, degree, angle)
    flags = need_support(support_of(grid, spanned))
    normals = reflection_normals(unit[good], mirror.directions[good])
    c = shape_up_to_scale(p[good], normals, grid, quantity)
    c = scaled_to_points(c, grid, quantity, mirror.points[good])
    return PrimaryStart(grid, c, mirror, common, points, flags)


def _far(start, seen, wrong, T, quantity):
    """For each grid, which points (N,) bool are far from a PrimaryStart's rays; outside
    its knots, those that were wrong before."""
    found = []
    for (p, xy), pose in zip(seen, T, strict=True):
        errors, there = np.full(len(p), np.nan), start.grid.inside(p)
        rays = RayPoints(p[there], start.grid, quantity)
        gap = rays.residuals(start.coefficients, placed_points(xy[there], pose))
        errors[there] = np.linalg.norm(gap, axis=1)
        found.append(errors)
    limit = OUTLIER_MEDIANS * max(np.nanmedian(np.concatenate(found)), MIN_OUTLIER_MM)
    return [
        np.where(np.isfinite(errors), errors > limit, before)
        for errors, before in zip(found, wrong, strict=True)
    ]


def _smooth_outliers(p, xy):
    """Which points (N,) bool of a grid are far from a smooth function of p (N, 2)."""
    known = np.isfinite(p + xy).all(axis=1)
    wrong = np.zeros(len(p), bool)
    wrong[known] = wrong_matches(p[known], xy[known])
    return wrong


def _without(seen, wrong):
    """Observations of each grid, NaN where wrong."""
    return [
        (p, np.where(out[:, None], np.nan, xy))
        for (p, xy), out in zip(seen, wrong, strict=True)
    ]


def _known(p, xy):
    """Rows of p (N, 2) and xy (N, 2) where both are finite."""
    known = np.isfinite(p + xy).all(axis=1)
    return p[known], xy[known]


def _check_meeting(mirror):
    if np.count_nonzero(mirror.valid) < np.count_nonzero(~mirror.valid):
        raise CalibrationError(
            f"primary calibration: {np.count_nonzero(~mirror.valid)} of "
            f"{len(mirror.valid)} scene rays meet no viewing ray in front of the "
            "camera; check the grids' poses and their images in the mirror",
            code="rays-do-not-meet",
        )
    miss = np.mean(mirror.misses[mirror.valid])
    if miss > MAX_MISS_MM:
        raise CalibrationError(
            f"primary calibration: scene rays miss viewing rays by {miss:.0f} mm "
            "(mean); check the grids' poses and their assignment to views",
            code="rays-do-not-meet",
        )


N_PIXELS_PER_VIEW = 1000  # approximate number of pixels that see all positions
MAX_N_STEPS, COST_TOL, ROUNDING_MM = 50, 1e-10, 1e-10
# Reciprocal condition number of the normal matrix: below, undetermined.
MIN_EIGENVALUE_RATIO = 1e-14


class PrimaryCalibration(NamedTuple):
    """Hold the calibration of the first shape of a mirror.

    Attributes
    ----------
    camera : SplineMirrorCamera
        Refined camera.
    linear : SplineMirrorCamera
        Camera of the linear stage (5.15, 5.16).
    pixels : ndarray, shape (N, 2)
        Pixels that see all positions.
    mirror : MirrorPoints
        Mirror points of these pixels.
    residuals : ndarray, shape (M,)
        Distances of all grid points from the camera's scene rays, mm.
    covariance : ndarray, shape (K, K)
        Covariance of vec(C), from the residuals' scatter, as if they were noise. That
        of the poses is added where it is known.
    costs : ndarray
        Costs of the refinement, from the start on, mm^2.
    converged : bool
        Whether the refinement converged.
    motions : tuple of GridMotion
        Motions from the first grid to each other, at the middle of what the pixels see
        of the first. Standard deviations are NaN where those of the poses are not
        known.
    flags : tuple of str
        Knot intervals with little support from the points, and the number of points
        rejected as wrong, a text each.
    """

    camera: SplineMirrorCamera
    linear: SplineMirrorCamera
    pixels: np.ndarray
    mirror: object
    residuals: np.ndarray
    covariance: np.ndarray
    costs: np.ndarray
    converged: bool
    motions: tuple
    flags: tuple


def calibrate_primary(
    viewer: Camera,
    views: Iterable[BoardView | DenseView],
    poses: PlatterPoses | ArrayLike,
    *,
    shape: tuple[int, int] = (7, 3),
    degree: tuple[int, int] = (2, 2),
    angle: float = 0.0,
    quantity: str = "inverse depth",
    span: NDArray[np.float64] | None = None,
) -> PrimaryCalibration:
    """Calibrate the mirror's shape from two or more grids in known poses.

    Between corners of chessboards the views are interpolated for the linear stage. The
    refinement uses corners alone.

    Parameters
    ----------
    viewer : Camera
        Calibrated central camera.
    views : iterable of BoardView or DenseView
        n views of a chessboard or of an active grid in the mirror.
    poses : PlatterPoses or array_like, shape (n, 4, 4)
        T_camera_grid in the coordinates of the views' points. A DenseView of a mirrored
        grid counts y upwards, in the flat reference mirror too.
    shape, degree : tuple of int
        Numbers of basis functions and degrees of the spline, along u and v.
    angle : float
        Angle of the spline's u axis, rad.
    quantity : str
        "inverse depth" or "distance"; see `SplineMirrorCamera`.
    span : ndarray, shape (L, 2), or None
        Further normalised image points that the knots are to span, such as the clamp's
        line.

    Returns
    -------
    PrimaryCalibration
        Refined and linear camera, in the frame of the viewing camera (mm).

    Raises
    ------
    InputError
        The views do not fit each other (``mixed-views``), or the poses do not fit them.
    CalibrationError
        No pixel sees two positions. ``rays-do-not-meet``: scene rays do not meet
        viewing rays. ``no-feature-at-end``: the outermost knot intervals hold no point.
        ``open-coefficients``: coefficients are undetermined. ``wrong-matches``: too
        many points do not fit.

    References
    ----------
    Thesis 5.2.1.
    """
    views = list(views)
    _check_views(views, _poses(poses)[0])
    filled = [interpolated_view(view, "by need")[0] for view in views]
    seen = sample_boards(
        filled, viewer.width, viewer.height, N_PIXELS_PER_VIEW * len(views)
    )
    sighted = [_refining_points(view, seen, k) for k, view in enumerate(views)]
    spline = {"shape": shape, "degree": degree, "angle": angle, "quantity": quantity}
    pixels = seen.pixels.astype(float)
    return primary_from_points(
        viewer,
        pixels,
        seen.points,
        poses,
        sighted=sighted,
        span=span,
        **spline,  # type: ignore[arg-type]
    )


def primary_from_points(
    viewer: Camera,
    pixels: ArrayLike,
    points: ArrayLike,
    poses: PlatterPoses | ArrayLike,
    *,
    shape: tuple[int, int] = (7, 3),
    degree: tuple[int, int] = (2, 2),
    angle: float = 0.0,
    quantity: str = "inverse depth",
    span: NDArray[np.float64] | None = None,
    sighted: Iterable[tuple[ArrayLike, ArrayLike]] | None = None,
) -> PrimaryCalibration:
    """Calibrate the mirror's shape from pixels and the grid points that they see.

    Parameters
    ----------
    viewer : Camera
        Calibrated central camera.
    pixels : array_like, shape (N, 2)
        Pixels, px.
    points : array_like, shape (n, N, 2)
        Point of each grid that a pixel sees, mm, NaN where it sees none.
    poses, shape, degree, angle, quantity, span
        See `calibrate_primary`.
    sighted : iterable of tuple, or None
        For each grid the pixels (M, 2) and points (M, 2) that the refinement uses. If
        not given, it uses those of `points`.

    Returns
    -------
    PrimaryCalibration
        See `calibrate_primary`.

    Raises
    ------
    CalibrationError
        As `calibrate_primary`.
    """
    T, pose_covariance = _poses(poses)
    viewing = normalised(viewer, np.asarray(pixels, float))
    seen = [(viewing, xy) for xy in np.asarray(points, float)]
    if sighted is not None:
        sighted = [
            (normalised(viewer, np.asarray(at, float)), np.asarray(xy, float))
            for at, xy in sighted
        ]
    spline = shape, degree, angle, quantity
    start, sighted, flags = robust_start(seen, sighted, T, spline, span)
    grid, c = start.grid, start.coefficients
    refined = _refined(grid, quantity, c, sighted, T, pose_covariance)
    middle = np.nanmean(start.points[0, start.mirror.valid], axis=0)
    motions = [grid_motion(T, pose_covariance, 0, k, middle) for k in range(1, len(T))]
    return PrimaryCalibration(  # type: ignore[call-arg]
        SplineMirrorCamera.on_grid(viewer, grid, refined.coefficients, quantity),
        SplineMirrorCamera.on_grid(viewer, grid, c, quantity),
        np.asarray(pixels)[start.common],
        start.mirror,
        *refined[1:],
        tuple(motions),
        (*start.flags, *flags),
    )


class _Refined(NamedTuple):
    coefficients: np.ndarray
    residuals: np.ndarray
    covariance: np.ndarray
    costs: np.ndarray
    converged: bool


def _refined(grid, quantity, start, sighted, T, pose_covariance):
    """Minimise ray-point vectors of observations of grids in poses T (n, 4, 4)."""
    image = np.concatenate([p for p, _ in sighted])
    placed = zip(sighted, T, strict=True)
    targets = np.concatenate([placed_points(xy, pose) for (_, xy), pose in placed])
    rays = RayPoints(image, grid, quantity)

    def evaluate(c):
        if not rays.in_front(c):
            return np.inf, None
        errors = rays.residuals(c, targets).ravel()
        return gauss_newton(
            errors, lambda: rays.jacobian(c, targets).reshape(-1, len(c))
        )

    c, costs, converged = descend(
        evaluate,
        np.add,
        start,
        iterations=MAX_N_STEPS,
        tolerance=COST_TOL,
        rounding=len(image) * ROUNDING_MM**2,
    )
    J = rays.jacobian(c, targets).reshape(-1, len(c))
    normal = J.T @ J
    size = np.sqrt(np.diag(normal))
    if not (
        size.min() > 0
        and np.linalg.cond(normal / np.outer(size, size)) < 1 / MIN_EIGENVALUE_RATIO
    ):
        raise CalibrationError(
            f"primary calibration: {len(image)} points do not determine all "
            f"{grid.size} coefficients; fill the mirror with the grids, or use fewer "
            "knots",
            code="open-coefficients",
        )
    inverse = np.linalg.inv(normal / np.outer(size, size)) / np.outer(size, size)
    covariance = costs[-1] / (2 * len(image) - grid.size) * inverse
    if np.isfinite(pose_covariance).all():
        moved = rays.across(c) @ _motion(sighted, T)
        by_pose = inverse @ J.T @ moved.reshape(len(J), -1)
        covariance += by_pose @ pose_covariance @ by_pose.T
    residuals = np.linalg.norm(rays.residuals(c, targets), axis=1)
    return _Refined(c, residuals, covariance, costs, converged)


def _motion(sighted, T):
    """(M, 3, 6 n): change of all points with the poses of the grids."""
    blocks = []
    for k, (_, xy) in enumerate(sighted):
        block = np.zeros((len(xy), 3, 6 * len(T)))
        block[:, :, 6 * k : 6 * k + 6] = motion_of_points(xy, T[k])
        blocks.append(block)
    return np.concatenate(blocks)


def _poses(poses):
    """T_camera_grid (n, 4, 4) and its covariance (6n, 6n), NaN where not known."""
    if isinstance(poses, PlatterPoses):
        size = 6 * len(poses.T_camera_grid)
        return poses.T_camera_grid, poses.covariance[:size, :size]
    T = np.asarray(poses, float)
    return T, np.full((6 * len(T), 6 * len(T)), np.nan)


def _refining_points(view, seen, k):
    """Pixels (M, 2) and points (M, 2) of the grid of view k: the samples of a
    DenseView, the corners of a BoardView."""
    if view.every_pixel:
        return seen.pixels[seen.seen[k]], seen.points[k, seen.seen[k]]
    return view.pixels, view.points


def _check_views(views, T):
    if len(views) < 2 or T.shape != (len(views), 4, 4):
        raise InputError(
            f"primary calibration: found {len(views)} views and poses {T.shape}; give "
            "two views or more, with a pose (4, 4) each"
        )
    turned = {view.mirrored for view in views if view.every_pixel}
    if len(turned) > 1:
        raise InputError(
            "primary calibration: found mirrored and direct views of the grid; give "
            "views in the mirror only",
            code="mixed-views",
        )
