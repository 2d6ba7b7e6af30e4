"""The part of a board that a refusal hands over, against the board's true corners."""

import numpy as np

RIM_PX = 4.0  # a corner this near to the image's end need not be found


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
    apart = np.linalg.norm(partial.corners[:, None] - truth[None], axis=2)
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
