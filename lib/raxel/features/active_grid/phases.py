"""The phase of every pixel of rows, averaged over 7 x 7 pixels where these allow it.

Written as `reading`; compiled into `places`.
"""

import numpy as np
from numba import njit

from raxel.features.active_grid.coding import (
    BREAKS,
    COSINE,
    COSINES,
    CROSSED,
    KEPT,
    MIXED,
    OWN,
    REACH,
    SINE,
    SINES,
    SPREAD,
    TURN,
    VARIANCE,
)

# A window whose sum is shorter (its square) holds more than one slope.
COHERENT = np.float32(0.49 * 49**2)
FAST = {"contract"}  # products added with one rounding
_ZERO, _QUARTER, _HALF = np.float32(0), np.float32(0.25), np.float32(0.5)
_ONE, _TINY = np.float32(1), np.float32(1e-20)
_SHARE, _NINTH, _OF_CELL = np.float32(1 / 49), np.float32(1 / 9), np.float32(1 / 12)
# arctan(q) / (2 pi q) as a polynomial in q^2 on [0, 1], right to 3e-8 turns.
_TERMS = (0.159154837, -0.0530461211, 0.0317459458, -0.0221362732)
_TERMS += (0.015346036, -0.00889872415, 0.00347959743, -0.000645304089)  # type: ignore[assignment]
_ARCTAN = tuple(map(np.float32, _TERMS))


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
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
def _turn_own(axis, k, n, rows):
    """Phases of pixels by themselves."""
    waves, work = rows.waves, rows.work
    for x in range(n):
        sine, cosine = waves[axis, k, SINE + x], waves[axis, k, COSINE + x]
        work[axis, TURN + x] = turns(sine, cosine)
        work[axis, SPREAD + x] = waves[axis, k, VARIANCE + x]
    rows.flags[axis, OWN : OWN + n] = 1


@njit(cache=True, nogil=True, error_model="numpy")
def _add_breaks(y, n, rows):
    """MIXED: how many pixels in a window are crossed; as good as 1 near the border."""
    marks, common = rows.marks, rows.common
    a, b, c, d = (y - 3) % KEPT, (y - 2) % KEPT, (y - 1) % KEPT, y % KEPT
    e, f, g = (y + 1) % KEPT, (y + 2) % KEPT, (y + 3) % KEPT
    for x in range(n):
        left = marks[a, CROSSED + x] + marks[b, CROSSED + x] + marks[c, CROSSED + x]
        right = marks[e, CROSSED + x] + marks[f, CROSSED + x] + marks[g, CROSSED + x]
        common[BREAKS + x] = left + marks[d, CROSSED + x] + right
    for x in range(n - 2 * REACH):
        at = BREAKS + x
        left = common[at] + common[at + 1] + common[at + 2]
        right = common[at + 4] + common[at + 5] + common[at + 6]
        common[MIXED + REACH + x] = left + common[at + 3] + right


@njit(cache=True, nogil=True, error_model="numpy")
def _add_rows(axis, y, n, rows):
    """SINES and COSINES: the sums of the seven rows kept around y."""
    waves, work = rows.waves, rows.work
    a, b, c, d = (y - 3) % KEPT, (y - 2) % KEPT, (y - 1) % KEPT, y % KEPT
    e, f, g = (y + 1) % KEPT, (y + 2) % KEPT, (y + 3) % KEPT
    for x in range(n):
        i, j = SINE + x, COSINE + x
        left = (waves[axis, a, i] + waves[axis, b, i]) + waves[axis, c, i]
        right = (waves[axis, e, i] + waves[axis, f, i]) + waves[axis, g, i]
        work[axis, SINES + x] = (left + waves[axis, d, i]) + right
        left = (waves[axis, a, j] + waves[axis, b, j]) + waves[axis, c, j]
        right = (waves[axis, e, j] + waves[axis, f, j]) + waves[axis, g, j]
        work[axis, COSINES + x] = (left + waves[axis, d, j]) + right


@njit(cache=True, nogil=True, error_model="numpy")
def _move_rows(axis, y, n, rows):
    """From the sums of seven rows around y - 1 to those around y."""
    waves, work = rows.waves, rows.work
    new, old = (y + 3) % KEPT, (y - 4) % KEPT
    for x in range(n):
        i, j = SINE + x, COSINE + x
        work[axis, SINES + x] += waves[axis, new, i] - waves[axis, old, i]
        work[axis, COSINES + x] += waves[axis, new, j] - waves[axis, old, j]


@njit(cache=True, nogil=True, error_model="numpy")
def _turn_windows(axis, k, n, rows):
    """Phases of windows; a pixel whose window is crossed keeps its own.

    It is crossed where it holds a break, or its sum of unit vectors is short.
    """
    waves, work, flags, common = rows.waves, rows.work, rows.flags, rows.common
    for x in range(n - 2 * REACH):
        at, i = SINES + x, x + REACH
        left = (work[axis, at] + work[axis, at + 1]) + work[axis, at + 2]
        right = (work[axis, at + 4] + work[axis, at + 5]) + work[axis, at + 6]
        sine = (left + work[axis, at + 3]) + right
        at = COSINES + x
        left = (work[axis, at] + work[axis, at + 1]) + work[axis, at + 2]
        right = (work[axis, at + 4] + work[axis, at + 5]) + work[axis, at + 6]
        cosine = (left + work[axis, at + 3]) + right
        short = sine * sine + cosine * cosine < COHERENT
        own = (common[MIXED + i] != 0) | short
        sine = waves[axis, k, SINE + i] if own else sine
        cosine = waves[axis, k, COSINE + i] if own else cosine
        variance = waves[axis, k, VARIANCE + i]
        work[axis, TURN + i] = turns(sine, cosine)
        work[axis, SPREAD + i] = variance if own else _SHARE * variance
        flags[axis, OWN + i] = own


@njit(cache=True, nogil=True, error_model="numpy")
def _even_out(axis, y, n, rows):
    """Variances of windows from nine of their pixels, not from the middle one alone."""
    waves, work, flags = rows.waves[axis], rows.work[axis], rows.flags[axis]
    above, here, under = waves[(y - 2) % KEPT], waves[y % KEPT], waves[(y + 2) % KEPT]
    for x in range(n - 2 * REACH):
        at = VARIANCE + x + REACH
        total = (above[at - 2] + above[at]) + above[at + 2]
        total += (here[at - 2] + here[at]) + here[at + 2]
        total += (under[at - 2] + under[at]) + under[at + 2]
        own = work[SPREAD + x + REACH]
        window = flags[OWN + x + REACH] == 0
        work[SPREAD + x + REACH] = _NINTH * _SHARE * total if window else own


@njit(cache=True, nogil=True, error_model="numpy")
def _turn_ends(axis, k, n, rows):
    """As `_turn_own`, where windows go beyond the strip."""
    waves, work = rows.waves, rows.work
    for end in range(2 * REACH):
        x = end if end < REACH else n - 1 - (end - REACH)
        sine, cosine = waves[axis, k, SINE + x], waves[axis, k, COSINE + x]
        work[axis, TURN + x] = turns(sine, cosine)
        work[axis, SPREAD + x] = waves[axis, k, VARIANCE + x]
        rows.flags[axis, OWN + x] = 1


@njit(cache=True, nogil=True, error_model="numpy")
def turn_row(y, is_first, height, smooth, strip, plan, rows):
    """Find the phase of a row with REACH rows around it that were read.

    TURN, SPREAD and OWN of Rows. height: of the images; smooth: average over windows.
    A pixel keeps its own phase where its window is crossed. Where there are no phases,
    the places in a cell are as likely, and its middle stands for them. is_first: the
    row before was not of the same call.
    """
    n, k = strip.width, y % KEPT
    windows = smooth and REACH <= y < height - REACH and n > 2 * REACH
    if windows:
        _add_breaks(y, n, rows)
    for axis in range(len(plan.bits)):
        if not plan.used[axis]:
            rows.work[axis, TURN : TURN + n] = _HALF
            rows.work[axis, SPREAD : SPREAD + n] = _OF_CELL
        elif windows:
            if is_first or y == REACH:
                _add_rows(axis, y, n, rows)
            else:
                _move_rows(axis, y, n, rows)
            _turn_ends(axis, k, n, rows)
            _turn_windows(axis, k, n, rows)
            if plan.uneven[axis]:
                _even_out(axis, y, n, rows)
        else:
            _turn_own(axis, k, n, rows)
