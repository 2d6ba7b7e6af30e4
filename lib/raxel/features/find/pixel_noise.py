"""What the noise of single pixels does to a corner's fit, carried through it exactly.

The fit of `corners` takes slopes g_k at places x_k of a window, in half windows from
its middle, and solves A q = sum w_k g_k (g_k . x_k), A = sum w_k g_k g_k^T. Slopes that
are wrong by n_k move the corner, which is at q = 0, by

    A^-1 sum w_k (g_k (n_k . x_k) + n_k (g_k . x_k)),

and n_k are differences of smoothed noise, which is alike at places close by: of white
noise of variance 1, smoothed by a Gaussian of variance s^2, two values d apart have the
covariance exp(-d^2 / 4 s^2) / (4 pi s^2).
"""

import numpy as np

# Variance, px^2, that the interpolation adds to the smoothing: of a cubic B-spline.
BETWEEN_PIXELS = 1 / 3


def influences(g, x, weight, part=1.0):
    """(q, how slopes move it): of the fit to a part of the window's slopes.

    g: (N, K, 2) slopes, K = (2 n + 1)^2 row by row, from which their weighted mean was
    taken off; x: (K, 2); weight, part: (K,). Returned are q (N, 2), in half windows,
    and (N, 2, K, 2): by how much it moves with each slope.
    """
    of = weight * part
    toward = (g * x).sum(axis=2)
    A = np.swapaxes(g * of[:, None], 1, 2) @ g
    A += (1e-9 * np.trace(A, axis1=1, axis2=2)[:, None, None] + 1e-12) * np.eye(2)
    inverse = np.linalg.inv(A)
    right = (of[:, None] * g * toward[..., None]).sum(axis=1)
    moved = of[:, None, None] * (
        g[..., None] * x[:, None, :] + toward[..., None, None] * np.eye(2)
    )
    moved -= (weight / weight.sum())[:, None, None] * moved.sum(axis=1, keepdims=True)
    q = np.einsum("nab,nb->na", inverse, right)
    return q, np.einsum("nab,nkbc->nakc", inverse, moved)


def variances(moved, window, level):
    """Variance (N, M) that pixel noise gives to sums over slopes of a Level.

    moved: (N, M, K, 2) weights of the slopes; window: (N, 2, 2) px, its columns half a
    window in s and t.
    """
    weights = _of_samples(moved)
    size = 2 * weights.shape[-1]
    power = np.abs(np.fft.rfft2(weights, (size, size))) ** 2
    alike = np.fft.irfft2(power, (size, size))
    steps = np.fft.fftfreq(size, 1 / size) * 2 / (weights.shape[-1] - 3)
    apart = np.stack(np.meshgrid(steps, steps), axis=-1).reshape(-1, 2)
    px = apart @ np.swapaxes(window / level.scale, 1, 2)
    smooth = level.sigma**2 + BETWEEN_PIXELS
    shared = np.exp(-(px**2).sum(axis=2) / (4 * smooth)) / (4 * np.pi * smooth)
    total = (alike.reshape(*alike.shape[:2], -1) @ shared[..., None])[..., 0]
    return level.noise**2 * np.maximum(total, 0)


def _of_samples(moved):
    """Weights (N, M, S, S) of samples, S = 2 n + 3, from those (N, M, K, 2) of slopes.

    A slope is the difference of the samples on its two sides, times n / 2.
    """
    side = round(np.sqrt(moved.shape[2]))
    s, t = np.moveaxis(moved.reshape(*moved.shape[:2], side, side, 2), -1, 0)
    per_half = (side - 1) / 4
    weights = np.zeros((*moved.shape[:2], side + 2, side + 2))
    weights[..., 1:-1, 2:] += per_half * s
    weights[..., 1:-1, :-2] -= per_half * s
    weights[..., 2:, 1:-1] += per_half * t
    weights[..., :-2, 1:-1] -= per_half * t
    return weights
