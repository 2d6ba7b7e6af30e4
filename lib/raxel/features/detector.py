"""The interface of every chessboard detector, and what all their answers go through."""

from typing import NamedTuple

import numpy as np

from raxel.errors import InputError
from raxel.features.lattice import lattice_fault, standard_order

SPAN_FOR_8_BIT = (0.1, 99.9)


class Partial(NamedTuple):
    """The part of a refused board that is in order.

    `corners` (M, 2) pixels (u, v); `indices` (M, 2) int: row and column of each on
    their lattice, counted from 0, with the first corner and the direction left open.
    """

    corners: np.ndarray
    indices: np.ndarray


class Detection(NamedTuple):
    """What a detector says about one image.

    `corners` (rows * columns, 2) float64 pixels (u, v), row by row, x along the
    columns, in the order of `lattice.standard_order`, NaN for a corner that is missing;
    (0, 2) where not found. `reason` says why not, in a few words. `sd` (rows *
    columns,) px: standard deviation of each corner, by the rule of
    `raxel.sets.uncertainty`; None where a detector gives none. `partial`: what is in
    order of a refused board, None where there is nothing. `complete`: sizes (columns,
    rows) of the boards seen, where several are a reason to refuse.
    """

    found: bool
    corners: np.ndarray
    columns: int | None
    rows: int | None
    reason: str = ""
    sd: np.ndarray | None = None
    partial: Partial | None = None
    complete: tuple = ()

    @property
    def missing(self):
        """Number of corners that the board lacks."""
        return int(np.count_nonzero(np.isnan(self.corners[:, 0])))


def refused(columns, rows, reason):
    """The answer of a detector that has no board to show."""
    return Detection(False, np.empty((0, 2)), columns, rows, reason)


def verified(corners, columns, rows, image):
    """A Detection of these corners, refused where they are no chessboard lattice.

    `corners` (rows * columns, 2) in any order that is row by row.
    """
    corners = np.asarray(corners, dtype=float).reshape(-1, 2)
    fault = lattice_fault(corners, columns, rows, image)
    if fault:
        return refused(columns, rows, f"what was found is no lattice: {fault}")
    order = standard_order(corners, columns, rows, image)
    return Detection(True, corners[order], columns, rows)


def as_8_bit(image):
    """Grey (height, width) as uint8; deeper images are stretched over their range.

    Raises InputError for an array of another shape, as that of a colour picture.
    """
    if image.ndim != 2:
        raise InputError(
            f"image: found an array of shape {image.shape}; give grey, (height, width)"
        )
    if image.dtype == np.uint8:
        return image
    low, high = np.percentile(image, SPAN_FOR_8_BIT)
    stretched = (image - low) * (255 / max(high - low, 1))
    return np.clip(np.rint(stretched), 0, 255).astype(np.uint8)
