"""What the decoder's compiled loops share: kinds of pixels, a plan, rows kept.

The loops keep what they found in a few rows of the picture, in rings: row y lies at y
modulo their length.
"""

from typing import NamedTuple

import numpy as np

DECODED, FILLED, DARK, SATURATED, UNREADABLE = range(5)
ALONE, BESIDE, RIM, BREAK = range(5, 9)

UNKNOWN = 65535  # in CodePlan.orders: no cell
# Of the modulation of bright pixels: less is the dark beside the monitor, where noise
# has harmonics of every kind, or light that tells little.
LIT, BRIGHT = 0.2, 99
REACH = 3  # of the smoothing window, 7 x 7, to each side
AHEAD = REACH + 1  # rows read before one is decoded: breaks need one more
SQUARE = 32  # px; in each such square of the picture a bias is taken as the same
ROWS_A_CALL = 16
KEPT = 24  # rows in a ring: those of a call, as many as AHEAD before and behind
# Pictures are decoded in strips of columns, at most so wide. Fields of one array lie at
# distances known when loops are compiled: only then many arrays can run in one loop.
STRIP = 2048
PITCH = STRIP + 80  # from field to field: multiples of 4096 bytes hinder each other
SINE, COSINE, VARIANCE = 0, PITCH, 2 * PITCH  # of Rows.waves
LOWEST, SECOND, HIGHEST, APART = 0, PITCH, 2 * PITCH, 3 * PITCH  # of Rows.greys
BAD, RIGHT, BELOW, CROSSED = 0, PITCH, 2 * PITCH, 3 * PITCH  # of Rows.marks
LEVEL, SINES, COSINES, TURN = 0, PITCH, 2 * PITCH, 3 * PITCH  # of Rows.work
SPREAD, PERIOD, OFF, PLACE = 4 * PITCH, 5 * PITCH, 6 * PITCH, 7 * PITCH
SIGMA, WORK = 8 * PITCH, 9 * PITCH
OWN, DOUBT, LOST = 0, PITCH, 2 * PITCH  # of Rows.flags
BREAKS, MIXED, STATUS = 0, PITCH, 2 * PITCH  # of Rows.common


class CodePlan(NamedTuple):
    """What the pictures of a stack encode along A axes (`coding.plan_arrays`).

    pairs: (A, bits, 2), picture and inverse of each bit; steps, weights: (A, 3, K), of
    the phase steps for sine, cosine and level, weights float32. int64 (A,): bits; used
    steps, rounded up to an even number; edges, the first edge behind the last cell that
    is shown; jump, cells between neighbours above which they see different surfaces.
    float32 (A,): ratio of cell to period; length of a period and extent of the monitor
    in the unit of locations; spread 2 / N of N steps. told: (A,) int64, whether cells
    are those of `orders`, (A, H, W) uint16, told by sines (`orders.period_cells`).
    uneven: (A,) bool, whether the variance of a phase changes within windows.
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
    told: np.ndarray
    orders: np.ndarray
    uneven: np.ndarray

    @property
    def reach(self):
        """(A,) float32: how far apart neighbours may lie that see one surface."""
        return self.length * self.ratio * self.jump.astype(np.float32) / 2


class Ripples(NamedTuple):
    """By what phases of A axes are off (`response.Ripple`, `ripple`).

    steps, times: (A,) int64, 0 where nothing is; origin: (A, 2), share: (A, 6), terms:
    (A, 3) float32; across, down: float32, from columns and rows to the shares of the
    picture, less 1.
    """

    steps: np.ndarray
    origin: np.ndarray
    times: np.ndarray
    share: np.ndarray
    terms: np.ndarray
    across: np.float32
    down: np.float32


class Rows(NamedTuple):
    """Rows of a strip, field after field of at most STRIP columns, PITCH apart.

    Rings, the row second or first. waves: (A, KEPT, 3 PITCH) float32: sine and cosine
    of unit length, and the variance of a pixel's phase in squared turns. codes:
    (A, KEPT, PITCH) uint16, the cell. greys: (A, KEPT, 4 PITCH), as the pictures:
    least, second least and most distance of a picture from its inverse, the last one of
    all axes in axis 0; that of one picture. marks: (KEPT, 4 PITCH) uint8: why a pixel
    is not decoded; whether it breaks with the next one to the right, and below; either
    or bad.

    Rows to work in. work: (A, WORK) float32: the mean grey value; sums over seven rows;
    the phase that is taken and its variance; period; by how much it is off; place and
    its standard deviation. flags: (A, 3 PITCH) uint8: set where a phase is that of one
    pixel; in doubt; lost. common: (3 PITCH,) uint8: breaks in seven rows and in a
    window; status. asked: (STRIP,) int64, pixels picked out.
    """

    waves: np.ndarray
    codes: np.ndarray
    greys: np.ndarray
    marks: np.ndarray
    work: np.ndarray
    flags: np.ndarray
    common: np.ndarray
    asked: np.ndarray


class Strip(NamedTuple):
    """Columns of the picture: those that are read, and those that are decoded."""

    start: int
    width: int
    first: int
    stop: int


def strips_of(width):
    """[Strip, ...] of equal width that cover a picture, AHEAD columns around each."""
    around = 2 * AHEAD
    count = max(1, -(-(width - around) // (STRIP - around)))
    own = -(-(width + (count - 1) * around) // count)
    own = min(-(-own // 64) * 64, STRIP, width)
    starts = [k * (width - own) // max(count - 1, 1) for k in range(count)]
    ends = [0, *(start + AHEAD for start in starts[1:]), width]
    return [Strip(starts[k], own, ends[k], ends[k + 1]) for k in range(count)]


def empty_rows(axes, dtype):
    """Rows for pictures of this type."""
    return Rows(
        np.zeros((axes, KEPT, 3 * PITCH), np.float32),
        np.zeros((axes, KEPT, PITCH), np.uint16),
        np.zeros((axes, KEPT, 4 * PITCH), dtype),
        np.zeros((KEPT, 4 * PITCH), np.uint8),
        np.zeros((axes, WORK), np.float32),
        np.zeros((axes, 3 * PITCH), np.uint8),
        np.zeros(3 * PITCH, np.uint8),
        np.zeros(STRIP, np.int64),
    )
