"""CELECT as a detector of an image set: clicks from set.yaml, corners refined."""

import numpy as np

from raxel.features.celect.algorithm import celect
from raxel.features.detector import Partial, refused, verified
from raxel.features.opencv import refine


def find_celect(image, columns, rows, outer_corners, contours=()):
    """The board between four clicks, by CELECT, then refined as OpenCV's corners are.

    `image` (height, width) uint8 or uint16; `columns` and `rows` count interior corners
    and must be known; `outer_corners` (4, 2) px clockwise, None where nobody clicked;
    `contours` (name, points) pairs of contours by hand. Returns a Detection; a refused
    one has the ordered part, and names the contour that failed. Raises InputError as
    `celect`.
    """
    if columns is None or rows is None:
        reason = "celect needs target.columns and target.rows"
        return refused(columns, rows, reason)
    if outer_corners is None:
        return refused(columns, rows, "celect needs outer_corners, the four clicks")
    given = {name: np.array(points) for name, points in contours}
    result = celect(image, outer_corners, columns, rows, given_contours=given)
    if not result.found:
        return _with_part(result)
    corners = refine(image, result.corners.reshape(-1, 2), columns, rows)
    return verified(corners, columns, rows, image)


def _with_part(result):
    first = result.failures[0]
    reason = f"{first.contour}: {first.stage}: {first.reason}"
    if first.contour == "side 1" and first.found == result.rows != first.wanted:
        reason += "; the second click is the other end of the first row"
    detection = refused(result.columns, result.rows, reason)
    seen = np.isfinite(result.corners[..., 0])
    if not seen.any():
        return detection
    part = Partial(result.corners[seen], np.argwhere(seen))
    return detection._replace(partial=part)
