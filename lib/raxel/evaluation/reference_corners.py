"""Detected boards against reference corners of a set: is the board right?"""

import numpy as np

from raxel.features.lattice import symmetries


def distance_to_reference(detection, reference):
    """The largest distance in px from the certain reference corners.

    `detection` is a Detection, `reference` a ReferenceCorners of the same image; the
    symmetry of the lattice that fits best counts, since the reference leaves open
    which corner is first. Infinity for a board not found or of another size. The
    board is right when the distance is within `reference.tolerance_px`.
    """
    if not detection.found:
        return np.inf
    orders = symmetries(detection.corners, detection.columns, detection.rows)
    size = reference.columns, reference.rows
    distances = [
        _largest(order - reference.corners, reference.certain)
        for order, order_size in orders
        if order_size == size
    ]
    return min(distances, default=np.inf)


def _largest(difference, certain):
    return float(np.linalg.norm(difference[certain], axis=1).max(initial=0.0))
