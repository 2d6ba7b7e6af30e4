"""Wrong matches between a flat grid and a picture of it in a smooth mirror.

Over the grid the picture is a smooth function: a cubic in the grid's coordinates leaves
some pixels where features belong to their points, and many where they do not.
"""

import numpy as np

# Powers of a cubic in two coordinates.
CUBIC = [(i, j) for i in range(4) for j in range(4 - i)]
ROUNDS, SETTLED = 30, 1e-2
# Beyond this many medians of the right ones, and px, a feature is wrong.
FAR, LEAST_PX = 6.0, 8.0


def wrong_matches(points, pixels):
    """Which rows (N,) bool lie off a smooth picture; False where pixels are NaN.

    points: (N, 2) on the grid; pixels: (N, 2). The sum of distances, not of squares,
    is made small, so that up to a third may be wrong. Too few to tell: none is.
    """
    shown = np.isfinite(pixels).all(axis=1)
    wrong = np.zeros(len(points), bool)
    if np.count_nonzero(shown) < 2 * len(CUBIC):
        return wrong
    x, y = _centred(points[shown]).T
    A = np.stack([x**i * y**j for i, j in CUBIC], axis=1)
    off = _least_distances(A, pixels[shown])
    wrong[shown] = off > max(FAR * np.median(off), LEAST_PX)
    return wrong


def _least_distances(A, pixels):
    """Distances (N,) px from the polynomial whose sum of distances is least, by
    reweighted squares."""
    weights, median = np.ones(len(A)), np.inf
    for _ in range(ROUNDS):
        normal = A.T * weights
        coefficients = np.linalg.solve(normal @ A, normal @ pixels)
        off = np.linalg.norm(pixels - A @ coefficients, axis=1)
        weights = 1 / np.maximum(off, 0.1)
        last, median = median, np.median(off)
        if abs(last - median) <= SETTLED * median:
            break
    return off


def _centred(points):
    low, high = points.min(axis=0), points.max(axis=0)
    return (2 * points - low - high) / np.maximum(high - low, 1e-12)
