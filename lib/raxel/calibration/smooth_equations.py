"""LinearParts equations of a smooth field and the poses of boards, poses eliminated.

With its board posed, a corner's point is imaged by the trend at q, and by the camera at
the place p that has p + s(p) = q (`raxel.cameras.ray_spline`). The corner was found at
p + e. When control values change s by ds, and a pose moves q by dq,

    e changes by (I + s'(p))^-1 (ds(p) - dq).

All is taken at p, not where the corner was found: a field that is read at noisy places
follows their noise, and what boards hardly determine (a scale against all depths) then
comes out wrong, the more so the more corners there are.

Each board's six pose parameters occur in its own equations alone and are eliminated
from them. What is left of a board is a quadratic form: what the field costs once that
board's pose alone is fitted to it.
"""

from typing import NamedTuple

import numpy as np

from raxel.calibration.smooth_prior import far_ties, penalty_matrix
from raxel.cameras.cubic_field import control_shape, field_at, shares, undisplaced
from raxel.geometry.poses import cross_matrix, pose, rotation_from_vector

STEP = 1e-5  # of a point's distance, for how its image moves
GAUGE = 1e3  # times the largest of the normal matrix, against common rotations


class CornersOfBoards(NamedTuple):
    """pixels (N, 2), points (N, 3) with z = 0, board (N,) in rising order."""

    pixels: np.ndarray
    points: np.ndarray
    board: np.ndarray


class FieldGrid(NamedTuple):
    """cells along the longer side; spacing px; shape of the control values; penalty
    (K, K) and ties (K,) of `raxel.calibration.smooth_prior`."""

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
    covered = covered_cells(pixels, shape, spacing)
    penalty = penalty_matrix(shape).toarray()
    return FieldGrid(cells, spacing, shape, penalty, far_ties(covered))


def covered_cells(pixels, shape, spacing):
    """(rows - 3, columns - 3) bool: cells that hold one of the pixels (N, 2)."""
    covered = np.zeros(np.subtract(shape, 3), bool)
    last = np.array(covered.shape[::-1]) - 1
    column, row = np.clip((pixels + 0.5) // spacing, 0, last).astype(int).T
    covered[row, column] = True
    return covered


def linearised(trend, T_camera_grid, corners, control, grid):
    """The LinearParts equations' parts at poses (n, 4, 4) and control values."""
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
    basis = _Basis(*shares(place, grid.shape, grid.spacing), count)
    pulled, told = metric @ J, (metric @ linear.values[..., None])[..., 0]
    of_board = np.eye(n)[corners.board].T
    P = (of_board @ (np.swapaxes(J, 1, 2) @ pulled).reshape(-1, 36)).reshape(n, 6, 6)
    inverse = np.linalg.pinv(P, hermitian=True)
    g = of_board @ np.einsum("nij,ni->nj", J, told)
    E = basis.lifted(pulled, corners.board, n)
    own = part[corners.board]
    normal = basis.products(metric, own, parts)
    right = basis.lifted(told[..., None], own, parts)[..., 0]
    squares = np.bincount(own, np.sum(linear.values * told, axis=1), parts)
    for p in range(parts):
        of_part = E[part == p]
        solved = of_part @ inverse[part == p]
        normal[p] -= np.tensordot(solved, of_part, ((0, 2), (0, 2)))
        right[p] -= np.einsum("nij,nj->i", solved, g[part == p])
    squares -= np.bincount(part, np.einsum("ni,nij,nj->n", g, inverse, g), parts)
    all_turned = basis.lifted(metric @ linear.by_turn, np.zeros(len(own), int), 1)[0]
    cell = ((corners.pixels + 0.5) // grid.spacing)[weights > 0]
    of_a_cell = weights.sum() / max(len(np.unique(cell, axis=0)), 1)
    gauge = np.linalg.qr(all_turned)[0]
    return Equations(normal, right, squares, gauge, of_a_cell, E, inverse, g)


class _Basis:
    """What part each of `count` control values has in the field at N corners."""

    def __init__(self, index, share, count):
        self._index, self._share, self._count = index, share, count

    def _grouped(self, group, groups):
        """(groups * count, N) sparse: a corner's shares in the rows of its group."""
        from scipy.sparse import csc_array

        rows = (group[:, None] * self._count + self._index).ravel()
        start = 16 * np.arange(len(group) + 1)
        shape = groups * self._count, len(group)
        return csc_array((self._share.ravel(), rows, start), shape)

    def lifted(self, values, group, groups):
        """B^T values, for both coordinates, summed by group: (groups, 2K, m) of values
        (N, 2, m)."""
        matrix = self._grouped(group, groups)
        found = [
            (matrix @ values[:, axis]).reshape(groups, self._count, -1)
            for axis in range(2)
        ]
        return np.concatenate(found, axis=1)

    def products(self, metric, group, groups):
        """B^T metric B (groups, 2K, 2K), summed by group; metric (N, 2, 2)."""
        matrix = self._grouped(group, groups)
        one = self._grouped(np.zeros(len(group), int), 1).T.toarray()
        K = self._count
        found = np.empty((groups, 2 * K, 2 * K))
        for a, b in ((0, 0), (0, 1), (1, 1)):
            block = (matrix @ (metric[:, a, b, None] * one)).reshape(groups, K, K)
            rows, columns = slice(a * K, a * K + K), slice(b * K, b * K + K)
            found[:, rows, columns] = found[:, columns, rows] = block
        return found


def system(of, grid, smoothness, without=None):
    """(normal (2K, 2K), right (2K,)) of all parts, or of all but one; with what is
    expected of a field, and without common rotations."""
    normal, right = of.normal.sum(axis=0), of.right.sum(axis=0)
    if without is not None:
        normal, right = normal - of.normal[without], right - of.right[without]
    expected = smoothness * grid.penalty + np.diag(grid.ties)
    return normal + of.of_a_cell * twice(expected) + held(of), right


def held(of):
    """(2K, 2K): the field has no part in common rotations."""
    most = np.diagonal(of.normal.sum(axis=0)).max()
    return GAUGE * most * of.gauge @ of.gauge.T


def twice(penalty):
    """(2K, 2K): the same for both coordinates."""
    zero = np.zeros_like(penalty)
    return np.block([[penalty, zero], [zero, penalty]])


def solved(of, grid, smoothness, without=None):
    """Control values (2K,): the u of all, then the v of all."""
    from scipy.linalg import solve

    normal, right = system(of, grid, smoothness, without=without)
    return solve(normal, right, assume_a="pos", check_finite=False)


def held_out(of, grid, smoothness):
    """Sum over parts of squares from a field fitted without them, poses fitted anew."""
    score = 0.0
    for part in range(len(of.squares)):
        c = solved(of, grid, smoothness, without=part)
        score += of.squares[part] - 2 * of.right[part] @ c + c @ of.normal[part] @ c
    return float(score)


def moved_boards(T_camera_grid, of, c):
    """Poses after the step that suits control values c (2K,) best."""
    miss = np.einsum("nij,i->nj", of.by_control, c) - of.by_values
    step = (of.inverse @ miss[..., None])[..., 0]
    R, t = T_camera_grid[:, :3, :3], T_camera_grid[:, :3, 3]
    turned = R @ rotation_from_vector(step[:, :3])
    return pose(turned, t + (R @ step[:, 3:, None])[..., 0])
