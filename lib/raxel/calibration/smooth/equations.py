"""Linear equations of a smooth field and the poses of boards, poses eliminated.

With its board posed, a corner's point is imaged by the trend at q, and by the camera at
the place p that has p + s(p) = q (`raxel.cameras.tables.ray_spline`). The corner was
found at p + e. When control values change s by ds, and a pose moves q by dq,

    e changes by (I + s'(p))^-1 (ds(p) - dq).

All is taken at p, not where the corner was found: a field that is read at noisy places
follows their noise, and what boards hardly determine (a scale against all depths) then
comes out wrong, the more so the more corners there are.

Each board's six pose parameters occur in its own equations alone and are eliminated
from them. What is left of a board is a quadratic form: what the field costs once that
board's pose alone is fitted to it.
"""

from functools import lru_cache
from typing import NamedTuple

import numba
import numpy as np

from raxel.calibration.smooth.prior import FADE, far_from_data, penalty_matrix
from raxel.cameras.tables.cubic_field import (
    control_shape,
    field_at,
    shares,
    undisplaced,
)
from raxel.geometry.poses import cross_matrix, pose, rotation_from_vector

STEP = 1e-5  # of a point's distance, for how its image moves
GAUGE = 1e3  # times the largest of the normal matrix, against common rotations


class CornersOfBoards(NamedTuple):
    """pixels (N, 2), points (N, 3) of boards, board (N,) in rising order."""

    pixels: np.ndarray
    points: np.ndarray
    board: np.ndarray


class FieldGrid(NamedTuple):
    """cells along the longer side; spacing px; shape of the control values; penalty
    (K, K) and ties (K,) of `raxel.calibration.smooth.prior`."""

    cells: int
    spacing: float
    shape: tuple
    penalty: np.ndarray
    ties: np.ndarray

    @property
    def blank(self):
        """Control values (rows, columns, 2) of no field."""
        return np.zeros((*self.shape, 2))


class LinearParts(NamedTuple):
    """About given poses and a given field, of each corner: place (N, 2), p; off (N, 2),
    e, both NaN where the trend has no image; values (N, 2), what s(p) would have to be
    for e to vanish; white (N, 2, 2), (I + s')^-1; by_pose (N, 2, 6), how q moves with
    R exp([w]x), t + R s; by_turn (N, 2, 3), with a common rotation; imaged (N,) bool.
    """

    place: np.ndarray
    off: np.ndarray
    values: np.ndarray
    white: np.ndarray
    by_pose: np.ndarray
    by_turn: np.ndarray
    imaged: np.ndarray


class Equations(NamedTuple):
    """Sums of parts of the boards: normal (P, 2K, 2K), right (P, 2K), squares (P,).

    gauge: (2K, 3), directions that the field has no part in; of_a_cell: weight of one
    cell's corners. For the poses: by_control (n, 2K, 6), what control values do to
    their equations; inverse (n, 6, 6) of their normal matrices; by_values (n, 6).
    """

    normal: np.ndarray
    right: np.ndarray
    squares: np.ndarray
    gauge: np.ndarray
    of_a_cell: float
    by_control: np.ndarray
    inverse: np.ndarray
    by_values: np.ndarray


def grid_of(cells, width, height, pixels):
    """The FieldGrid with so many cells along the longer side, for corners at pixels."""
    spacing = max(width, height) / cells
    shape = control_shape(width, height, spacing)
    far = far_from_data(covered_cells(pixels, shape, spacing))
    return FieldGrid(cells, spacing, shape, _penalty(shape), FADE * far)


@lru_cache(maxsize=8)
def _penalty(shape):
    # A grid's penalty hangs on its shape alone, and many fits have the same few.
    penalty = penalty_matrix(shape).toarray()
    penalty.flags.writeable = False
    return penalty


def covered_cells(pixels, shape, spacing):
    """(rows - 3, columns - 3) bool: cells that hold one of the pixels (N, 2)."""
    covered = np.zeros(np.subtract(shape, 3), bool)
    last = np.array(covered.shape[::-1]) - 1
    column, row = np.clip((pixels + 0.5) // spacing, 0, last).astype(int).T
    covered[row, column] = True
    return covered


def occupied_cells(pixels, spacing):
    """How many cells hold one of the pixels (N, 2), inside the image or not."""
    column, row = ((pixels + 0.5) // spacing).T
    order = np.lexsort((column, row))
    column, row = column[order], row[order]
    new = (np.diff(column) != 0) | (np.diff(row) != 0)
    return min(len(pixels), 1) + np.count_nonzero(new)


def linearised(trend, T_camera_grid, corners, control, grid):
    """The LinearParts at poses (n, 4, 4) and control values (rows, columns, 2)."""
    T = T_camera_grid[corners.board]
    R = T[:, :3, :3]
    points = (R @ corners.points[:, :, None])[..., 0] + T[:, :3, 3]
    seen = trend.project(points)
    by_point = image_slopes(trend, points)
    imaged = seen.valid & np.isfinite(by_point).all(axis=(1, 2))
    by_point[~imaged] = 0.0
    place = undisplaced(seen.pixels, control, grid.spacing)
    place[~imaged] = np.nan
    _, slopes = field_at(place, control, grid.spacing)
    forward = np.eye(2) + np.nan_to_num(slopes)
    off = corners.pixels - place
    values = seen.pixels - place - (forward @ off[..., None])[..., 0]
    motion = np.concatenate([-R @ cross_matrix(corners.points), R], axis=2)
    return LinearParts(
        place, off, np.nan_to_num(values), np.linalg.inv(forward), by_point @ motion,
        by_point @ -cross_matrix(points), imaged,
    )  # fmt: skip


def image_slopes(trend, points):
    """How the images of points (N, 3) move with them: (N, 2, 3), by differences."""
    step = STEP * np.linalg.norm(points, axis=1)
    slopes = np.empty((len(points), 2, 3))
    for axis, direction in enumerate(np.eye(3)):
        shift = step[:, None] * direction
        ahead, behind = (trend.project(points + s).pixels for s in (shift, -shift))
        slopes[:, :, axis] = (ahead - behind) / (2 * step[:, None])
    return slopes


def equations(corners, linear, weights, grid, part):
    """The Equations of weighted corners; weights (N,), part (n,): of each board."""
    white, J = linear.white, linear.by_pose
    metric = weights[:, None, None] * (np.swapaxes(white, 1, 2) @ white)
    count, n, parts = int(np.prod(grid.shape)), len(part), part.max() + 1
    place = np.where(linear.imaged[:, None], linear.place, 0.0)
    basis = shares(place, grid.shape, grid.spacing)
    pulled, weighted = metric @ J, (metric @ linear.values[..., None])[..., 0]
    of_board = np.eye(n)[corners.board].T
    P = (of_board @ (np.swapaxes(J, 1, 2) @ pulled).reshape(-1, 36)).reshape(n, 6, 6)
    inverse = np.linalg.pinv(P, hermitian=True)
    g = of_board @ np.einsum("nij,ni->nj", J, weighted)
    E = _lifted(*basis, pulled, corners.board, n, count)
    own = part[corners.board]
    normal = _products(*basis, metric, own, parts, count)
    right = _lifted(*basis, weighted[..., None], own, parts, count)[..., 0]
    squares = np.bincount(own, np.sum(linear.values * weighted, axis=1), parts)
    for p in range(parts):
        of_part = E[part == p]
        solved = of_part @ inverse[part == p]
        normal[p] -= np.tensordot(solved, of_part, ((0, 2), (0, 2)))
        right[p] -= np.einsum("nij,nj->i", solved, g[part == p])
    squares -= np.bincount(part, np.einsum("ni,nij,nj->n", g, inverse, g), parts)
    one, turns = np.zeros(len(own), int), metric @ linear.by_turn
    turned = _lifted(*basis, turns, one, 1, count)[0]
    cells = occupied_cells(corners.pixels[weights > 0], grid.spacing)
    of_a_cell = weights.sum() / max(cells, 1)
    gauge = np.linalg.qr(turned)[0]
    return Equations(normal, right, squares, gauge, of_a_cell, E, inverse, g)


@numba.njit(cache=True)
def _lifted(index, share, values, group, groups, count):
    """B^T values, for both coordinates, summed by group: (groups, 2K, m) of values
    (N, 2, m), with the shares that K control values have at N corners."""
    _, _, m = values.shape
    found = np.zeros((groups, 2 * count, m))
    for n in range(len(index)):
        for a in range(2):
            for k in range(16):
                own = found[group[n], a * count + index[n, k]]
                for c in range(m):
                    own[c] += share[n, k] * values[n, a, c]
    return found


@numba.njit(cache=True)
def _products(index, share, metric, group, groups, count):
    """B^T metric B (groups, 2K, 2K), summed by group; metric (N, 2, 2), symmetric."""
    found = np.zeros((groups, 2 * count, 2 * count))
    for n in range(len(index)):
        own = found[group[n]]
        xx, xy, yy = metric[n, 0, 0], metric[n, 0, 1], metric[n, 1, 1]
        for k in range(16):
            i = index[n, k]
            for m in range(16):
                j, both = index[n, m], share[n, k] * share[n, m]
                own[i, j] += both * xx
                own[i, count + j] += both * xy
                own[count + i, j] += both * xy
                own[count + i, count + j] += both * yy
    return found


def normal_parts(of, grid):
    """Three parts (2K, 2K) of a normal matrix: of all data; what is expected of a
    field, in data of a cell; and that it has no part in common rotations."""
    expected = of.of_a_cell * twice(grid.penalty + np.diag(grid.ties))
    return of.normal.sum(axis=0), expected, held(of)


def normal_matrix(parts, smoothness):
    """(2K, 2K) from its `normal_parts`."""
    data, expected, rotations = parts
    return data + smoothness * expected + rotations


def held(of):
    """(2K, 2K): the field has no part in common rotations."""
    most = np.diagonal(of.normal.sum(axis=0)).max()
    return GAUGE * most * of.gauge @ of.gauge.T


def twice(penalty):
    """(2K, 2K): the same for both coordinates."""
    zero = np.zeros_like(penalty)
    return np.block([[penalty, zero], [zero, penalty]])


def solved(normal, right):
    """Control values (2K,): the u of all, then the v of all."""
    from scipy.linalg import cho_factor, cho_solve

    # `solve` would estimate the condition too, which takes as long again.
    factor = cho_factor(normal, check_finite=False)
    return cho_solve(factor, right, check_finite=False)


def held_out(of, parts, smoothness):
    """Sum over parts of squares from a field fitted without them, poses fitted anew;
    parts: the `normal_parts` of `of`."""
    normal, right = normal_matrix(parts, smoothness), of.right.sum(axis=0)
    score = 0.0
    for own, of_own, squares in zip(of.normal, of.right, of.squares, strict=True):
        c = solved(normal - own, right - of_own)
        score += squares - 2 * of_own @ c + c @ own @ c
    return float(score)


def moved_boards(T_camera_grid, of, c):
    """Poses after the step that suits control values c (2K,) best."""
    miss = np.einsum("nij,i->nj", of.by_control, c) - of.by_values
    step = (of.inverse @ miss[..., None])[..., 0]
    R, t = T_camera_grid[:, :3, :3], T_camera_grid[:, :3, 3]
    turned = R @ rotation_from_vector(step[:, :3])
    return pose(turned, t + (R @ step[:, 3:, None])[..., 0])
