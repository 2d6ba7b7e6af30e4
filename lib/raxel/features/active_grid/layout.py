"""What the decoder's compiled loops share: kinds of pixels, a plan, rows kept.

The loops keep what they found in a few rows of the picture, in rings: row y lies at y
modulo their length.
"""

from typing import NamedTuple

import numpy as np

DECODED, FILLED, DARK, SATURATED, UNREADABLE, ALONE, BESIDE, RIM, BREAK = range(9)

REACH = 3  # of the smoothing window, 7 x 7, to each side
AHEAD = REACH + 1  # rows read before one is decoded: breaks need one more
SQUARE = 32  # px; in each such square of the picture a bias is taken as the same
ROWS_A_CALL = 16
ROWS_A_PIECE = 8  # worked through as one, where no pixel looks at another row
KEPT = 24  # rows in a ring: those of a call, as many as AHEAD before and behind


class CodePlan(NamedTuple):
    """What the pictures of a stack encode along A axes (`coding.plan_arrays`).

    pairs: (A, bits, 2), picture and inverse of each bit; steps, weights: (A, 3, K), of
    the phase steps for sine, cosine and level, weights float32. int64 (A,): bits; used
    steps, rounded up to an even number; edges, the first edge behind the last cell that
    is shown; jump, cells between neighbours above which they see different surfaces.
    float32 (A,): ratio of cell to period; length of a period and extent of the monitor
    in the unit of locations; spread 2 / N of N steps.
    """

    pairs: np.ndarray
    steps: np.ndarray
    weights: np.ndarray
    bits: np.ndarray
    used: np.ndarray
    edges: np.ndarray
    jump: np.ndarray
    ratio: np.ndarray
    length: np.ndarray
    extent: np.ndarray
    spread: np.ndarray

    @property
    def reach(self):
        """(A,) float32: how far apart neighbours may lie that see one surface."""
        return self.length * self.ratio * self.jump.astype(np.float32) / 2


class Rows(NamedTuple):
    """Rings of rows. (A, KEPT, W): sine and cosine of unit length; turn, the phase that
    is taken, and its variance in squared turns; code, the cell; alone, set where the
    phase is that of one pixel; least distance of a picture from its inverse. (KEPT, W):
    most distance; bad, why a pixel is not decoded; beside and below, whether it breaks
    with the next pixel; crossed, either or bad.

    Rows to work in, of ROWS_A_PIECE times W: level, the mean grey value, and second
    least distance, of each axis; apart, the distance of one picture.
    """

    sine: np.ndarray
    cosine: np.ndarray
    turn: np.ndarray
    variance: np.ndarray
    code: np.ndarray
    alone: np.ndarray
    least: np.ndarray
    most: np.ndarray
    bad: np.ndarray
    beside: np.ndarray
    below: np.ndarray
    crossed: np.ndarray
    level: np.ndarray
    second: np.ndarray
    apart: np.ndarray


def empty_rows(axes, width, dtype):
    """Rows for pictures of this width and type."""
    ring, three = (KEPT, width), (axes, KEPT, width)
    piece = ROWS_A_PIECE * width
    return Rows(
        *(np.zeros(three, np.float32) for _ in range(4)),
        np.zeros(three, np.uint16),
        np.zeros(three, np.uint8),
        np.zeros(three, dtype),
        np.zeros(ring, dtype),
        *(np.zeros(ring, np.uint8) for _ in range(4)),
        np.zeros((axes, piece), np.float32),
        np.zeros((axes, piece), dtype),
        np.zeros(piece, dtype),
    )
