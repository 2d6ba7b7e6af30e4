"""B-spline ray field from corners: field and poses of all boards at once.

There are no interpolated cells and no table. Gauss-Newton solves the equations of
`raxel.calibration.smooth.equations`. A rotation of all rays is equivalent to an
opposite rotation of all poses: the field contains none of the three rotations, on
average over the corners.

Resolution and smoothness of the field are selected by cross-validation on held-out
boards, whose poses alone are refitted. Tukey's biweight excludes outliers in the end.
"""

from __future__ import annotations

from collections.abc import Sequence
from functools import cache
from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from raxel.calibration.smooth import equations as linear_part
from raxel.calibration.smooth.equations import (
    CornersOfBoards,
    free_polynomials,
    grid_of,
    node_places,
)
from raxel.cameras.tables.interpolation import shares
from raxel.cameras.tables.ray_spline import RaySplineCamera
from raxel.errors import CalibrationError
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import transform

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
    return _completed(trend, T, corners, control, choice, of, step + 1, width, height)


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

    @cache
    def score(k):
        return linear_part.held_out(of, parts, SMOOTHNESS[k])

    def downhill(here):
        around = range(max(here - 1, 0), min(here + 2, len(SMOOTHNESS)))
        best = min(around, key=score)
        return here if best == here else downhill(best)

    best = min(map(downhill, START_INDICES), key=score)
    return score(best), float(SMOOTHNESS[best])


# ----------------------------------------------------------------------------- result


def _completed(trend, T, corners, control, choice, of, steps, width, height):
    grid = choice.grid
    plain = RaySplineCamera(trend, grid.spacing, control, width, height)
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
    inverse, taken = _inverse(of, grid, choice.smoothness)
    left = max(2 * np.count_nonzero(inlier) - taken - 6 * len(T), 1)
    sd_px = float(np.sqrt(np.sum(distance[inlier] ** 2) / left))
    covered = linear_part.covered_cells(
        corners.pixels[inlier], grid.shape, grid.spacing
    )
    camera = RaySplineCamera(
        trend, grid.spacing, control, width, height, covered,
        sd_px**2 * _at_nodes(inverse, grid),
    )  # fmt: skip
    ends = np.cumsum(np.bincount(corners.board))[:-1]
    return SplineAdjustment(
        camera, T, np.split(residuals, ends), np.split(~inlier, ends), sd_px,
        grid.cells, choice.smoothness, choice.held_out, steps,
    )  # fmt: skip


def _inverse(of, grid, smoothness):
    """Inverse (2K, 2K) of the normal matrix, polynomials free, and the effective number
    of parameters."""
    free = free_polynomials(grid.shape)
    penalised = grid.penalty @ free
    left = grid.penalty - penalised @ np.linalg.solve(free.T @ penalised, penalised.T)
    expected = smoothness * of.of_a_cell * linear_part.twice(left)
    normal = of.normal.sum(axis=0)
    inverse = np.linalg.inv(normal + expected + linear_part.held(of))
    return inverse, float(np.vdot(inverse, normal))


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
