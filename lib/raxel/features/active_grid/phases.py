"""Phases of rows of pixels, averaged over windows of 7 x 7 pixels.

Compiled loops, written as `reading` and compiled into `places`.
"""

import numpy as np
from numba import njit

from raxel.features.active_grid.coding import (
    BREAKS,
    COSINE,
    COSINES,
    CROSSED,
    MIXED,
    OWN,
    RING_ROWS,
    SINE,
    SINES,
    SPREAD,
    TURN,
    VARIANCE,
    WINDOW_RADIUS,
)

# Minimal squared sum of unit vectors: windows with a smaller sum have several slopes.
MIN_SQUARED_SUM = np.float32(0.49 * 49**2)
FAST = {"contract"}  # fused multiply-add
_ZERO, _QUARTER, _HALF = np.float32(0), np.float32(0.25), np.float32(0.5)
_ONE, _TINY = np.float32(1), np.float32(1e-20)
_SHARE, _NINTH, _OF_CELL = np.float32(1 / 49), np.float32(1 / 9), np.float32(1 / 12)
# arctan(q) / (2 pi q) as a polynomial in q^2 on [0, 1], accurate to 3e-8 turns.
_TERMS = (0.159154837, -0.0530461211, 0.0317459458, -0.0221362732)
_TERMS += (0.015346036, -0.00889872415, 0.00347959743, -0.000645304089)  # type: ignore[assignment]
_ARCTAN = tuple(map(np.float32, _TERMS))


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def turns(sine, cosine):
    """Return the angle of (cosine, sine) float32 in turns, in [0, 1), to 1e-7."""
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
    """Use the phase of each single pixel."""
    waves, work = rows.waves, rows.work
    for x in range(n):
        sine, cosine = waves[axis, k, SINE + x], waves[axis, k, COSINE + x]
        work[axis, TURN + x] = turns(sine, cosine)
        work[axis, SPREAD + x] = waves[axis, k, VARIANCE + x]
    rows.flags[axis, OWN : OWN + n] = 1


@njit(cache=True, nogil=True, error_model="numpy")
def _add_breaks(y, n, rows):
    """Set MIXED: number of pixels in a window with a break; at least 1 at borders."""
    marks, common = rows.marks, rows.common
    a, b, c, d = (
        (y - 3) % RING_ROWS,
        (y - 2) % RING_ROWS,
        (y - 1) % RING_ROWS,
        y % RING_ROWS,
    )
    e, f, g = (y + 1) % RING_ROWS, (y + 2) % RING_ROWS, (y + 3) % RING_ROWS
    for x in range(n):
        left = marks[a, CROSSED + x] + marks[b, CROSSED + x] + marks[c, CROSSED + x]
        right = marks[e, CROSSED + x] + marks[f, CROSSED + x] + marks[g, CROSSED + x]
        common[BREAKS + x] = left + marks[d, CROSSED + x] + right
    for x in range(n - 2 * WINDOW_RADIUS):
        at = BREAKS + x
        left = common[at] + common[at + 1] + common[at + 2]
        right = common[at + 4] + common[at + 5] + common[at + 6]
        common[MIXED + WINDOW_RADIUS + x] = left + common[at + 3] + right


@njit(cache=True, nogil=True, error_model="numpy")
def _add_rows(axis, y, n, rows):
    """Set SINES and COSINES: sums over the seven rows around y."""
    waves, work = rows.waves, rows.work
    a, b, c, d = (
        (y - 3) % RING_ROWS,
        (y - 2) % RING_ROWS,
        (y - 1) % RING_ROWS,
        y % RING_ROWS,
    )
    e, f, g = (y + 1) % RING_ROWS, (y + 2) % RING_ROWS, (y + 3) % RING_ROWS
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
    """Move the sums of seven rows from y - 1 to y."""
    waves, work = rows.waves, rows.work
    new, old = (y + 3) % RING_ROWS, (y - 4) % RING_ROWS
    for x in range(n):
        i, j = SINE + x, COSINE + x
        work[axis, SINES + x] += waves[axis, new, i] - waves[axis, old, i]
        work[axis, COSINES + x] += waves[axis, new, j] - waves[axis, old, j]


@njit(cache=True, nogil=True, error_model="numpy")
def _turn_windows(axis, k, n, rows):
    """Set the phases of windows; a pixel whose window is crossed keeps its own.

    A window is crossed by a break, or if its sum of unit vectors is short.
    """
    waves, work, flags, common = rows.waves, rows.work, rows.flags, rows.common
    for x in range(n - 2 * WINDOW_RADIUS):
        at, i = SINES + x, x + WINDOW_RADIUS
        left = (work[axis, at] + work[axis, at + 1]) + work[axis, at + 2]
        right = (work[axis, at + 4] + work[axis, at + 5]) + work[axis, at + 6]
        sine = (left + work[axis, at + 3]) + right
        at = COSINES + x
        left = (work[axis, at] + work[axis, at + 1]) + work[axis, at + 2]
        right = (work[axis, at + 4] + work[axis, at + 5]) + work[axis, at + 6]
        cosine = (left + work[axis, at + 3]) + right
        short = sine * sine + cosine * cosine < MIN_SQUARED_SUM
        own = (common[MIXED + i] != 0) | short
        sine = waves[axis, k, SINE + i] if own else sine
        cosine = waves[axis, k, COSINE + i] if own else cosine
        variance = waves[axis, k, VARIANCE + i]
        work[axis, TURN + i] = turns(sine, cosine)
        work[axis, SPREAD + i] = variance if own else _SHARE * variance
        flags[axis, OWN + i] = own


@njit(cache=True, nogil=True, error_model="numpy")
def _even_out(axis, y, n, rows):
    """Average the variance of a window over nine of its pixels."""
    waves, work, flags = rows.waves[axis], rows.work[axis], rows.flags[axis]
    above, here, under = (
        waves[(y - 2) % RING_ROWS],
        waves[y % RING_ROWS],
        waves[(y + 2) % RING_ROWS],
    )
    for x in range(n - 2 * WINDOW_RADIUS):
        at = VARIANCE + x + WINDOW_RADIUS
        total = (above[at - 2] + above[at]) + above[at + 2]
        total += (here[at - 2] + here[at]) + here[at + 2]
        total += (under[at - 2] + under[at]) + under[at + 2]
        own = work[SPREAD + x + WINDOW_RADIUS]
        window = flags[OWN + x + WINDOW_RADIUS] == 0
        work[SPREAD + x + WINDOW_RADIUS] = _NINTH * _SHARE * total if window else own


@njit(cache=True, nogil=True, error_model="numpy")
def _turn_ends(axis, k, n, rows):
    """Use the phase of each single pixel where windows exceed the strip."""
    waves, work = rows.waves, rows.work
    for end in range(2 * WINDOW_RADIUS):
        x = end if end < WINDOW_RADIUS else n - 1 - (end - WINDOW_RADIUS)
        sine, cosine = waves[axis, k, SINE + x], waves[axis, k, COSINE + x]
        work[axis, TURN + x] = turns(sine, cosine)
        work[axis, SPREAD + x] = waves[axis, k, VARIANCE + x]
        rows.flags[axis, OWN + x] = 1


@njit(cache=True, nogil=True, error_model="numpy")
def turn_row(y, is_first, height, smooth, strip, plan, rows):
    """Set the phase of a row; WINDOW_RADIUS rows around it must have been read.

    TURN, SPREAD and OWN of Rows. height: of the images; smooth: average over windows.
    A pixel keeps its own phase where its window is crossed. Without phases, the middle
    of the cell is used, with a uniform distribution over the cell. is_first: the row
    before was not of the same call.
    """
    n, k = strip.width, y % RING_ROWS
    windows = (
        smooth and WINDOW_RADIUS <= y < height - WINDOW_RADIUS and n > 2 * WINDOW_RADIUS
    )
    if windows:
        _add_breaks(y, n, rows)
    for axis in range(len(plan.bits)):
        if not plan.used[axis]:
            rows.work[axis, TURN : TURN + n] = _HALF
            rows.work[axis, SPREAD : SPREAD + n] = _OF_CELL
        elif windows:
            if is_first or y == WINDOW_RADIUS:
                _add_rows(axis, y, n, rows)
            else:
                _move_rows(axis, y, n, rows)
            _turn_ends(axis, k, n, rows)
            _turn_windows(axis, k, n, rows)
            if plan.uneven[axis]:
                _even_out(axis, y, n, rows)
        else:
            _turn_own(axis, k, n, rows)
