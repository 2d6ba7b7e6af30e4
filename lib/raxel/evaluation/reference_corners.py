"""Detected boards against reference corners of a set: how far off, and is it right?"""

import numpy as np

from raxel.features.lattice import symmetries


def corner_errors(detection, reference):
    """Distances (N,) in px of a detection from the N certain reference corners.

    `detection` is a Detection, `reference` a ReferenceCorners of the same image. The
    symmetry of the lattice with the smallest largest distance counts, since the
    reference leaves open which corner is first; mirrored ones are allowed. A corner
    that the board lacks has no distance, so that fewer than N are given. None for a
    board that was not found, or of another size.
    """
    if not detection.found:
        return None
    orders = symmetries(detection.corners, detection.columns, detection.rows)
    size = reference.columns, reference.rows
    errors = [
        _known(np.linalg.norm(order - reference.corners, axis=1)[reference.certain])
        for order, order_size in orders
        if order_size == size
    ]
    return min(errors, key=_largest, default=None)


def is_right(errors, reference):
    """Whether a board with these `corner_errors` is right: each within the tolerance.

    False for None, the errors of a board that is not there or of another size.
    """
    return errors is not None and bool(_largest(errors) <= reference.tolerance_px)


def _known(errors):
    return errors[np.isfinite(errors)]


def _largest(errors):
    return errors.max(initial=0.0)
