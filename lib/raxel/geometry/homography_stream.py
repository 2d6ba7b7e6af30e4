"""Homography and its covariance from millions of pairs, in one pass.

The normal equations of the direct linear transform need only 24 different sums over the
pairs. Their solution would square the condition number. The same pass therefore sums
the gradient about an approximate homography, from residuals as small as the noise: the
step from there loses no digits. Sums are taken in blocks and in a fixed order.

Source: Hartley and Zisserman 2004, doi:10.1017/CBO9780511811685, chapter 4.
"""

from typing import NamedTuple

import numba
import numpy as np

from raxel.errors import InputError
from raxel.geometry.homography import normalising_of

BLOCK = 4096
# Sums in the order of `_sum_pairs`.
_SYMMETRIC = np.array([[0, 1, 2], [1, 3, 4], [2, 4, 5]])


class HomographyFit(NamedTuple):
    """target ~ H (source, 1): H (3, 3) of norm 1, third coordinate positive at the
    source's centroid; covariance (9, 9) of its entries row by row, perpendicular to
    them; inliers (N,) bool; count of them.
    """

    H: np.ndarray
    covariance: np.ndarray
    inliers: np.ndarray
    count: int  # type: ignore[assignment]


def fit_homography(source, target, start, *, use=None, limit=np.inf, weights=None):
    """Normalised DLT of all pairs within a limit of an approximate homography.

    source, target: (N, 2), pairs that are not finite are excluded; start: (3, 3) near
    the solution; use: (N,) bool, pairs to consider; limit: largest distance in the
    target frame from the source point mapped by ``start``; weights: (N,), each
    multiplies the two algebraic equations of its pair.
    The result is that of `homography_dlt` on the same pairs. Returns HomographyFit.
    Memory is one byte a pair. Raises InputError for arrays that do not fit together,
    and for fewer than four pairs or pairs that do not determine H.
    """
    source, target = floating(source), floating(target)
    if source.ndim != 2 or source.shape[1] != 2 or source.shape != target.shape:
        raise InputError(
            f"homography: found points {source.shape} and {target.shape}; give two "
            "equal arrays (N, 2)"
        )
    # The compiled loop does not check these lengths.
    for name, given in (("use", use), ("weights", weights)):
        if given is not None and np.shape(given) != (len(source),):
            raise InputError(
                f"homography: field '{name}': found shape {np.shape(given)}; give one "
                f"for each of the {len(source)} pairs"
            )
    inliers = np.ones(len(source), bool) if use is None else np.array(use, bool)
    factors = np.empty(0)
    if weights is not None:
        factors = np.ascontiguousarray(weights, float)
        inliers &= factors > 0
    frames = [_frame(points, inliers) for points in (source, target)]
    near = frames[1] @ start @ np.linalg.inv(frames[0])
    near /= np.linalg.norm(near)
    sums = _sum_pairs(
        source, target, factors, near, limit * frames[1][0, 0], *frames, inliers
    )
    count = int(np.count_nonzero(inliers))
    if count < 4:
        raise InputError(
            f"homography: found {count} usable pairs of points; give at least four"
        )
    return _solved(sums, near, *frames, inliers, count)


def _frame(points, use):
    """Similarity (3, 3) that maps points to about zero mean and unit size."""
    picked = points[np.flatnonzero(use)[:: max(1, np.count_nonzero(use) // BLOCK)]]
    picked = picked[np.isfinite(picked).all(axis=1)]
    middle = np.median(picked, axis=0) if len(picked) else np.zeros(2)
    size = np.sqrt(np.median((picked - middle) ** 2)) if len(picked) else 1.0
    T = np.diag([1.0, 1.0, 1.0])
    T[:2] /= size if size > 0 else 1.0
    T[:2, 2] = -T[0, 0] * middle
    return T


@numba.njit(cache=True)
def _sum_pairs(source, target, weights, H, limit, T_s, T_t, inliers):
    """Sums (34,): 24 moments, 9 of the gradient at H, the sum of squared residuals.

    Moments: s s^T (xx, xy, x, yy, y, 1) times 1, X, Y and X^2 + Y^2, in the frames T_s
    and T_t, in which H is, too. Clears inliers (N,) where a pair misses the limit.
    """
    total = np.zeros(34)
    part = np.empty(34)
    for start in range(0, len(source), BLOCK):
        part[:] = 0.0
        for i in range(start, min(start + BLOCK, len(source))):
            if not inliers[i]:
                continue
            x = T_s[0, 0] * source[i, 0] + T_s[0, 2]
            y = T_s[0, 0] * source[i, 1] + T_s[1, 2]
            X = T_t[0, 0] * target[i, 0] + T_t[0, 2]
            Y = T_t[0, 0] * target[i, 1] + T_t[1, 2]
            w = H[2, 0] * x + H[2, 1] * y + H[2, 2]
            r = H[0, 0] * x + H[0, 1] * y + H[0, 2] - X * w
            q = H[1, 0] * x + H[1, 1] * y + H[1, 2] - Y * w
            if not r * r + q * q < limit * limit * w * w:
                inliers[i] = False
                continue
            f = 1.0
            if len(weights) > 0:
                f = weights[i] * weights[i]
            square = X * X + Y * Y
            k = 0
            for m in (f, f * X, f * Y, f * square):
                mx, my = m * x, m * y
                part[k] += mx * x
                part[k + 1] += mx * y
                part[k + 2] += mx
                part[k + 3] += my * y
                part[k + 4] += my
                part[k + 5] += m
                k += 6
            for m in (f * r, f * q, -f * (X * r + Y * q)):
                part[k] += m * x
                part[k + 1] += m * y
                part[k + 2] += m
                k += 3
            part[33] += f * (r * r + q * q)
        total += part
    return total


def _solved(sums, near, T_s, T_t, inliers, count):
    one, x, y, square = (sums[6 * k : 6 * k + 6][_SYMMETRIC] for k in range(4))
    normal = np.zeros((9, 9))
    normal[:3, :3] = normal[3:6, 3:6] = one
    normal[:3, 6:] = normal[6:, :3] = -x
    normal[3:6, 6:] = normal[6:, 3:6] = -y
    normal[6:, 6:] = square
    # To zero mean and root mean square distance sqrt(2), as in the DLT: there the
    # entries are h' = L^-1 h, and residuals only change by one factor.
    weight = one[2, 2]
    N_s = normalising_of(one[2, :2] / weight, (one[0, 0] + one[1, 1]) / weight)
    N_t = normalising_of(np.array([x[2, 2], y[2, 2]]) / weight, square[2, 2] / weight)
    L = kronecker(np.linalg.inv(N_t), N_s.T)
    h = np.linalg.solve(L, near.ravel())
    size = np.linalg.norm(h)
    h, a = h / size, N_t[0, 0] ** 2 / weight
    normal = a * L.T @ normal @ L
    gradient = a / size * L.T @ sums[24:33]
    left_over = a / size**2 * sums[33]
    values, vectors = np.linalg.eigh(normal)
    tangent = np.linalg.svd(h[None])[2][1:].T
    if not values[1] > 1e-14 * values[8]:
        _open()
    inner = tangent.T @ normal @ tangent - max(values[0], 0.0) * np.eye(8)
    step = tangent @ np.linalg.solve(inner, -tangent.T @ gradient)
    left_over = max(left_over + gradient @ step, 0.0) / (1 + step @ step)
    h = (h + step) / np.linalg.norm(h + step)
    if np.linalg.svd(h.reshape(3, 3), compute_uv=False)[2] < 1e-12:
        _open()
    h = h if h[8] > 0 else -h
    variance = left_over / max(2 * count - 8, 1)
    inverse = (vectors[:, 1:] / values[1:]) @ vectors[:, 1:].T
    back = kronecker(np.linalg.inv(N_t @ T_t), (N_s @ T_s).T)
    h = back @ h
    back = across(h) @ back / np.linalg.norm(h)
    H = (h / np.linalg.norm(h)).reshape(3, 3)
    return HomographyFit(H, variance * back @ inverse @ back.T, inliers, count)


def floating(values):
    """Values as a contiguous array of floats; single precision is not copied."""
    values = np.asarray(values)
    dtype = values.dtype if values.dtype == np.float32 else float
    return np.ascontiguousarray(values, dtype)


def kronecker(a, b):
    """np.kron (9, 9) of two (3, 3) matrices, without its overhead."""
    return (a[:, None, :, None] * b[None, :, None]).reshape(9, 9)


def across(h):
    """Projection (m, m) perpendicular to h (m,): the scale has no uncertainty."""
    return np.eye(len(h)) - np.outer(h, h) / (h @ h)


def _open():
    raise InputError(
        "homography: the points do not determine it (collinear or repeated); give at "
        "least four in general position"
    )
