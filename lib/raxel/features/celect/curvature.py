"""The window radius of a column from squares and curvature of the last one (6.3.1)."""

import numpy as np

from raxel.features.celect.radius import mean_side

BIN_PX = 1.0
"""Width of a Hough bin: how far an arc may leave its line before its peak smears."""

LEAST_SHARE = 0.5
"""Share of the published radius below which too few edge pixels are left."""


def curved_side(previous, settings):
    """s in px of a column from the corners (n, 2) of the previous one.

    Takes the place of `radius.mean_side`, and is never more. An arc of curvature k in a
    window of radius r leaves the best line by r^2 k / 4: r is so small that this is one
    Hough bin at the most bent place, but no less than half of the published radius.
    """
    published = mean_side(previous, settings)
    bend = curvatures(previous).max(initial=0.0)
    if bend * published**2 <= 4 * BIN_PX:
        return published
    return max(np.sqrt(4 * BIN_PX / bend), LEAST_SHARE * published)


def curvatures(corners):
    """Curvature (n - 2,) in 1/px at the inner points of a chain of points (n, 2).

    Of the circle through a point and its two neighbours (Menger): twice the sine of the
    turn over the distance between the neighbours.
    """
    a, b, c = corners[:-2], corners[1:-1], corners[2:]
    before, after, across = b - a, c - b, c - a
    turn = before[:, 0] * after[:, 1] - before[:, 1] * after[:, 0]
    lengths = (np.linalg.norm(v, axis=1) for v in (before, after, across))
    product = np.prod(list(lengths), axis=0)
    return 2 * np.abs(turn) / np.maximum(product, np.finfo(float).tiny)
