"""Corners of one board against its true corners: each in its place, and in order?"""

import numpy as np

from raxel.features.lattice import symmetries


def in_place(corners, truth, reach_px):
    """Whether every corner (N, 2) is at its own true one, of `truth` (N, 2).

    It is where it is nearer than `reach_px` to it, and nearer to it than to any other
    true corner: on a fine lattice a neighbour may be within reach, too. False for
    another number of corners, and where one is not finite.
    """
    corners, truth = np.asarray(corners, float), np.asarray(truth, float)
    if corners.shape != truth.shape or not np.isfinite(corners).all():
        return False
    apart = distances(corners, truth)
    own = np.arange(len(truth))
    return bool(
        (apart[own, own] < reach_px).all() and (apart.argmin(axis=1) == own).all()
    )


def in_order_of(truth, corners, columns, rows):
    """Corners (rows * columns, 2), row by row, begun where they fit `truth` best.

    A detector without clicks may begin at any outer corner and go along the columns
    either way. Rows stay rows, also on a square board. `truth` (rows * columns, 2).
    """
    upright = list(symmetries(corners, columns, rows))[:4]
    return min(
        (order for order, _ in upright),
        key=lambda order: np.linalg.norm(order - truth, axis=1).sum(),
    )


def distances(points, others):
    """Distances (N, M) px between points (N, 2) and others (M, 2).

    Without others everything is infinitely far: (N, 1).
    """
    if not len(others):
        return np.full((len(points), 1), np.inf)
    return np.linalg.norm(points[:, None] - others[None], axis=2)
