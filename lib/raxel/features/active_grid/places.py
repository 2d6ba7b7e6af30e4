"""From cells and phases to places, row by row, in compiled loops.

Written as `reading`; what is compiled in from `phases` is `which`.
"""

import numpy as np
from numba import njit

from raxel.features.active_grid import layout
from raxel.features.active_grid.layout import ALONE, BESIDE, DECODED, UNREADABLE
from raxel.features.active_grid.phases import which

# Near the next period by less than this share of one; what a response shifts phases
# by is less.
CLOSE = np.float32(0.02)
# The cosine of phases on one surface is above this: as for breaks, `reading.APART`.
SAME = np.float32(-1e-6)
# So far from a cell, in cells, its code may be read when an edge is blurred.
BLURRED = np.float32(0.3)
# Beyond the monitor's border by four standard deviations there is no light; this is
# squared.
FAR = np.float32(16.0)
_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)
_NOWHERE = np.float32(np.nan)


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest_period(code, turn, k, ratio, period, off):
    """The period whose place with this phase is nearest to the middle of the cell.

    off: by how much it is beyond the middle, in periods.
    """
    for x in range(len(period)):
        middle = (np.float32(code[k, x]) + _HALF) * ratio
        nearest = np.ceil(middle - turn[k, x] - _HALF)
        period[x] = np.int16(nearest)
        off[x] = nearest + turn[k, x] - middle


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_seen(code, k, above, under, least, most, seen):
    """Set beside an edge: one of four neighbours is elsewhere, or a bit is weak."""
    width = code.shape[1]
    for x in range(width):
        own = code[k, x]
        weak = 2 * np.int32(least[k, x]) < np.int32(most[k, x])
        seen[x] = weak | (own != code[above, x]) | (own != code[under, x])
    # Indices that are seen to be no less than 0 run on many pixels at once.
    for x in range(width - 1):
        seen[x] |= code[k, x] != code[k, x + 1]
    for x in range(width - 1):
        seen[x + 1] |= code[k, x] != code[k, x + 1]


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_doubt(off, ratio, variance, bad, k, doubt, lost):
    """From where an edge is seen to where it leaves the period in doubt.

    That is near the next one, and where noise could turn one into the other (even). If
    no edge is seen there, nothing says which one it is.
    """
    farthest, reach = _ONE - _HALF * ratio, BLURRED * ratio
    for x in range(len(off)):
        gap = farthest - abs(off[x])
        even = gap * abs(gap) < FAR * variance[k, x]
        seen, asked = doubt[x] != 0, bad[k, x] == DECODED
        doubt[x] = asked & seen & ((gap < reach) | even)
        lost[x] |= asked & even & (not seen)


@njit(cache=True, nogil=True, error_model="numpy")
def _bit_of_edge(edge, bits):
    """Which bit changes between cells edge - 1 and edge; bit 0 is the coarsest."""
    bit = bits - 1
    while edge % 2 == 0:
        edge //= 2
        bit -= 1
    return bit


@njit(cache=True, nogil=True, error_model="numpy")
def _is_seen(edge, contrast, most, cell, around, by_others):
    """Whether the edge between cells edge - 1 and edge is seen at a pixel.

    Its bit has lost contrast there, or (by_others) one of the four neighbours around is
    read beyond it.
    """
    above, under, left, right = around
    behind = cell >= edge
    seen = ((above >= edge) != behind) | ((under >= edge) != behind)
    seen |= ((left >= edge) != behind) | ((right >= edge) != behind)
    return (4 * contrast < 3 * most) | (seen & by_others)


@njit(cache=True, nogil=True, error_model="numpy")
def _difference(images, y, x, pairs, edge):
    """Picture less inverse of the bit that changes at an edge of cells."""
    bit = _bit_of_edge(edge, len(pairs))
    light, dark = images[pairs[bit, 0], y, x], images[pairs[bit, 1], y, x]
    return np.int64(light) - np.int64(dark)


@njit(cache=True, nogil=True, error_model="numpy")
def _sum_around(images, y, x, pairs, edge, sine, cosine, code, bad):
    """How many of 3 x 3 pixels see the same surface, and the sum of `_difference`.

    Not those that are bad, outside, or on the other side of a break. The sum is
    positive where it agrees with the pixel in the middle.
    """
    kept, k, total, count = len(bad), y % len(bad), 0, 0
    for v in range(max(y - 1, 0), min(y + 2, images.shape[1])):
        i = v % kept
        for u in range(max(x - 1, 0), min(x + 2, images.shape[2])):
            along = sine[k, x] * sine[i, u] + cosine[k, x] * cosine[i, u]
            same = abs(np.int64(code[i, u]) - np.int64(code[k, x])) <= 1
            if same and bad[i, u] == DECODED and along >= SAME:
                count += 1
                total += _difference(images, v, u, pairs, edge)
    return count, total if _difference(images, y, x, pairs, edge) > 0 else -total


@njit(cache=True, nogil=True, error_model="numpy")
def _settle(images, y, axis, plan, rows, asked, off, period, lost):
    """The wrap rule: at an edge of cells the phase says on which side a pixel is.

    A pixel whose phase is near the start or end of its period is at one edge of its
    cell, or beyond the other one, with that edge's bit misread: then the bit has lost
    contrast. Where noise could turn the phase around (even), one of the two must be
    seen. If the edge across is, the bits of both decide, each as a mean of the 3 x 3
    pixels that see the same surface.

    asked: the pixels in doubt. Their period moves by one, or lost is set. Before the
    first edge and from plan.edges on there is nothing to be seen.
    """
    pairs, edges = plan.pairs[axis, : plan.bits[axis]], plan.edges[axis]
    kept, height, last = len(rows.bad), images.shape[1], images.shape[2] - 1
    k, above, under = y % kept, max(y - 1, 0) % kept, min(y + 1, height - 1) % kept
    code, variance = rows.code[axis], rows.variance[axis]
    surface = rows.sine[axis], rows.cosine[axis], code, rows.bad
    farthest = _ONE - _HALF * plan.ratio[axis]
    for x in asked:
        gap = farthest - abs(off[x])
        even = gap * abs(gap) < FAR * variance[k, x]
        cell, most, below = np.int64(code[k, x]), np.int64(rows.most[k, x]), off[x] < 0
        near, across = (cell, cell + 1) if below else (cell + 1, cell)
        around = code[above, x], code[under, x], code[k, max(x - 1, 0)]
        seen_by = most, cell, (*around, code[k, min(x + 1, last)])
        near_is_seen = across_is_seen = False
        if 0 < near < edges:
            contrast = abs(_difference(images, y, x, pairs, near))
            near_is_seen = _is_seen(near, contrast, *seen_by, True)
        if 0 < across < edges:
            contrast = abs(_difference(images, y, x, pairs, across))
            close = even | (gap < CLOSE)
            across_is_seen = _is_seen(across, contrast, *seen_by, close)
        if not across_is_seen:
            lost[x] |= even & (not near_is_seen)
            continue
        count, at_across = _sum_around(images, y, x, pairs, across, *surface)
        half = at_near = count * most
        if 0 < near < edges:
            at_near = 2 * abs(_sum_around(images, y, x, pairs, near, *surface)[1])
        if 2 * at_across < min(half, at_near):
            period[x] += 1 if below else -1
        else:
            lost[x] |= even & (at_near >= half)


@njit(cache=True, nogil=True, error_model="numpy")
def _find_period(images, y, axis, plan, rows, work, period, lost):
    """The period of each pixel of a row, from its code, and settled where in doubt."""
    off, doubt, out = work
    kept, height, ratio = len(rows.bad), images.shape[1], plan.ratio[axis]
    k, above, under = y % kept, max(y - 1, 0) % kept, min(y + 1, height - 1) % kept
    _nearest_period(rows.code[axis], rows.turn[axis], k, ratio, period, off)
    if plan.bits[axis]:
        least, most = rows.least[axis], rows.most
        _mark_seen(rows.code[axis], k, above, under, least, most, doubt)
        _mark_doubt(off, ratio, rows.variance[axis], rows.bad, k, doubt, lost)
        asked = out[: which(doubt, out)]
        _settle(images, y, axis, plan, rows, asked, off, period, lost)


@njit(cache=True, nogil=True, error_model="numpy")
def _place_row(period, turn, variance, k, length, extent, location, status):
    """Locations, and where they are beyond the monitor's border by more than noise."""
    slack = FAR * length * length
    for x in range(len(status)):
        place = length * (np.float32(period[x]) + turn[k, x])
        location[x] = place
        beyond = max(-place, place - extent)
        off = (beyond > _ZERO) & (beyond * beyond > slack * variance[k, x])
        status[x] = BESIDE if (status[x] == DECODED) & off else status[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_alone(bad, beside, below, k, before, lost, status):
    """status: what is bad or lost, and pixels that break with all four neighbours."""
    for x in range(len(status)):
        apart = (beside[k, x] != 0) & (below[k, x] != 0) & (below[before, x] != 0)
        status[x] = ALONE if apart & (bad[k, x] == DECODED) else bad[k, x]
    for x in range(len(status) - 1):
        joined = (status[x + 1] == ALONE) & (beside[k, x] == 0)
        status[x + 1] = DECODED if joined else status[x + 1]
    for x in range(len(status)):
        status[x] = UNREADABLE if (lost[x] != 0) & (status[x] == DECODED) else status[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _finish(status, variance, k, bias, length, location, sigma):
    """Standard deviations, and NaN where nothing is decoded; bias: squared turns."""
    for x in range(len(status)):
        known = status[x] == DECODED
        spread = length * np.sqrt(variance[k, x] + bias[x])
        sigma[x] = spread if known else _NOWHERE
        location[x] = location[x] if known else _NOWHERE


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_own(alone, k, sigma):
    """Sigma becomes negative where a phase is that of one pixel."""
    for x in range(len(sigma)):
        sigma[x] = -sigma[x] if alone[k, x] else sigma[x]


@njit(cache=True, nogil=True, error_model="numpy")
def place_rows(images, part, plan, mark, bias, rows, out):
    """Give rows their places, with phases found before (`phases.turn_rows`).

    images: (n, H, W) uint8 or uint16; part: (first, stop, place): the rows to decode,
    and the row of `out` at which the first one goes; plan: CodePlan; mark: negative
    sigma where a phase is that of one pixel; bias: `bias.squared_bias`; rows: Rows.
    out: location (A, h, W) float32, sigma alike, cells (A, h, W) int16 and status
    (h, W) uint8.
    """
    location, sigma, cells, statuses = out
    count, width, kept = len(plan.bits), images.shape[2], len(rows.bad)
    doubt = np.zeros(-(-width // 8) * 8, np.uint8)
    work = np.empty(width, np.float32), doubt, np.empty(width, np.int64)
    lost = np.empty(width, np.uint8)
    for y in range(part[0], part[1]):
        i, k, before = y - part[0] + part[2], y % kept, (y - 1) % kept
        status = statuses[i]
        lost[:] = 0
        for axis in range(count):
            if plan.used[axis]:
                _find_period(images, y, axis, plan, rows, work, cells[axis, i], lost)
            else:
                cells[axis, i] = rows.code[axis, k]
        _mark_alone(rows.bad, rows.beside, rows.below, k, before, lost, status)
        for axis in range(count):
            phase = rows.turn[axis], rows.variance[axis], k, plan.length[axis]
            place = plan.extent[axis], location[axis, i]
            _place_row(cells[axis, i], *phase, *place, status)
        for axis in range(count):
            bent, length = bias[axis, i // layout.SQUARE], plan.length[axis]
            places = location[axis, i], sigma[axis, i]
            _finish(status, rows.variance[axis], k, bent, length, *places)
            if mark:
                _mark_own(rows.alone[axis], k, sigma[axis, i])
