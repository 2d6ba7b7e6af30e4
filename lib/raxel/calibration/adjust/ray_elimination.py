"""One pass over the rays: normal equations of centre and poses, rays eliminated.

A ray starts in the centre C with direction u. In the frame of grid j it starts in
c = R^T (C - t) and has the direction d = R^T u, so that it meets the grid in

    q = c_xy - c_z m,   m = d_xy / d_z,   at the depth  l = -c_z / d_z.

With A = [I | -m] its derivatives, for steps R exp([w]x) and exp(-[w]x) c + s, are

    dq = A (s + [(q_x, q_y, 0)]x w + l R^T du).

Every grid is thus given relative to the centre. The base does not rotate, and its s is
the step of the centre; the others have w and s: 3 + 6 (n - 1) unknowns, and a point
depends on those of its own grid only. A residual is in the grid's plane and is
multiplied by a whitening matrix [[a, b], [0, c]]. A ray's own two unknowns are two
entries of du, those where u is not largest: du along u moves nothing. They are
eliminated ray by ray (Schur complement).

All work on a ray is done at once, in batches that fit the processor cache; no Jacobian
is stored. Blocks of rays are summed separately and added in a fixed order, so the
results do not depend on the number of processors.
"""

from concurrent.futures import ThreadPoolExecutor
from functools import partial
from typing import NamedTuple

import numpy as np
from numba import njit

from raxel.geometry.poses import pose, rotation_from_vector
from raxel.io.files import processors

BLOCK = 4096  # rays of one partial sum
BATCH = 64  # rays whose whitened rows are stored at once
MAX_DEPTH = 1e300
LOSSES = {"none": 0, "huber": 1, "cauchy": 2}
# Threshold of a loss, in standard deviations of one coordinate.
LOSS_THRESHOLD_SIGMAS = {"none": 1.0, "huber": 2.0, "cauchy": 3.0}

compiled = njit(cache=True, nogil=True, error_model="numpy")
summing = njit(
    cache=True, nogil=True, error_model="numpy", fastmath={"reassoc", "contract"}
)


class NormalEquations(NamedTuple):
    """cost: sum of the loss over all points; normal (p, p), the Gauss-Newton matrix,
    and gradient (p,), half that of the cost, both with the rays eliminated."""

    cost: float
    normal: np.ndarray
    gradient: np.ndarray


def normal_equations(rays, centre, T_base_grid, loss=(0, 1.0), settle=1):
    """NormalEquations at a centre (3,) and poses (n, 4, 4); updates ray directions.

    rays: (points (n, N, 2) float64, whitening (n, N, 3) float32, directions (N, 3));
    whitening contains a, b, c of each point's matrix, a = 0 where not seen. The
    directions are improved in place by `settle` Gauss-Newton steps each. loss: index of
    LOSSES and the squared residual at its threshold. Unknowns: see `moved`.

    The cost is infinite where a ray meets a grid behind the centre.
    """
    points, whitening, directions = rays
    size = 6 * len(points) - 3
    seen_from = frames(centre, T_base_grid)
    add = partial(_add_rays, points, whitening, directions, *seen_from, *loss, settle)
    total = over_blocks(add, points.shape[1], (size + 1, size + 1)).sum(axis=0)
    normal = np.triu(total[:size, :size])
    normal = normal + np.triu(normal, 1).T
    return NormalEquations(float(total[size, size]), normal, total[:size, size].copy())


def moved(centre, T_base_grid, step):
    """Centre and poses after a step (6 n - 3,): s of the base, then w, s of each."""
    T = np.asarray(T_base_grid, float)
    turns, shifts = _of_grids(step)
    R = T[1:, :3, :3] @ rotation_from_vector(turns)
    t = T[1:, :3, 3] + step[:3] - (R @ shifts[..., None])[..., 0]
    return centre + step[:3], np.concatenate([T[:1], pose(R, t)])


def steps_of_poses(T_base_grid):
    """Matrix (6 n - 3, 6 n - 3) from the unknowns of `moved` to plain ones.

    Plain are the steps of the centre, then of each grid but the base its rotation
    vector, in its own frame, and its translation, in the base frame.
    """
    size = 6 * len(T_base_grid) - 3
    change = np.eye(size)
    for j, T in enumerate(T_base_grid[1:]):
        at = 6 + 6 * j
        change[at : at + 3, :3] = np.eye(3)
        change[at : at + 3, at : at + 3] = -T[:3, :3]
    return change


def _of_grids(step):
    both = step[3:].reshape(-1, 2, 3)
    return both[:, 0], both[:, 1]


def over_blocks(work, count, shape=()):
    """Arrays (blocks, *shape), zeros to which work(first, stop, array) has added."""
    firsts = range(0, count, BLOCK)
    sums = np.zeros((len(firsts), *shape))

    def one(block):
        first = block * BLOCK
        work(first, min(first + BLOCK, count), sums[block : block + 1])

    with ThreadPoolExecutor(processors()) as pool:
        list(pool.map(one, range(len(firsts))))
    return sums


def frames(centre, T_base_grid):
    """Rotations R (n, 3, 3), and c = R^T (C - t), (n, 3), of all grids."""
    T = np.asarray(T_base_grid, float)
    R = np.ascontiguousarray(T[:, :3, :3])
    c = np.einsum("nik,ni->nk", R, np.asarray(centre, float) - T[:, :3, 3])
    return R, c


@compiled
def meet(R, c, u):
    """m_x, m_y and depth l where a ray meets a grid."""
    d_x = R[0, 0] * u[0] + R[1, 0] * u[1] + R[2, 0] * u[2]
    d_y = R[0, 1] * u[0] + R[1, 1] * u[1] + R[2, 1] * u[2]
    d_z = R[0, 2] * u[0] + R[1, 2] * u[1] + R[2, 2] * u[2]
    inverse = 1.0 / d_z
    return d_x * inverse, d_y * inverse, -c[2] * inverse


@compiled
def to_unit_length(u):
    """Scale a vector (3,) to unit length, in place."""
    share = 1.0 / np.sqrt(u[0] ** 2 + u[1] ** 2 + u[2] ** 2)
    for k in range(3):
        u[k] *= share


@compiled
def residual(q, w, c, m_x, m_y):
    """Whitened residual of a point."""
    e_x, e_y = c[0] - c[2] * m_x - q[0], c[1] - c[2] * m_y - q[1]
    return w[0] * e_x + w[1] * e_y, w[2] * e_y


@compiled
def _losing(square, kind, bend):
    """Loss of a squared residual, and its derivative: the weight of the point."""
    if kind == 0 or (kind == 1 and square <= bend):
        return square, 1.0
    if kind == 1:
        return 2.0 * np.sqrt(bend * square) - bend, np.sqrt(bend / square)
    return bend * np.log1p(square / bend), 1.0 / (1.0 + square / bend)


@compiled
def _add_rays(
    points, whitening, directions, R, c, kind, bend, settle, first, stop, sums
):
    """Add the rays first..stop to sums (1, p + 1, p + 1): upper triangle of the normal
    matrix, the gradient as its last column, the cost in its corner."""
    grids = len(points)
    size = 6 * grids - 3
    total = sums[0]
    # Whitened rows, two a ray: of each grid's unknowns and residual; of the ray's own.
    of_grid = np.zeros((grids, 7, 2 * BATCH))
    own = np.zeros((size + 1, 2 * BATCH))
    row = np.zeros((2, size + 1))
    for start in range(first, stop, BATCH):
        rays = min(BATCH, stop - start)
        of_grid[:] = 0.0
        own[:] = 0.0
        for at in range(rays):
            i = start + at
            number = 0
            for j in range(grids):
                number += whitening[j, i, 0] > 0.0
            u = directions[i]
            if number == 0:
                u[:] = np.nan
                continue
            a, b = _axes(u)
            for _ in range(settle):
                _settle(points, whitening, u, a, b, R, c, kind, bend, i)
            if number == 1:  # the ray passes through its point for any grid pose
                continue
            row[:] = 0.0
            aa = ab = bb = 0.0
            for j in range(grids):
                if whitening[j, i, 0] > 0.0:
                    rest = of_grid[j, :, 2 * at : 2 * at + 2]
                    cost, depth = _whitened_rows(
                        points[j, i], whitening[j, i], u, R[j], c[j], kind, bend, rest
                    )
                    total[size, size] += cost
                    found = _add_own(rest, depth, R[j], a, b, 6 * j - 3, row)
                    aa, ab, bb = aa + found[0], ab + found[1], bb + found[2]
            root = 1.0 / np.sqrt(aa)
            slope = ab * root
            other = 1.0 / np.sqrt(bb - slope**2)
            for k in range(size + 1):
                p = row[0, k] * root
                own[k, 2 * at] = p
                own[k, 2 * at + 1] = (row[1, k] - slope * p) * other
        _add_products(of_grid, own, total)


@compiled
def _axes(u):
    """The two axes on which u is not largest."""
    x, y, z = abs(u[0]), abs(u[1]), abs(u[2])
    if z >= x and z >= y:
        return 0, 1
    if y >= x:
        return 0, 2
    return 1, 2


@compiled
def _settle(points, whitening, u, a, b, R, c, kind, bend, i):
    """One Gauss-Newton step of a ray's direction, with fixed centre and poses."""
    aa = ab = bb = g_a = g_b = 0.0
    for j in range(len(points)):
        w = whitening[j, i]
        if not w[0] > 0.0:
            continue
        m_x, m_y, depth = meet(R[j], c[j], u)
        e, f = residual(points[j, i], w, c[j], m_x, m_y)
        share = depth * _losing(e**2 + f**2, kind, bend)[1]
        a_y, b_y = R[j, a, 1] - m_y * R[j, a, 2], R[j, b, 1] - m_y * R[j, b, 2]
        a_x = w[0] * (R[j, a, 0] - m_x * R[j, a, 2]) + w[1] * a_y
        b_x = w[0] * (R[j, b, 0] - m_x * R[j, b, 2]) + w[1] * b_y
        a_y, b_y = w[2] * a_y, w[2] * b_y
        g_a += share * (a_x * e + a_y * f)
        g_b += share * (b_x * e + b_y * f)
        share *= depth
        aa += share * (a_x**2 + a_y**2)
        ab += share * (a_x * b_x + a_y * b_y)
        bb += share * (b_x**2 + b_y**2)
    inverse = 1.0 / (aa * bb - ab**2)
    u[a] -= (bb * g_a - ab * g_b) * inverse
    u[b] -= (aa * g_b - ab * g_a) * inverse
    to_unit_length(u)


@compiled
def _whitened_rows(q, w, u, R, c, kind, bend, rest):
    """Fill rest (7, 2): W A [(q_x, q_y, 0)]x, W A, W residual. Returns cost, depth."""
    m_x, m_y, depth = meet(R, c, u)
    e, f = residual(q, w, c, m_x, m_y)
    cost, share = _losing(e**2 + f**2, kind, bend)
    if not 0.0 < depth < MAX_DEPTH:
        cost = np.inf
    share = np.sqrt(share)
    x, y = c[0] - c[2] * m_x, c[1] - c[2] * m_y
    s_x, s_y = share * w[0], share * w[1]
    s_z = -(m_x * s_x + m_y * s_y)
    rest[0, 0], rest[1, 0], rest[2, 0] = -y * s_z, x * s_z, y * s_x - x * s_y
    rest[3, 0], rest[4, 0], rest[5, 0] = s_x, s_y, s_z
    rest[6, 0] = share * e
    s_y = share * w[2]
    s_z = -m_y * s_y
    rest[0, 1], rest[1, 1], rest[2, 1] = -y * s_z, x * s_z, -x * s_y
    rest[3, 1], rest[4, 1], rest[5, 1] = 0.0, s_y, s_z
    rest[6, 1] = share * f
    return cost, depth


@compiled
def _add_own(rest, depth, R, a, b, at, row):
    """Add a point's part to its ray's row (2, p + 1); return that of the 2 x 2 block.

    at: index of the grid's unknowns; the base has no w.
    """
    a_0 = depth * (rest[3, 0] * R[a, 0] + rest[4, 0] * R[a, 1] + rest[5, 0] * R[a, 2])
    a_1 = depth * (rest[4, 1] * R[a, 1] + rest[5, 1] * R[a, 2])
    b_0 = depth * (rest[3, 0] * R[b, 0] + rest[4, 0] * R[b, 1] + rest[5, 0] * R[b, 2])
    b_1 = depth * (rest[4, 1] * R[b, 1] + rest[5, 1] * R[b, 2])
    for k in range(0 if at >= 0 else 3, 6):
        row[0, at + k] += a_0 * rest[k, 0] + a_1 * rest[k, 1]
        row[1, at + k] += b_0 * rest[k, 0] + b_1 * rest[k, 1]
    size = row.shape[1] - 1
    row[0, size] += a_0 * rest[6, 0] + a_1 * rest[6, 1]
    row[1, size] += b_0 * rest[6, 0] + b_1 * rest[6, 1]
    return a_0**2 + a_1**2, a_0 * b_0 + a_1 * b_1, b_0**2 + b_1**2


@compiled
def _add_products(of_grid, own, total):
    """Add the products of a batch's rows: of each grid, minus those of the rays."""
    size = len(own) - 1
    for j in range(len(of_grid)):
        at = 6 * j - 3
        for k in range(0 if j else 3, 6):
            for n in range(k, 6):
                total[at + k, at + n] += _product(of_grid[j, k], of_grid[j, n])
            total[at + k, size] += _product(of_grid[j, k], of_grid[j, 6])
    for k in range(size):
        for n in range(k, size + 1):
            total[k, n] -= _product(own[k], own[n])


@summing
def _product(a, b):
    total = 0.0
    for k in range(len(a)):
        total += a[k] * b[k]
    return total
