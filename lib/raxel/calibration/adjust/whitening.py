"""Weights of the points that rays see, frozen before an adjustment.

A point's residual e lies in the plane of its grid and is multiplied by a whitening
matrix W = [[a, b], [0, c]], W^T W the inverse of the point's covariance. It is computed
from rays and poses as they are at some moment, and then kept: weights that follow what
is adjusted would let a cost fall by growing the noise that it is measured against.
"""

from functools import partial

import numpy as np

from raxel.calibration.adjust.ray_elimination import (
    FAR,
    compiled,
    frames,
    meet,
    over_blocks,
    residual,
    to_unit_length,
)
from raxel.errors import InputError


def start_directions(points, seen, centre, T_base_grid):
    """Unit directions (N, 3): the mean of those to the points that each ray sees.

    NaN for a ray that sees none. points: (n, N, 2); seen: (n, N) bool.
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
    l^2 (I + m m^T). Zero where not seen, or not ahead of the centre.
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
            f"adjustment: field 'sigma': shape {sigma.shape} found; give a number,"
            f" {seen.shape} or {(*seen.shape, 2)}"
        )
    sigma = sigma if sigma.ndim == 3 else sigma[..., None]
    sigma = np.broadcast_to(sigma, (*seen.shape, 2))
    ahead = whitening[..., 0] > 0
    if not np.all(sigma > 0, where=ahead[..., None]):
        raise InputError("adjustment: field 'sigma': not above 0 where a point is seen")
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
            if not 0.0 < depth < FAR:
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
