"""B-spline ray field from corners: field and poses of all boards at once.

There are no interpolated cells and no table. Gauss-Newton solves the equations of
`raxel.calibration.smooth.equations`. A rotation of all rays is equivalent to an
opposite rotation of all poses: the field contains none of the three rotations, on
average over the corners.

Resolution and smoothness of the field are selected by cross-validation on held-out
boards, whose poses alone are refitted. Tukey's biweight excludes outliers in the end.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from raxel.calibration.smooth import equations as linear_part
from raxel.calibration.smooth.equations import (
    CornersOfBoards,
    downhill,
    grid_of,
    node_places,
)
from raxel.cameras.tables.interpolation import shares
from raxel.cameras.tables.ray_spline import RaySplineCamera
from raxel.errors import CalibrationError
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import cross_matrix, transform

CELLS = (4, 8, 16)  # along the image's longer side, tried in this order
SMOOTHNESS = 10.0 ** np.arange(-9, 7)  # in data of a cell; search from START_INDICES
START_INDICES = 5, 9
MAX_N_FOLDS = 6  # of the boards, for cross-validation
# Scales at which the biweight is zero, and median distance at unit scale.
OUTLIER_SCALES, RAYLEIGH_MEDIAN = 6.0, 1.1774
# Minimum scales for outlier rejection: without a field, and with it.
FIRST_SCALE_PX, MIN_SCALE_PX = 0.5, 0.05
MAX_N_STEPS, STEP_TOL_PX = 30, 1e-5
SELECTION_STEPS = (2, 5)  # steps at which cells and smoothness are chosen
MIN_N_CORNERS = 6  # of a board
N_AMPLITUDES = 61  # of the random field, four in a decade of the smoothness
N_ROTATIONS = 3  # among the changes, without an effect on corners
CHANGE_SMOOTHNESS = 1e-9  # continues changes of the trend where it has no rays


class SplineAdjustment(NamedTuple):
    """Hold a field on a trend, adjusted with the poses of boards.

    Attributes
    ----------
    camera : RaySplineCamera
        The camera.
    T_camera_grid : ndarray, shape (n, 4, 4)
        Poses of the boards.
    residuals_px : list of ndarray, shape (N, 2)
        Found less projected corners, px; NaN for corners that the trend does not image.
    outliers : list of ndarray of bool, shape (N,)
        Whether a corner is rejected.
    sd_px : float
        Standard deviation of a coordinate, px.
    cells : int
        Cells of the field along the longer side.
    smoothness : float
        The chosen smoothness.
    held_out_px : dict of int to float
        RMS distance on held-out boards, px, at the best smoothness, by number of cells;
        0: of the trend alone.
    steps : int
        Number of steps.
    """

    camera: RaySplineCamera
    T_camera_grid: np.ndarray
    residuals_px: list
    outliers: list
    sd_px: float
    cells: int
    smoothness: float
    held_out_px: dict
    steps: int


class _Choice(NamedTuple):
    grid: object
    smoothness: float
    held_out: dict


def adjust_spline(
    trend: Any,
    T_camera_grid: ArrayLike,
    boards: Sequence[tuple[np.ndarray, np.ndarray]],
    width: int,
    height: int,
    slopes: Callable[[np.ndarray], np.ndarray] | None = None,
) -> SplineAdjustment:
    """Adjust a field on a trend and the poses of the boards.

    Parameters
    ----------
    trend : Camera
        Camera on which the field is based.
    T_camera_grid : array_like, shape (n, 4, 4)
        Start at which the trend images most corners.
    boards : sequence of (pixels, points)
        pixels (N, 2); points (N, 2) on a flat board, or (N, 3) in its frame.
    width, height : int
        Size of the image, px.
    slopes : callable, optional
        Derivatives (N, 2, P) of the trend's pixels at points (N, 3), camera frame, by
        its parameters, for a trend that was fitted to the same boards. The predicted
        errors of the camera include those of the parameters.

    Returns
    -------
    SplineAdjustment
        The camera and the poses.

    Raises
    ------
    CalibrationError
        If there are fewer than two boards, or one of which the trend images fewer than
        six corners.
    """
    corners, T = _stacked(boards), np.array(T_camera_grid, float)
    part = np.arange(len(T)) % MAX_N_FOLDS
    grids = [grid_of(cells, width, height, corners.pixels) for cells in CELLS]
    choice = _Choice(grids[0], SMOOTHNESS[-1], {})
    control = choice.grid.blank  # type: ignore[attr-defined]
    for step in range(MAX_N_STEPS):
        linear = linear_part.linearised(trend, T, corners, control, choice.grid)
        _check(linear, corners, len(T))
        weights, _ = _weights(linear.off, early=step <= SELECTION_STEPS[0])
        if step in SELECTION_STEPS:
            choice = _chosen(corners, linear, weights, grids, part)
        of = linear_part.equations(corners, linear, weights, choice.grid, part)
        parts = linear_part.normal_parts(of, choice.grid)
        normal = linear_part.normal_matrix(parts, choice.smoothness)
        c = linear_part.solved(normal, of.right.sum(axis=0))
        T = linear_part.moved_boards(T, of, c)
        before = control
        control = np.ascontiguousarray(
            c.reshape(2, *choice.grid.shape).transpose(1, 2, 0)  # type: ignore[attr-defined]
        )
        if step > SELECTION_STEPS[1] and np.abs(control - before).max() < STEP_TOL_PX:
            break
    size = width, height
    return _completed(trend, T, corners, control, choice, of, step + 1, size, slopes)


def _stacked(boards):
    if len(boards) < 2:
        raise CalibrationError(
            f"smooth rays: found {len(boards)} boards for the adjustment; give two or "
            "more",
            code="too-few-grids",
        )
    pixels, points = (np.concatenate(part) for part in zip(*boards, strict=True))
    board = np.repeat(np.arange(len(boards)), [len(own) for own, _ in boards])
    solid = points if points.shape[1] == 3 else on_plane(points)
    return CornersOfBoards(pixels, solid, board)


def _check(linear, corners, count):
    imaged = np.bincount(corners.board[linear.imaged], minlength=count)
    for k in np.flatnonzero(imaged < MIN_N_CORNERS):
        raise CalibrationError(
            f"smooth rays: board {k}: the trend images {imaged[k]} of its corners; at "
            f"least {MIN_N_CORNERS} are required",
            code="too-few-points",
        )


def _weights(off, early):
    """Weights (N,) of errors (N, 2) and their scale, px, of a coordinate."""
    distance = np.linalg.norm(off, axis=1)
    there = np.isfinite(distance)
    least = FIRST_SCALE_PX if early else MIN_SCALE_PX
    scale = max(float(np.median(distance[there])) / RAYLEIGH_MEDIAN, least)
    squares = np.where(there, distance / scale, np.inf) ** 2
    if early:
        return 1 / (1 + squares / 9), scale
    return np.maximum(1 - squares / OUTLIER_SCALES**2, 0.0) ** 2, scale


# --------------------------------------------------------------- cells and smoothness


def _chosen(corners, linear, weights, grids, part):
    """_Choice with the best prediction of held-out boards."""
    best, held_out = (np.inf, None, None), {}
    total = 2 * weights.sum()
    for grid in grids:
        of = linear_part.equations(corners, linear, weights, grid, part)
        score, smoothness = _best_smoothness(of, grid)
        held_out[0] = float(np.sqrt(2 * max(of.squares.sum(), 0) / total))
        held_out[grid.cells] = float(np.sqrt(2 * max(score, 0) / total))
        if not score < best[0]:
            break  # finer cells follow the noise even more
        best = score, grid, smoothness
    return _Choice(best[1], best[2], held_out)


def _best_smoothness(of, grid):
    """(score, smoothness): the better result of two descents. For a nearly sufficient
    trend, a maximum separates it from the useful field."""
    parts = linear_part.normal_parts(of, grid)
    score = cache(lambda k: linear_part.held_out(of, parts, SMOOTHNESS[k]))
    ends = [downhill(score, start, len(SMOOTHNESS)) for start in START_INDICES]
    best = min(ends, key=score)
    return score(best), float(SMOOTHNESS[best])


# ----------------------------------------------------------------------------- result


def _completed(trend, T, corners, control, choice, of, steps, size, slopes):
    grid = choice.grid
    plain = RaySplineCamera(trend, grid.spacing, control, *size)
    posed = np.concatenate(
        [
            transform(pose, corners.points[corners.board == k])
            for k, pose in enumerate(T)
        ]
    )
    residuals = corners.pixels - plain.project(posed).pixels
    _, scale = _weights(residuals, early=False)
    distance = np.linalg.norm(residuals, axis=1)
    inlier = distance <= OUTLIER_SCALES * scale
    changes = _changes(plain, grid, T, slopes)
    degrees = 2 * np.count_nonzero(inlier) - 6 * len(T)
    errors, taken = _errors(of, grid, choice.smoothness, changes, degrees)
    left = max(degrees - taken, 1)
    sd_px = float(np.sqrt(np.sum(distance[inlier] ** 2) / left))
    covered = linear_part.covered_cells(
        corners.pixels[inlier], grid.shape, grid.spacing
    )
    camera = RaySplineCamera(
        trend, grid.spacing, control, *size, covered,
        sd_px**2 * _at_nodes(errors, grid),
    )  # fmt: skip
    ends = np.cumsum(np.bincount(corners.board))[:-1]
    return SplineAdjustment(
        camera, T, np.split(residuals, ends), np.split(~inlier, ends), sd_px,
        grid.cells, choice.smoothness, choice.held_out, steps,
    )  # fmt: skip


# Errors of a field and its trend. The trend is a model whose parameters b were fitted
# to the same corners, and the lens is any member of that model plus a field f. Of f the
# prior is that of the adjustment, a random function with the covariance t^2 P^-1. With
# the normal matrix M of the corners (poses eliminated, common rotations excluded), the
# columns Z of changes by b and by rotations, and the noise n, the two fits are
#
#     Z b = H (M f + n),  H = Z (Z'M Z)^-1 Z',    c = A^-1 (M f + n - M Z b),
#
# A = M + smoothness (P + ties). So Z b + c = L (M f + n), L = A^-1 + (I - A^-1 M) H,
# has the covariance of errors s^2 L M L' + t^2 (L M - I) P^-1 (L M - I)'. The first
# part is noise, the second what the fits smooth away; (L M - I) Z = 0. The amplitude t
# is that of the largest likelihood with b free (restricted maximum likelihood, H. D.
# Patterson and R. Thompson 1971, doi:10.1093/biomet/58.3.545): the smoothness that
# predicts best may be far from s^2 / t^2.


def _errors(of, grid, smoothness, changes, degrees):
    """Covariance (2K, 2K) of control values, in variances of a coordinate, and the
    effective number of parameters.

    changes (2K, Q): Z; degrees: number of coordinates less those of the poses.
    """
    from scipy.linalg import eigh

    parts = linear_part.normal_parts(of, grid)
    normal, prior = parts[0] + parts[2], of.of_a_cell * linear_part.twice(grid.penalty)
    inverse = np.linalg.inv(linear_part.normal_matrix(parts, smoothness))
    pulled = normal @ changes
    left = (changes - inverse @ pulled) @ np.linalg.pinv(changes.T @ pulled)
    fit = inverse + left @ changes.T
    follows = fit @ normal
    # In these axes the prior is 1, and the normal matrix is diagonal.
    size, axes = eigh(normal, prior)
    right, seen = axes.T @ of.right.sum(axis=0), axes.T @ (prior @ changes)
    known = of.squares.sum(), np.maximum(size, 0.0), right, seen
    lost = follows @ axes - axes
    smoothed = lost @ lost.T / _likeliest(*known, degrees)
    # Of a linear fit F the residuals have the squares of n - tr(2 F - F F) coordinates.
    taken = 2 * np.trace(follows) - np.vdot(follows, follows.T) - N_ROTATIONS
    return follows @ fit.T + smoothed, float(taken)


def _likeliest(squares, size, right, changes, degrees):
    """Smoothness s^2 / t^2 of the largest restricted likelihood.

    squares of the corners, normal matrix size (2K,), right (2K,) and changes (2K, Q) in
    the axes of the prior.
    """
    least = degrees * STEP_TOL_PX**2
    degrees, losses = degrees - changes.shape[1] + N_ROTATIONS, []
    tried = np.geomspace(SMOOTHNESS[0], SMOOTHNESS[-1], N_AMPLITUDES)
    for smoothness in tried:
        share = smoothness / (size + smoothness)
        information = (changes.T * (size * share)) @ changes
        pull = changes.T @ (share * right)
        left = squares - np.sum(right**2 / (size + smoothness))
        left -= pull @ np.linalg.solve(information, pull)
        volume = np.linalg.slogdet(information)[1] - np.sum(np.log(share))
        losses.append(degrees * np.log(max(left, least)) + volume)
    return tried[np.argmin(losses)]


def _changes(camera, grid, T_camera_grid, slopes):
    """Control values (2K, Q) of the trend's changes with its parameters, and with
    common rotations, at the distance of the boards."""
    places = node_places(grid.shape, grid.spacing).reshape(-1, 2)
    rays = camera.rays(places)
    distance = np.median(np.linalg.norm(T_camera_grid[:, :3, 3], axis=1))
    points = rays.origins + distance * rays.directions
    by_point = linear_part.image_slopes(camera.trend, points)
    fields = [by_point @ -cross_matrix(points)] + ([slopes(points)] if slopes else [])
    found = np.concatenate(fields, axis=2)
    known = np.isfinite(found).all(axis=(1, 2))
    index, share = shares(places[known], grid.shape, grid.spacing)
    basis = np.zeros((len(index), len(grid.penalty)))
    np.add.at(basis, (np.arange(len(index))[:, None], index), share)
    square = basis.T @ basis + CHANGE_SMOOTHNESS * grid.penalty
    values = [np.linalg.solve(square, basis.T @ found[known, a]) for a in (0, 1)]
    changes = np.concatenate(values)
    return changes / np.linalg.norm(changes, axis=0)


def _at_nodes(inverse, grid):
    """uu, uv, vv (rows, columns, 3) of the field at `node_places`."""
    places = node_places(grid.shape, grid.spacing)
    index, share = shares(places.reshape(-1, 2), grid.shape, grid.spacing)
    count = len(inverse) // 2
    found = []
    for a, b in ((0, 0), (0, 1), (1, 1)):
        near = inverse[a * count + index[:, :, None], b * count + index[:, None]]
        found.append(np.einsum("ni,nij,nj->n", share, near, share))
    return np.stack(found, axis=1).reshape(*places.shape[:2], 3)
