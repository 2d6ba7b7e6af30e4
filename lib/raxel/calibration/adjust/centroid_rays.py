"""Rays through the centre and the centroid of their points (4.1.3), and its weights.

A point P_j on grid j, l_j away from the centre, has an error e_j across its ray. The
centroid with weights w_j turns the ray by sum(w_j e_j) / sum(w_j l_j). Errors that are
independent with variances v_j do least harm with w_j = l_j / v_j. Noise of the image
has v_j proportional to l_j^2, and then near points count more; noise in mm has one v,
and then far points do; a grid whose pose is itself an estimate adds what the pose's
covariance does to its points, and counts less. That is the reason for the thesis's
rule, which gives the grids of the linear stage more weight.
"""

import numpy as np

from raxel.errors import InputError
from raxel.geometry.planes import on_plane
from raxel.geometry.poses import transform


def centroid_directions(points, seen, centre, T_base_grid, weights=None):
    """Unit directions (N, 3) from the centre to the weighted centroids of the points.

    points: (n, N, 2) mm; seen: (n, N) bool; centre: (3,); T_base_grid: (n, 4, 4);
    weights: (n,) of the grids or (n, N), above zero; default: all equal. NaN for a ray
    that sees no grid. Raises InputError for weights that are not above zero.
    """
    return joined_rays(points, seen, centre, weights)(T_base_grid)


def joined_rays(points, seen, centre, weights=None):
    """T_base_grid -> `centroid_directions`, for points that do not change."""
    seen = np.asarray(seen, bool)
    weights = np.ones(len(seen)) if weights is None else np.asarray(weights, float)
    weights = np.broadcast_to(weights.T, seen.T.shape).T
    if not np.all(weights > 0, where=seen):
        raise InputError("rays: field 'weights': not above 0 where a point is seen")
    flat, shares = _seen_points(points, seen), np.where(seen, weights, 0.0)

    def directions(T_base_grid):
        p = _from_centre(flat, seen, centre, T_base_grid)
        middle = np.einsum("jn,jnk->nk", shares, p)
        length = np.linalg.norm(middle, axis=1, keepdims=True)
        return middle / np.where(length > 0, length, np.nan)

    return directions


def centroid_weights(points, seen, centre, T_base_grid, covariances, noise, domain):
    """Weights (n, N) of points for `centroid_directions`: length over variance.

    covariances: (n, 6, 6) of the poses, rotation vector in the grid's frame and
    translation in the base frame, zero for those taken as exact; noise: of the image in
    rad (domain "image") or of the points in mm (domain "plane").

    Errors of neighbouring points on one grid are not independent: its pose moves them
    together. The weights are the best for each ray, seen alone.
    """
    if domain not in ("image", "plane"):
        raise InputError(f"rays: domain {domain!r}; expected 'image' or 'plane'")
    seen = np.asarray(seen, bool)
    p = _from_centre(_seen_points(points, seen), seen, centre, T_base_grid)
    length = np.linalg.norm(p, axis=2)
    u = p / np.where(length > 0, length, 1.0)[..., None]
    variance = (noise * length) ** 2
    if domain == "plane":
        # Of the noise in the plane, what is across the ray, per axis.
        normal = np.einsum("jnk,jk->jn", u, T_base_grid[:, :3, 2])
        variance = noise**2 * (1.0 + normal**2) / 2
    for j, covariance in enumerate(covariances):
        variance[j] += _moved_across(points[j], T_base_grid[j], covariance, u[j])
    return np.where(seen, length / np.where(variance > 0, variance, 1.0), 0.0)


def _moved_across(points, T, covariance, u):
    """Mean variance (N,) per axis across rays u of points of a grid, by its pose."""
    x, y = np.nan_to_num(points).T
    motion = np.zeros((len(points), 3, 6))
    motion[:, :, 0] = y[:, None] * T[:3, 2]
    motion[:, :, 1] = -x[:, None] * T[:3, 2]
    motion[:, :, 2] = x[:, None] * T[:3, 1] - y[:, None] * T[:3, 0]
    motion[:, :, 3:] = np.eye(3)
    spread = motion @ covariance @ np.swapaxes(motion, 1, 2)
    along = np.einsum("ni,nik,nk->n", u, spread, u)
    return (np.trace(spread, axis1=1, axis2=2) - along) / 2


def _seen_points(points, seen):
    """Points (n, N, 3) of the grids in their own frames, zero where not seen."""
    return on_plane(np.where(seen[..., None], points, 0.0))


def _from_centre(flat, seen, centre, T_base_grid):
    """P - C (n, N, 3) in the base frame, zero where not seen."""
    return np.where(seen[..., None], transform(T_base_grid, flat) - centre, 0.0)
