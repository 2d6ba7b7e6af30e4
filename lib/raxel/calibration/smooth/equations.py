"""Linear equations of a smooth field and the poses of boards, poses eliminated.

For a given board pose, the trend images a corner's point at q, and the camera images it
at p with p + s(p) = q (`raxel.cameras.tables.ray_spline`). The corner was detected at
p + e. When control values change s by ds, and a pose moves q by dq,

    e changes by (I + s'(p))^-1 (ds(p) - dq).

All terms are evaluated at p, not at the detected corner: a field evaluated at noisy
positions follows their noise, and weakly determined parameters (a scale against all
depths) are then biased, the more so the more corners there are.

Each board's six pose parameters occur in its own equations only and are eliminated from
them. The remainder of a board is a quadratic form: the cost of the field after a refit
of that board's pose.
"""

from functools import lru_cache
from typing import NamedTuple

import numba
import numpy as np
from scipy.sparse import diags_array, eye_array, kron

from raxel.cameras.tables.interpolation import (
    control_shape,
    cubic_shares,
    field_at,
    shares,
    undisplaced,
)
from raxel.geometry.poses import cross_matrix, pose, rotation_from_vector

# Prior of a smooth field. It penalises squared second differences of neighbouring
# control values, and a share TIE_WEIGHT of the values' own squares. Control values
# without measurements near their middle are tied to zero: the field fades where there
# is no target, and the rays approach those of the trend. Reported errors do not use
# that tie. In a table of rays the tie is FAR_TIE_WEIGHT of the weight of the data of a
# cell: data in the tail of such a value determine it less than that. Corners of boards
# are few, and every tail counts: there the tie is FADE_TIE_WEIGHT times their squares,
# and it weakens with the other priors where corners are exact. A strong tie next to
# precise data would bend the field between them. Reported errors of a table treat
# polynomials to the third degree as unknown: a trend fitted to the same data has such
# errors, which no smoothness removes. Those of a field on boards include the trend's
# own parameters (`raxel.calibration.smooth.adjustment`). Sources: P. Eilers and B. Marx
# 1996, doi:10.1214/ss/1038425655 (penalised splines); G. Wahba 1983,
# doi:10.1111/j.2517-6161.1983.tb01239.x (the covariance of such a fit).


TIE_WEIGHT, FAR_TIE_WEIGHT, FADE_TIE_WEIGHT = 1 / 4, 1e-3, 1.0


def penalty_matrix(shape):
    """(K, K) sparse, of the K = rows * columns control values of one coordinate."""
    rows, columns = shape
    down, along = eye_array(rows), eye_array(columns)
    bends = [
        kron(_differences(rows, (1.0, -2.0, 1.0)), along),
        kron(down, _differences(columns, (1.0, -2.0, 1.0))),
        np.sqrt(2) * kron(_differences(rows, (-1.0, 1.0)),
                          _differences(columns, (-1.0, 1.0))),
    ]  # fmt: skip
    total = sum(part.T @ part for part in bends)
    return (total + TIE_WEIGHT * eye_array(rows * columns)).tocsr()


def far_from_data(covered):
    """(K,) bool: control values without a covered cell near their middle.

    covered: (rows - 3, columns - 3) bool, cells with measurements. Cells outside the
    image count as their neighbours in it.
    """
    framed = np.pad(covered, 2, mode="edge")
    pairs = framed[:-1] | framed[1:]
    return ~(pairs[:, :-1] | pairs[:, 1:]).ravel()


def _differences(count, steps):
    order = len(steps) - 1
    return diags_array(steps, offsets=range(order + 1), shape=(count - order, count))


def free_polynomials(shape):
    """Control values (K, 10) of the polynomials in u and v to the third degree."""
    down, along = (_powers(count) for count in shape)
    columns = [
        np.outer(down[i], along[j]).ravel() for i in range(4) for j in range(4 - i)
    ]
    return np.column_stack(columns)


def _powers(count):
    """Control values of 1, x, x^2, x^3 on count values, x from -1 to 1."""
    knot, half = np.arange(count) - (count - 1) / 2, (count - 1) / 2
    return [
        np.ones(count),
        knot / half,
        (knot**2 - 1 / 3) / half**2,
        (knot**3 - knot) / half**3,
    ]


def node_places(shape, spacing):
    """Pixels (rows, columns, 2) at the corners of the cells and half-way between."""
    rows, columns = (2 * (count - 3) + 1 for count in shape)
    v, u = np.mgrid[:rows, :columns] * (spacing / 2) - 0.5
    return np.stack([u, v], axis=-1)


# Smooth field fitted to values at pixels: sums over millions, then few unknowns. The
# field is that of `raxel.cameras.tables.interpolation`. Least squares needs only a band
# of the normal matrix, which is summed pixel by pixel, separately for each fold of the
# cross-validation.


class FieldSums:
    """Sums of one spacing of cells over an image, in `parts` parts.

    normal: (parts, rows, columns, 4, 7), products of a control value's share with those
    0 to 3 rows on and -3 to 3 columns on; right: (parts, rows, columns, 2); squares,
    weights: (parts,); cells: (rows - 3, columns - 3), number of pixels in each cell.
    """

    def __init__(self, width, height, spacing, parts):
        self.spacing, self.shape = float(spacing), control_shape(width, height, spacing)
        rows, columns = self.shape
        self.normal = np.zeros((parts, rows, columns, 4, 7))
        self.right = np.zeros((parts, rows, columns, 2))
        self.squares, self.weights = np.zeros(parts), np.zeros(parts)
        self.cells = np.zeros((rows - 3, columns - 3), np.int64)

    def add(self, pixels, values, weights, part):
        """Add values (N, 2) at pixels (N, 2) of the image, with weights (N,), to the
        part (N,) of each."""
        _add(
            pixels, values, weights, part, self.spacing,
            self.normal, self.right, self.squares, self.weights, self.cells,
        )  # fmt: skip

    def band(self, parts):
        """Lower band (3 columns + 4, rows * columns) of the sum over parts."""
        rows, columns = self.shape
        summed = self.normal[parts].sum(axis=0)
        band = np.zeros((3 * columns + 4, rows * columns))
        for down in range(4):
            for along in range(-3 if down else 0, 4):
                # The later value of a pair that would leave its row does not exist.
                band[down * columns + along] += summed[:, :, down, along + 3].ravel()
        return band

    def quadratic(self, part, control):
        """Sum over a part of weights times squared distances from the field (K, 2)."""
        product = band_product(self.band([part]), control)
        right = self.right[part].reshape(-1, 2)
        return float(
            self.squares[part] - 2 * np.vdot(right, control) + np.vdot(product, control)
        )


def band_of(matrix, width):
    """Lower band (width, K) of a sparse symmetric matrix (K, K)."""
    below = matrix.tocoo()
    row, column = below.coords
    keep = row >= column
    band = np.zeros((width, matrix.shape[0]))
    band[(row - column)[keep], column[keep]] = below.data[keep]
    return band


def band_product(band, values):
    """Symmetric matrix of this lower band times values (K, 2)."""
    product = band[0][:, None] * values
    for offset in range(1, len(band)):
        line = band[offset, : len(values) - offset, None]
        if line.any():
            product[offset:] += line * values[:-offset]
            product[:-offset] += line * values[offset:]
    return product


@numba.njit(cache=True)
def _add(pixels, values, weights, part, spacing, normal, right, squares, total, cells):
    # The loop over pixels sums the products of one cell after the other: 16 x 16.
    b, slope, d = np.empty(4), np.empty(4), np.empty(4)
    for n in range(len(pixels)):
        w = weights[n]
        if not w > 0:
            continue
        x, y = (pixels[n, 0] + 0.5) / spacing, (pixels[n, 1] + 0.5) / spacing
        i = min(max(int(x), 0), cells.shape[1] - 1)
        j = min(max(int(y), 0), cells.shape[0] - 1)
        cubic_shares(x - i, b, slope)
        cubic_shares(y - j, d, slope)
        f = part[n]
        cells[j, i] += 1
        total[f] += w
        squares[f] += w * (values[n, 0] ** 2 + values[n, 1] ** 2)
        for k in range(4):
            for m in range(4):
                share = w * d[k] * b[m]
                right[f, j + k, i + m, 0] += share * values[n, 0]
                right[f, j + k, i + m, 1] += share * values[n, 1]
                for p in range(k, 4):
                    first = m if p == k else 0
                    for q in range(first, 4):
                        normal[f, j + k, i + m, p - k, q - m + 3] += share * d[p] * b[q]


RELATIVE_STEP = 1e-5  # over a point's distance, for derivatives of its image
GAUGE_WEIGHT = 1e3  # times the largest normal-matrix entry, against common rotations


class CornersOfBoards(NamedTuple):
    """pixels (N, 2), points (N, 3) of boards, board (N,) in rising order."""

    pixels: np.ndarray
    points: np.ndarray
    board: np.ndarray


class FieldGrid(NamedTuple):
    """cells along the longer side; spacing, px; shape of the control values; penalty
    (K, K) and ties (K,) of the prior."""

    cells: int
    spacing: float
    shape: tuple
    penalty: np.ndarray
    ties: np.ndarray

    @property
    def blank(self):
        """Control values (rows, columns, 2) of a zero field."""
        return np.zeros((*self.shape, 2))


class LinearParts(NamedTuple):
    """Linearisation at given poses and field, for each corner: place (N, 2), p; off (N,
    2), e, both NaN where the trend has no image; values (N, 2), s(p) for e = 0; white
    (N, 2, 2), (I + s')^-1; by_pose (N, 2, 6), derivative of q by R exp([w]x), t + R s;
    by_turn (N, 2, 3), by a common rotation; imaged (N,) bool.
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

    gauge: (2K, 3), directions excluded from the field; of_a_cell: weight of one cell's
    corners. For the poses: by_control (n, 2K, 6), coupling of control values with their
    equations; inverse (n, 6, 6) of their normal matrices; by_values (n, 6).
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
    """FieldGrid with this number of cells along the longer side, for corner pixels."""
    spacing = max(width, height) / cells
    shape = control_shape(width, height, spacing)
    far = far_from_data(covered_cells(pixels, shape, spacing))
    return FieldGrid(cells, spacing, shape, _penalty(shape), FADE_TIE_WEIGHT * far)


@lru_cache(maxsize=8)
def _penalty(shape):
    # A grid's penalty depends on its shape only, and many fits have the same few.
    penalty = penalty_matrix(shape).toarray()
    penalty.flags.writeable = False
    return penalty


def covered_cells(pixels, shape, spacing):
    """(rows - 3, columns - 3) bool: cells that contain one of the pixels (N, 2)."""
    covered = np.zeros(np.subtract(shape, 3), bool)
    last = np.array(covered.shape[::-1]) - 1
    column, row = np.clip((pixels + 0.5) // spacing, 0, last).astype(int).T
    covered[row, column] = True
    return covered


def occupied_cells(pixels, spacing):
    """Number of cells that contain one of the pixels (N, 2), inside the image or
    not."""
    column, row = ((pixels + 0.5) // spacing).T
    order = np.lexsort((column, row))
    column, row = column[order], row[order]
    new = (np.diff(column) != 0) | (np.diff(row) != 0)
    return min(len(pixels), 1) + np.count_nonzero(new)


def linearised(trend, T_camera_grid, corners, control, grid):
    """LinearParts at poses (n, 4, 4) and control values (rows, columns, 2)."""
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
    errors = corners.pixels - place
    values = seen.pixels - place - (forward @ errors[..., None])[..., 0]
    motion = np.concatenate([-R @ cross_matrix(corners.points), R], axis=2)
    return LinearParts(
        place, errors, np.nan_to_num(values), np.linalg.inv(forward), by_point @ motion,
        by_point @ -cross_matrix(points), imaged,
    )  # fmt: skip


def image_slopes(trend, points):
    """Derivatives of the images of points (N, 3): (N, 2, 3), by differences."""
    step = RELATIVE_STEP * np.linalg.norm(points, axis=1)
    slopes = np.empty((len(points), 2, 3))
    for axis, direction in enumerate(np.eye(3)):
        shift = step[:, None] * direction
        ahead, behind = (trend.project(points + s).pixels for s in (shift, -shift))
        slopes[:, :, axis] = (ahead - behind) / (2 * step[:, None])
    return slopes


def equations(corners, linear, weights, grid, part):
    """Equations of weighted corners; weights (N,), part (n,): of each board."""
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
    """B^T values, for both coordinates, summed by group: (groups, 2K, m) of values (N,
    2, m), with the shares of K control values at N corners."""
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
    """Three parts (2K, 2K) of a normal matrix: of all data; of the prior, in data of a
    cell; and of the exclusion of common rotations."""
    expected = of.of_a_cell * twice(grid.penalty + np.diag(grid.ties))
    return of.normal.sum(axis=0), expected, held(of)


def normal_matrix(parts, smoothness):
    """(2K, 2K) from its `normal_parts`."""
    data, expected, rotations = parts
    return data + smoothness * expected + rotations


def held(of):
    """(2K, 2K): exclusion of common rotations from the field."""
    most = np.diagonal(of.normal.sum(axis=0)).max()
    return GAUGE_WEIGHT * most * of.gauge @ of.gauge.T


def twice(penalty):
    """(2K, 2K): the same for both coordinates."""
    zero = np.zeros_like(penalty)
    return np.block([[penalty, zero], [zero, penalty]])


def solved(normal, right):
    """Control values (2K,): all u, then all v."""
    from scipy.linalg import cho_factor, cho_solve

    # `solve` would also estimate the condition number, which doubles the time. The
    # transpose, equal and in the order of LAPACK, needs no copy.
    factor = cho_factor(normal.T, overwrite_a=True, check_finite=False)
    return cho_solve(factor, right, check_finite=False)


def held_out(of, parts, smoothness):
    """Sum over parts of squares from a field fitted without them, after a refit of
    their poses; parts: the `normal_parts` of `of`."""
    normal, right = normal_matrix(parts, smoothness), of.right.sum(axis=0)
    score = 0.0
    for own, of_own, squares in zip(of.normal, of.right, of.squares, strict=True):
        c = solved(normal - own, right - of_own)
        score += squares - 2 * of_own @ c + c @ own @ c
    return float(score)


def downhill(score, here, count):
    """Index below count of a minimum of a score, one step at a time from here."""
    best = min(range(max(here - 1, 0), min(here + 2, count)), key=score)
    return here if best == here else downhill(score, best, count)


def moved_boards(T_camera_grid, of, c):
    """Poses after the best step for control values c (2K,)."""
    miss = np.einsum("nij,i->nj", of.by_control, c) - of.by_values
    step = (of.inverse @ miss[..., None])[..., 0]
    R, t = T_camera_grid[:, :3, :3], T_camera_grid[:, :3, 3]
    turned = R @ rotation_from_vector(step[:, :3])
    return pose(turned, t + (R @ step[:, 3:, None])[..., 0])
