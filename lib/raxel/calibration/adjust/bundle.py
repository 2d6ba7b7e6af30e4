"""Bundle adjustment with a fixed camera centre (step 4 of the thesis's Algorithm 1).

The grid poses and one direction per ray are adjusted so that the rays, all through the
centre C, pass as close as possible to their points: the ray-point distance (4.18) of
section 4.1.4. The centre and the base grid keep the result of the linear stage. The
thesis adjusts the poses only and then joins C to the centroid of the points of a ray;
here the direction that minimises (4.18) replaces the centroid.

For given poses the best direction u of a ray has a closed form, the dominant
eigenvector of the second moments of its points p_j = R_j (x, y, 0) + t_j - C. So only
the poses are iterated: Levenberg-Marquardt on normal equations from which the
directions are eliminated (Schur complement; a ray's own block is a scalar times I_2).

Pose steps are R exp([w]x), t + R s. A grid point then moves by R G (w, s) with
G = [-[q]x | I], linear in q = (x, y, 1), and its residual by (I - u u^T) R G (w, s).
Hence, with depths d_j = u . p_j, shares c_j = d_j / |d| and g_j = G^T R^T u, the
reduced normal matrix has the blocks

    delta_jk sum (G^T G - g_j g_j^T) - sum c_j c_k (G_j^T R_j^T R_k G_k - g_j g_k^T)

(sums over rays), whose G parts need no more than the 3 x 3 moments of the points.
"""

from __future__ import annotations

from functools import partial
from typing import NamedTuple

import numba
import numpy as np
from numpy.typing import ArrayLike

from raxel.calibration.adjust.ray_elimination import (
    MAX_DEPTH,
    compiled,
    frames,
    meet,
    over_blocks,
    residual,
    to_unit_length,
)
from raxel.errors import CalibrationError, InputError
from raxel.geometry.least_squares import descend
from raxel.geometry.poses import pose, rotation_from_vector

# Weights of the points of rays, frozen before an adjustment. A point's residual e is in
# the plane of its grid and is multiplied by a whitening matrix W = [[a, b], [0, c]],
# W^T W the inverse of the point's covariance. W is computed from the initial rays and
# poses and then kept: with weights that follow the parameters, the cost could fall by
# increasing the assumed noise.


def start_directions(points, seen, centre, T_base_grid):
    """Unit directions (N, 3): mean of those to the points of each ray.

    NaN for a ray without points. points: (n, N, 2); seen: (n, N) bool.
    """
    directions = np.empty((points.shape[1], 3))
    seen_from = frames(centre, T_base_grid)
    over_blocks(
        partial(_mean_directions, points, seen, directions, *seen_from), points.shape[1]
    )
    return directions


def image_whitening(seen, directions, centre, T_base_grid):
    """Whitening (n, N, 3) float32 of points with equal noise of their directions.

    Noise of one radian about each axis gives a grid's points the covariance
    l^2 (I + m m^T). Zero where not seen, or not in front of the centre.
    """
    whitening = np.zeros((*seen.shape, 3), np.float32)
    seen_from = frames(centre, T_base_grid)
    over_blocks(
        partial(_image_whitening, seen, directions, whitening, *seen_from),
        seen.shape[1],
    )
    return whitening


def squared_residuals(rays, centre, T_base_grid):
    """Whitened squared residuals (n, N) float32 of the points; NaN where not seen."""
    squares = np.full(rays[0].shape[:2], np.nan, np.float32)
    seen_from = frames(centre, T_base_grid)
    over_blocks(
        partial(_squared_residuals, *rays, squares, *seen_from), rays[0].shape[1]
    )
    return squares


def frozen_whitening(seen, directions, centre, T_base_grid, sigma=None):
    """Whitening (n, N, 3) float32: a, b, c of [[a, b], [0, c]]; 0 where not used.

    seen: (n, N) bool; directions: (N, 3), of the rays from the centre; sigma: as
    `adjust_consistent`. Points behind the centre are not used.
    """
    whitening = image_whitening(seen, directions, centre, T_base_grid)
    if sigma is None:
        return whitening
    sigma = np.asarray(sigma)
    if sigma.shape not in ((), seen.shape, (*seen.shape, 2)):
        raise InputError(
            f"adjustment: field 'sigma': found shape {sigma.shape}; give a number, "
            f"{seen.shape} or {(*seen.shape, 2)}"
        )
    sigma = sigma if sigma.ndim == 3 else sigma[..., None]
    sigma = np.broadcast_to(sigma, (*seen.shape, 2))
    ahead = whitening[..., 0] > 0
    if not np.all(sigma > 0, where=ahead[..., None]):
        raise InputError(
            "adjustment: field 'sigma': not above 0 at a seen point; give positive ones"
        )
    for place, axis in ((0, 0), (2, 1)):
        np.divide(1.0, sigma[..., axis], out=whitening[..., place], where=ahead)
    whitening[..., 1] = 0
    return whitening


@compiled
def _mean_directions(points, seen, directions, R, c, first, stop, sums):
    for i in range(first, stop):
        u = directions[i]
        u[:] = 0.0
        for j in range(len(points)):
            if not seen[j, i]:
                continue
            x, y, z = points[j, i, 0] - c[j, 0], points[j, i, 1] - c[j, 1], -c[j, 2]
            share = 1.0 / np.sqrt(x**2 + y**2 + z**2)
            for k in range(3):
                u[k] += share * (R[j, k, 0] * x + R[j, k, 1] * y + R[j, k, 2] * z)
        to_unit_length(u)


@compiled
def _image_whitening(seen, directions, whitening, R, c, first, stop, sums):
    for i in range(first, stop):
        for j in range(len(seen)):
            if not seen[j, i]:
                continue
            m_x, m_y, depth = meet(R[j], c[j], directions[i])
            if not 0.0 < depth < MAX_DEPTH:
                continue
            share = 1.0 / (1.0 + m_x**2 + m_y**2)
            left = np.sqrt(1.0 - share * m_x**2)
            whitening[j, i, 0] = left / depth
            whitening[j, i, 1] = -share * m_x * m_y / (left * depth)
            whitening[j, i, 2] = np.sqrt(share) / (left * depth)


@compiled
def _squared_residuals(points, whitening, directions, squares, R, c, first, stop, sums):
    for i in range(first, stop):
        for j in range(len(points)):
            w = whitening[j, i]
            if w[0] > 0.0:
                m_x, m_y, _ = meet(R[j], c[j], directions[i])
                e, f = residual(points[j, i], w, c[j], m_x, m_y)
                squares[j, i] = e**2 + f**2


BLOCK = 8192  # rays handled at once, which bounds the temporaries

# G = x MOTION[0] + y MOTION[1] + MOTION[2]; columns: rotation w, shift s.
MOTION = np.zeros((3, 3, 6))
MOTION[0, 1, 2], MOTION[0, 2, 1] = 1.0, -1.0
MOTION[1, 0, 2], MOTION[1, 2, 0] = -1.0, 1.0
MOTION[2, :, 3:] = np.eye(3)


class BundleResult(NamedTuple):
    """Poses and ray directions of an adjustment with a fixed centre.

    Attributes
    ----------
    T_base_grid
        (n, 4, 4), poses of the grids.
    directions
        (N, 3), unit, from the centre towards the points. NaN where a ray sees no grid.
    costs
        Sum of squared distances, start first.
    converged
        Whether the adjustment converged within the iterations allowed.
    """

    T_base_grid: np.ndarray
    directions: np.ndarray
    costs: np.ndarray
    converged: bool


def bundle_adjust_fixed_centre(
    points: np.ndarray,
    seen: np.ndarray,
    centre: np.ndarray,
    T_base_grid: ArrayLike,
    *,
    iterations: int = 50,
    tolerance: float = 1e-9,
) -> BundleResult:
    """Return poses and ray directions that minimise the ray-point distances.

    Parameters
    ----------
    points
        (n, N, 2), points of N rays on n grids. Entries not seen are ignored.
    seen
        (n, N) bool.
    centre
        (3,), camera centre in the base frame, kept.
    T_base_grid
        (n, 4, 4), start. The pose of grid 0, the base, is kept.
    iterations
        Largest number of steps.
    tolerance
        The adjustment stops when the cost falls by less than this share.

    Returns
    -------
    BundleResult
        Poses, directions and costs.

    Raises
    ------
    CalibrationError
        A grid shares fewer than three rays with the others ("too-few-rays"), or values
        are not finite.

    References
    ----------
    Thesis (4.18) and Algorithm 1, step 4.
    """
    q = homogeneous(points, seen)
    check_shared(np.asarray(seen, bool))
    poses = np.array(T_base_grid, float)

    def evaluate(poses):
        cost, *equations = reduced_normal_equations(q, centre, poses)
        return cost, lambda: equations

    poses, costs, converged = descend(
        evaluate,
        moved_poses,
        poses,
        iterations=iterations,
        tolerance=tolerance,
        rounding=1e-26 * np.sum(q**2),
    )
    directions = ray_directions(points, seen, centre, poses)
    return BundleResult(poses, directions, costs, converged)


def ray_directions(points, seen, centre, T_base_grid):
    """Best unit direction from the centre for every ray: (N, 3), NaN without points.

    Minimises the sum of squared ray-point distances (4.18). Arguments as above.
    """
    q = homogeneous(points, seen)
    directions = np.empty((3, q.shape[2]))
    for block in _blocks(q.shape[2]):
        p = _from_centre(q[:, :, block], centre, T_base_grid)
        directions[:, block] = _best_directions(p)
    directions[:, ~np.any(seen, axis=0)] = np.nan
    return directions.T


def ray_point_residuals(
    points: np.ndarray,
    seen: np.ndarray,
    centre: np.ndarray,
    T_base_grid: np.ndarray,
    directions: np.ndarray,
) -> np.ndarray:
    """Return vectors from the nearest point of each ray to the grid points.

    Their norms are the distances of (4.18).

    Parameters
    ----------
    points
        (n, N, 2), points of N rays on n grids.
    seen
        (n, N) bool.
    centre
        (3,), camera centre in the base frame.
    T_base_grid
        (n, 4, 4), poses of the grids.
    directions
        (N, 3), unit vectors of the rays.

    Returns
    -------
    ndarray
        (n, N, 3), in the base frame, zero where not seen.

    References
    ----------
    Thesis (4.18).
    """
    return residuals_of(homogeneous(points, seen), centre, T_base_grid, directions)


def residuals_of(q, centre, T_base_grid, directions):
    """`ray_point_residuals` of `homogeneous` points q (n, 3, N)."""
    p = _from_centre(q, centre, T_base_grid)
    u = np.ascontiguousarray(np.nan_to_num(directions).T)
    return np.swapaxes(_off_rays(p, u)[0], 1, 2)


def ray_point_distances(
    points: np.ndarray, origins: np.ndarray, directions: np.ndarray
) -> np.ndarray:
    """Return the distances of points from the lines of their rays.

    Parameters
    ----------
    points
        (..., N, 3), points.
    origins
        (3,), the centre, or (N, 3).
    directions
        (N, 3), unit vectors of the rays.

    Returns
    -------
    ndarray
        (..., N), in the unit of the points.

    References
    ----------
    Thesis (4.18).

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.calibration import ray_point_distances
    >>> points = np.array([[3.0, 4.0, 10.0], [0.0, 0.0, 7.0]])
    >>> ray_point_distances(points, np.zeros(3), np.array([[0, 0, 1.0]])).tolist()
    [5.0, 0.0]
    """
    reach = points - origins
    along = np.sum(reach * directions, axis=-1, keepdims=True)
    return np.linalg.norm(reach - along * directions, axis=-1)


def moved_poses(T_base_grid, step):
    """Poses after a step ((n - 1) * 6,), rotation first; the base stays."""
    vectors, shifts = np.moveaxis(step.reshape(-1, 2, 3), 1, 0)
    rotations, places = T_base_grid[1:, :3, :3], T_base_grid[1:, :3, 3]
    moved = T_base_grid.copy()
    moved[1:] = pose(
        rotations @ rotation_from_vector(vectors),
        places + (rotations @ shifts[..., None])[..., 0],
    )
    return moved


def reduced_normal_equations(q, centre, T_base_grid, first=1):
    """Cost, normal matrix (6p, 6p) and gradient (6p,) of p = n - first moving poses.

    q: (n, 3, N) homogeneous points, all zero where not seen; first: the first grid that
    moves. The gradient is half that of the cost; the matrix is the Gauss-Newton one.
    """
    moving = len(q) - first
    rotations = T_base_grid[first:, :3, :3]
    of_points = np.zeros((3 * moving, 3 * moving))
    of_g = np.zeros((6 * moving, 6 * moving))
    pull = np.zeros((moving, 3, 3))
    cost = 0.0
    for block in _blocks(q.shape[2]):
        part = q[:, :, block]
        p = _from_centre(part, centre, T_base_grid)
        u = _best_directions(p)
        residual, share = _off_rays(p, u)
        cost += np.vdot(residual, residual)
        grids, share = part[first:], share[first:, None]
        g = _along_ray(grids, np.swapaxes(rotations, 1, 2) @ u)
        _add_reduced(of_points, grids, share)
        _add_reduced(of_g, g, share)
        pull += grids @ np.swapaxes(residual[first:], 1, 2)
    motion = rotations[:, None] @ MOTION
    gradient = np.einsum("kmi,kmia->ka", pull, motion).ravel()
    normal = -of_g
    for axis in range(3):
        spread = _block_diagonal(motion[:, :, axis])
        normal += spread.T @ of_points @ spread
    return cost, normal, gradient


def _add_reduced(total, rows, share):
    """Add sum r_j r_j^T on the diagonal less sum c_j c_k r_j r_k^T. rows: (p, m, N)."""
    size = rows.shape[1]
    for k, own in enumerate(rows @ np.swapaxes(rows, 1, 2)):
        part = slice(size * k, size * (k + 1))
        total[part, part] += own
    flat = (share * rows).reshape(len(total), -1)
    total -= flat @ flat.T


def _along_ray(q, w):
    """g = G^T w. q, w: (p, 3, N), points and ray directions in the grids' frames."""
    x, y, one = q[:, 0], q[:, 1], q[:, 2]
    g = np.empty((len(q), 6, q.shape[2]))
    g[:, 0] = y * w[:, 2]
    g[:, 1] = -x * w[:, 2]
    g[:, 2] = x * w[:, 1] - y * w[:, 0]
    g[:, 3:] = one[:, None] * w
    return g


def _block_diagonal(blocks):
    """(p, m, k) -> (p m, p k)."""
    p, m, k = blocks.shape
    matrix = np.zeros((p, m, p, k))
    matrix[np.arange(p), :, np.arange(p)] = blocks
    return matrix.reshape(p * m, p * k)


def homogeneous(points, seen):
    """(n, N, 2) and (n, N) -> (n, 3, N) with columns (x, y, 1), or zero if not seen."""
    seen = np.asarray(seen, bool)
    q = np.empty((seen.shape[0], 3, seen.shape[1]))
    q[:, :2] = np.swapaxes(np.where(seen[..., None], points, 0.0), 1, 2)
    q[:, 2] = seen
    return q


def check_shared(seen):
    """Raise CalibrationError for a grid that shares too few rays; seen: (n, N) bool."""
    shared = seen & (np.sum(seen, axis=0) >= 2)
    for k in np.flatnonzero(np.sum(shared, axis=1) < 3):
        raise CalibrationError(
            f"bundle adjustment: grid {k} shares fewer than three rays with the "
            "others; let the grids overlap in the image",
            code="too-few-rays",
        )


def _blocks(count):
    return [slice(i, min(i + BLOCK, count)) for i in range(0, count, BLOCK)]


def _from_centre(q, centre, T_base_grid):
    """p = P - C in the base frame: (n, 3, N), zero where not seen."""
    columns = T_base_grid[:, :3][:, :, [0, 1, 3]]
    columns[:, :, 2] -= centre
    return columns @ q


@numba.njit(cache=True)
def _best_directions(p):
    """Dominant eigenvectors of sum_j p_j p_j^T. p: (n, 3, N), zero where not seen.

    Power iteration from the farthest point: the points of a ray are nearly on one line
    through C, so every round gains several digits.
    """
    n, _, count = p.shape
    u, farthest = np.zeros((3, count)), np.full(count, -1.0)
    for j in range(n):
        for i in range(count):
            x, y, z = p[j, 0, i], p[j, 1, i], p[j, 2, i]
            square = x * x + y * y + z * z
            if square > farthest[i]:
                farthest[i] = square
                u[0, i], u[1, i], u[2, i] = x, y, z
    for i in range(count):
        length = np.sqrt(max(farthest[i], 1e-300))
        for k in range(3):
            u[k, i] /= length
    for _ in range(3):
        pulled = np.zeros((3, count))
        for j in range(n):
            for i in range(count):
                x, y, z = p[j, 0, i], p[j, 1, i], p[j, 2, i]
                depth = x * u[0, i] + y * u[1, i] + z * u[2, i]
                pulled[0, i] += depth * x
                pulled[1, i] += depth * y
                pulled[2, i] += depth * z
        for i in range(count):
            x, y, z = pulled[0, i], pulled[1, i], pulled[2, i]
            length = np.sqrt(max(x * x + y * y + z * z, 1e-300))
            u[0, i], u[1, i], u[2, i] = x / length, y / length, z / length
    return u


@numba.njit(cache=True)
def _off_rays(p, u):
    """Vectors (n, 3, N) from rays u (3, N) to points p (n, 3, N), and the share (n, N)
    of each point in a ray's depths."""
    n, _, count = p.shape
    residual, share, squares = np.empty(p.shape), np.empty((n, count)), np.zeros(count)
    for j in range(n):
        for i in range(count):
            depth = p[j, 0, i] * u[0, i] + p[j, 1, i] * u[1, i] + p[j, 2, i] * u[2, i]
            for k in range(3):
                residual[j, k, i] = p[j, k, i] - depth * u[k, i]
            share[j, i] = depth
            squares[i] += depth * depth
    for j in range(n):
        for i in range(count):
            share[j, i] /= np.sqrt(max(squares[i], 1e-300))
    return residual, share
