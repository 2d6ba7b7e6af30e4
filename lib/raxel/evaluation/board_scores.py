"""Corners of one board against its true corners: each in its place, and in order?"""

import numpy as np

from raxel.features.lattice import symmetries

RIM_PX = 4.0  # a corner this near to the image's end need not be found


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


def share_in_order(partial, truth, columns, shape, reach_px):
    """Share (0 to 1) of the true corners in the image that a `Partial` has in order.

    `partial` (or None: nothing is in order) is what a refused `Detection` holds;
    `truth` (rows * columns, 2) the true corners in pixels, row by row; `shape` that of
    the image, (height, width). A corner is in order if it is nearer than `reach_px` to
    the true corner to which one of the eight symmetries of a lattice, and one shift,
    take its row and column; of these the one counts that fits most corners.
    """
    size = np.array(shape[1::-1])
    inside = np.all((truth > RIM_PX) & (truth < size - 1 - RIM_PX), axis=1)
    if partial is None or not inside.any():
        return 0.0
    apart = distances(partial.corners, truth)
    nearest = apart.argmin(axis=1)
    good = (apart.min(axis=1) < reach_px) & inside[nearest]
    place = np.column_stack(np.divmod(nearest[good], columns))
    best = 0
    for turned in (partial.indices[good], partial.indices[good][:, ::-1]):
        for sign in ((1, 1), (1, -1), (-1, 1), (-1, -1)):
            shifts = place - turned * sign
            _, counts = np.unique(shifts, axis=0, return_counts=True)
            best = max(best, counts.max(initial=0))
    return float(best / inside.sum())


def distances(points, others):
    """Distances (N, M) px between points (N, 2) and others (M, 2).

    Without others everything is infinitely far: (N, 1).
    """
    if not len(others):
        return np.full((len(points), 1), np.inf)
    return np.linalg.norm(points[:, None] - others[None], axis=2)
