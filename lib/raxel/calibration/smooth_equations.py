"""Linear equations of a smooth field and the poses of boards, poses eliminated.

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

from raxel.calibration.smooth_prior import penalty_matrix
from raxel.cameras.cubic_field import control_shape, field_at, shares, undisplaced
from raxel.geometry.poses import cross_matrix, pose, rotation_from_vector

STEP = 1e-5  # of a point's distance, for how its image moves
GAUGE = 1e3  # times the largest of the normal matrix, against common rotations


class Corners(NamedTuple):
    """pixels (N, 2), points (N, 3) with z = 0, board (N,) in rising order."""

    pixels: np.ndarray
    points: np.ndarray
    board: np.ndarray


class Grid(NamedTuple):
    """cells along the longer side; spacing px; shape of the control values; penalty
    (K, K)."""

    cells: int
    spacing: float
    shape: tuple
    penalty: np.ndarray

    @property
    def blank(self):
        """Control values (rows, columns, 2) of no field."""
        return np.zeros((*self.shape, 2))


class Linear(NamedTuple):
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
    cell's corners; boards: {board: (E (2K, 6), inverse (6, 6), g (6,))}, for the poses.
    """

    normal: np.ndarray
    right: np.ndarray
    squares: np.ndarray
    gauge: np.ndarray
    of_a_cell: float
    boards: dict


def grid_of(cells, width, height):
    """The Grid with so many cells along the longer side."""
    spacing = max(width, height) / cells
    shape = control_shape(width, height, spacing)
    return Grid(cells, spacing, shape, penalty_matrix(shape).toarray())


def linearised(trend, T_camera_grid, corners, control, grid):
    """The Linear equations' parts at poses (n, 4, 4) and control values."""
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
    return Linear(
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
    from scipy.sparse import csr_array

    white = linear.white
    metric = weights[:, None, None] * (np.swapaxes(white, 1, 2) @ white)
    count, most = np.prod(grid.shape), part.max() + 1
    place = np.where(linear.imaged[:, None], linear.place, 0.0)
    index, share = shares(place, grid.shape, grid.spacing)
    start = 16 * np.arange(len(index) + 1)
    basis = csr_array((share.ravel(), index.ravel(), start), (len(index), count))
    normal = np.zeros((most, 2 * count, 2 * count))
    right, squares = np.zeros((most, 2 * count)), np.zeros(most)
    weighted = metric @ linear.by_pose
    told = (metric @ linear.values[..., None])[..., 0]
    boards = {}
    for p in range(most):
        rows = np.flatnonzero(part[corners.board] == p)
        own, of_part = basis[rows], metric[rows]
        for a in range(2):
            for b in range(2):
                block = own.T @ (of_part[:, a, b, None] * own.toarray())
                across = slice(b * count, (b + 1) * count)
                normal[p, a * count : (a + 1) * count, across] = block
        right[p] = _lifted(own, told[rows])
        squares[p] = np.vdot(linear.values[rows], told[rows])
        for k in np.unique(corners.board[rows]):
            of_board = np.flatnonzero(corners.board == k)
            E = _lifted(basis[of_board], weighted[of_board])
            J = linear.by_pose[of_board]
            inverse = np.linalg.pinv(
                np.einsum("nij,nik->jk", J, weighted[of_board]), hermitian=True
            )
            g = np.einsum("nij,ni->j", J, told[of_board])
            boards[int(k)] = E, inverse, g
            normal[p] -= E @ inverse @ E.T
            right[p] -= E @ (inverse @ g)
            squares[p] -= g @ inverse @ g
    gauge = np.linalg.qr(_lifted(basis, metric @ linear.by_turn))[0]
    cell = ((corners.pixels + 0.5) // grid.spacing)[weights > 0]
    of_a_cell = weights.sum() / max(len(np.unique(cell, axis=0)), 1)
    return Equations(normal, right, squares, gauge, of_a_cell, boards)


def _lifted(basis, values):
    """B^T values, for both coordinates: (2K, ...) of values (N, 2, ...)."""
    return np.concatenate([basis.T @ values[:, 0], basis.T @ values[:, 1]])


def system(of, grid, smoothness, penalty=None, without=None):
    """(normal (2K, 2K), right (2K,)) of all parts, or of all but one; with what is
    expected of a field, and without common rotations."""
    normal, right = of.normal.sum(axis=0), of.right.sum(axis=0)
    if without is not None:
        normal, right = normal - of.normal[without], right - of.right[without]
    penalty = grid.penalty if penalty is None else penalty
    expected = smoothness * of.of_a_cell * np.kron(np.eye(2), penalty)
    held = GAUGE * np.diag(normal).max() * of.gauge @ of.gauge.T
    return normal + expected + held, right


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
    moved = T_camera_grid.copy()
    for k, (E, inverse, g) in of.boards.items():
        step = inverse @ (E.T @ c - g)
        R = moved[k, :3, :3]
        turned = R @ rotation_from_vector(step[:3])
        moved[k] = pose(turned, moved[k, :3, 3] + R @ step[3:])
    return moved
