"""Detectors side by side on an image set: Tables 3.4 to 3.7 for photographs.

Right is, as in 3.3.2, a board with every corner within 8 px of its place and nearer to
it than to any other. The places are the set's reference corners, of which the uncertain
ones do not count; a set without them has only boards that are returned or not.
"""

import numpy as np

from chapters.shared.grid_detectors import CLICK_SD_PX, is_right, localised
from chapters.shared.lattices import clockwise, outer
from raxel.errors import InputError
from raxel.features import symmetries
from raxel.features.celect import celect
from raxel.sets import Charuco, Chessboard

QUICK_VIEWS = 3
UNSUITED = "the set has no plain chessboard of known size"


def detector_conditions(image_set, effort):
    """One condition per image, or the first few; one alone for an unsuited set."""
    target = image_set.target
    plain = isinstance(target, Chessboard) and not isinstance(target, Charuco)
    if not plain or target.columns is None:
        return [{"view": -1, "image": UNSUITED}]
    views = image_set.views[: QUICK_VIEWS if effort == "quick" else None]
    return [{"view": index, "image": view.label} for index, view in enumerate(views)]


def clicks_of(view, size, reference, rng):
    """Outer corners (4, 2) as a user clicks them; None where nobody knows them.

    Those of set.yaml, or the reference's with the error of the thesis's author.
    """
    if view.outer_corners is not None:
        return np.array(view.outer_corners, float)
    if reference is None or (reference.columns, reference.rows) != size:
        return None
    columns, rows = size
    lattice = clockwise(reference.corners.reshape(rows, columns, 2))
    clicks = outer(lattice) + rng.normal(0, CLICK_SD_PX, (4, 2))
    return clicks if np.isfinite(clicks).all() else None


def read_by_celect(image, clicks, size):
    """Corners (N, 2) of a CELECT run; None where it fails."""
    try:
        result = celect(image, clicks, *size)
    except InputError:
        return None
    return result.corners.reshape(-1, 2) if result.found else None


def score(image, corners, size, reference):
    """Whether corners (N, 2) or None came back and are right, and errors (N,) px."""
    values = {"returned": corners is not None, "right": False}
    if corners is None or reference is None:
        return values
    certain = reference.certain
    truth = reference.corners[certain]
    for order, order_size in symmetries(corners, *size):
        if order_size != (reference.columns, reference.rows):
            continue
        if is_right(order[certain], truth):
            after = localised(image, order)[certain]
            return values | {
                "right": True,
                "before": np.linalg.norm(order[certain] - truth, axis=1),
                "after": np.linalg.norm(after - truth, axis=1),
            }
    return values
