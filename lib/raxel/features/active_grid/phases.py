"""The phase of every pixel of rows, averaged over 7 x 7 pixels where these allow it.

Written as `reading`.
"""

import numpy as np
from numba import njit

from raxel.features.active_grid.layout import DECODED, REACH

# A window whose sum is shorter (its square) holds more than one slope.
COHERENT = np.float32(0.49 * 49**2)
_ZERO, _QUARTER, _HALF = np.float32(0), np.float32(0.25), np.float32(0.5)
_ONE, _TINY = np.float32(1), np.float32(1e-20)
_SHARE, _OF_CELL = np.float32(1 / 49), np.float32(1 / 12)
# arctan(q) / (2 pi q) as a polynomial in q^2 on [0, 1], right to 3e-8 turns.
_TERMS = (0.159154837, -0.0530461211, 0.0317459458, -0.0221362732)
_TERMS += (0.015346036, -0.00889872415, 0.00347959743, -0.000645304089)
_ARCTAN = tuple(map(np.float32, _TERMS))


@njit(cache=True, nogil=True, error_model="numpy")
def turns(sine, cosine):
    """The angle of (cosine, sine) float32 in turns, from 0 to below 1, to 1e-7."""
    across, up = abs(cosine), abs(sine)
    large, small = (up, across) if up > across else (across, up)
    q = small / (large + _TINY)
    s = q * q
    turn = _ARCTAN[7]
    turn = turn * s + _ARCTAN[6]
    turn = turn * s + _ARCTAN[5]
    turn = turn * s + _ARCTAN[4]
    turn = turn * s + _ARCTAN[3]
    turn = turn * s + _ARCTAN[2]
    turn = turn * s + _ARCTAN[1]
    turn = turn * s + _ARCTAN[0]
    turn = turn * q
    turn = _QUARTER - turn if up > across else turn
    turn = _HALF - turn if cosine < _ZERO else turn
    turn = _ONE - turn if sine < _ZERO else turn
    return turn - _ONE if turn >= _ONE else turn


@njit(cache=True, nogil=True, error_model="numpy")
def _turn_row(sine, cosine, turn, k):
    for x in range(len(sine)):
        turn[k, x] = turns(sine[x], cosine[x])


@njit(cache=True, nogil=True, error_model="numpy")
def _add_rows(ring, y, column):
    """column (W,): the sum of the seven rows kept around y."""
    n = len(ring)
    a, b, c, d = (y - 3) % n, (y - 2) % n, (y - 1) % n, y % n
    e, f, g = (y + 1) % n, (y + 2) % n, (y + 3) % n
    for x in range(len(column)):
        left = (ring[a, x] + ring[b, x]) + ring[c, x]
        right = (ring[e, x] + ring[f, x]) + ring[g, x]
        column[x] = (left + ring[d, x]) + right


@njit(cache=True, nogil=True, error_model="numpy")
def _move_rows(ring, y, column):
    """From the sum of seven rows around y - 1 to that around y."""
    n = len(ring)
    new, old = (y + 3) % n, (y - 4) % n
    for x in range(len(column)):
        column[x] += ring[new, x] - ring[old, x]


@njit(cache=True, nogil=True, error_model="numpy")
def _add_columns(column, out):
    """out[x] for REACH <= x < W - REACH: the sum of seven columns around x."""
    # Indices that are seen to be no less than 0 run on many pixels at once.
    for x in range(len(out) - 2 * REACH):
        left = (column[x] + column[x + 1]) + column[x + 2]
        right = (column[x + 4] + column[x + 5]) + column[x + 6]
        out[x + 3] = (left + column[x + 3]) + right


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_crossed(sine, cosine, mixed, k, crossed):
    """Set where a window holds a break (mixed), or its sum of unit vectors is short."""
    for x in range(len(mixed)):
        length = sine[x] * sine[x] + cosine[x] * cosine[x]
        crossed[k, x] = (mixed[x] != 0) | (length < COHERENT)


@njit(cache=True, nogil=True, error_model="numpy")
def _spread_less(variance, crossed, k):
    """Variance of a phase that is the mean of a window."""
    for x in range(crossed.shape[1]):
        own = variance[k, x]
        variance[k, x] = own if crossed[k, x] else _SHARE * own


@njit(cache=True, nogil=True, error_model="numpy")
def which(marked, out):
    """How many pixels are marked; out: which, eight bytes looked at together."""
    count, eight = 0, marked.view(np.uint64)
    for k in range(len(eight)):
        if eight[k]:
            for x in range(8 * k, 8 * k + 8):
                if marked[x]:
                    out[count] = x
                    count += 1
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_good(bad, alone, k, marked):
    for x in range(alone.shape[1]):
        marked[x] = (alone[k, x] != 0) & (bad[k, x] == DECODED)


@njit(cache=True, nogil=True, error_model="numpy")
def _turn_alone(sine, cosine, k, asked, turn):
    """The own phase of pixels."""
    for x in asked:
        turn[k, x] = turns(sine[k, x], cosine[k, x])


@njit(cache=True, nogil=True, error_model="numpy")
def _average(rows, axis, y, is_first, sums, mixed, marked, out):
    """The phases of a row from the sums of unit vectors over 7 x 7 pixels.

    sums: (2, 2, W) of sine and cosine: of seven rows, those around row y - 1 unless
    y is the first; of windows. mixed: how many breaks are in a window; marked, out: as
    in `which`. A pixel whose window is crossed keeps its own phase.
    """
    k, crossed = y % len(rows.bad), rows.alone[axis]
    sine, cosine, turn = rows.sine[axis], rows.cosine[axis], rows.turn[axis]
    of_sine, of_cosine = sums[0, 0], sums[0, 1]
    if is_first:
        _add_rows(sine, y, of_sine)
        _add_rows(cosine, y, of_cosine)
    else:
        _move_rows(sine, y, of_sine)
        _move_rows(cosine, y, of_cosine)
    _add_columns(of_sine, sums[1, 0])
    _add_columns(of_cosine, sums[1, 1])
    _mark_crossed(sums[1, 0], sums[1, 1], mixed, k, crossed)
    _turn_row(sums[1, 0], sums[1, 1], turn, k)
    _mark_good(rows.bad, crossed, k, marked)
    _turn_alone(sine, cosine, k, out[: which(marked, out)], turn)
    _spread_less(rows.variance[axis], crossed, k)


@njit(cache=True, nogil=True, error_model="numpy")
def turn_rows(first, stop, height, plan, smooth, rows):
    """Find turn and alone of rows kept, and the variance that goes with them.

    first, stop: rows that were read (`reading.read_rows`), with REACH before and AHEAD
    behind; height: of the pictures; plan: CodePlan; smooth: average over windows. A
    pixel keeps its own phase where its window is crossed. Where there are no phases,
    the places in a cell are as likely, and its middle stands for them.
    """
    count, width = rows.turn.shape[0], rows.turn.shape[2]
    breaks, mixed = np.empty(width, np.uint8), np.ones(width, np.uint8)
    sums = np.zeros((count, 2, 2, width), np.float32)
    marked, out = np.zeros(-(-width // 8) * 8, np.uint8), np.empty(width, np.int64)
    for y in range(first, stop):
        k = y % len(rows.bad)
        windows = smooth and y >= REACH and y + REACH < height and width > 2 * REACH
        if windows:
            _add_rows(rows.crossed, y, breaks)
            _add_columns(breaks, mixed)
        for axis in range(count):
            if not plan.used[axis]:
                rows.turn[axis, k], rows.variance[axis, k] = _HALF, _OF_CELL
            elif windows:
                is_first = y == max(first, REACH)
                _average(rows, axis, y, is_first, sums[axis], mixed, marked, out)
            else:
                rows.alone[axis, k] = 1
                sine, cosine = rows.sine[axis, k], rows.cosine[axis, k]
                _turn_row(sine, cosine, rows.turn[axis], k)
