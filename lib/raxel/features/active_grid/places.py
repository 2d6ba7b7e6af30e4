"""From cells and phases to places, row by row, in compiled loops.

Written as `reading`: few arrays to a loop, float32, and all that these functions call
in this file.
"""

import numpy as np
from numba import njit

from raxel.features.active_grid.layout import ALONE, BESIDE, DECODED, REACH, UNREADABLE

# Kinds of doubt about the period.
POSSIBLE, EVEN = 1, 2
STAYS, MOVES, LOST = range(3)
# A window whose mean is shorter (its square) holds more than one slope.
COHERENT = np.float32(0.49)
# The cosine of phases on one surface is above this: as for breaks, `reading.APART`.
SAME = np.float32(-1e-6)
# So far from a cell, in cells, its code may be read when an edge is blurred.
BLURRED = np.float32(0.3)
# Beyond the monitor's border by so many standard deviations there is no light.
BEYOND = np.float32(4.0)
_ZERO, _QUARTER, _HALF = np.float32(0), np.float32(0.25), np.float32(0.5)
_ONE, _TINY = np.float32(1), np.float32(1e-20)
_SHARE, _SEVENTH = np.float32(1 / 49), np.float32(1 / 7)
_CIRCLE = np.float32(2 * np.pi)
_EVEN, _NOWHERE = np.float32(1 / np.sqrt(12)), np.float32(np.nan)
# arctan(q) / (2 pi q) as a polynomial in q^2 on [0, 1], right to 3e-8 turns.
_ARCTAN = tuple(
    np.float32(c)
    for c in (
        *(0.159154837, -0.0530461211, 0.0317459458, -0.0221362732),
        *(0.015346036, -0.00889872415, 0.00347959743, -0.000645304089),
    )
)


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
def _sum_of_window(rows, y, column, out):
    """out[x] for REACH <= x < W - REACH: the sum over 7 x 7 of rows kept around y."""
    n = len(rows)
    a, b, c = rows[(y - 3) % n], rows[(y - 2) % n], rows[(y - 1) % n]
    d, e, f, g = rows[y % n], rows[(y + 1) % n], rows[(y + 2) % n], rows[(y + 3) % n]
    for x in range(len(column)):
        column[x] = (a[x] + b[x]) + (c[x] + d[x]) + (e[x] + f[x]) + g[x]
    n = len(out) - 6
    a, b, c, d = column[0:n], column[1 : n + 1], column[2 : n + 2], column[3 : n + 3]
    e, f, g = column[4 : n + 4], column[5 : n + 5], column[6 : n + 6]
    middle = out[3 : n + 3]
    for x in range(n):
        middle[x] = (a[x] + b[x]) + (c[x] + d[x]) + (e[x] + f[x]) + g[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _any_in_window(rows, y, column, out):
    """As `_sum_of_window`, of flags: whether any is set; set at the borders."""
    out[:] = 1
    n = len(rows)
    a, b, c = rows[(y - 3) % n], rows[(y - 2) % n], rows[(y - 1) % n]
    d, e, f, g = rows[y % n], rows[(y + 1) % n], rows[(y + 2) % n], rows[(y + 3) % n]
    for x in range(len(column)):
        column[x] = a[x] | b[x] | c[x] | d[x] | e[x] | f[x] | g[x]
    n = len(out) - 6
    a, b, c, d = column[0:n], column[1 : n + 1], column[2 : n + 2], column[3 : n + 3]
    e, f, g = column[4 : n + 4], column[5 : n + 5], column[6 : n + 6]
    middle = out[3 : n + 3]
    for x in range(n):
        middle[x] = a[x] | b[x] | c[x] | d[x] | e[x] | f[x] | g[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_incoherent(sine_sum, cosine_sum, mixed, crossed):
    """Set as mixed is, and where the mean of a window of unit vectors is short."""
    for x in range(len(crossed)):
        s, c = _SHARE * sine_sum[x], _SHARE * cosine_sum[x]
        crossed[x] = 1 if s * s + c * c < COHERENT else mixed[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _choose(crossed, value, window_sum):
    """window_sum becomes the mean of the window, or the value where that is crossed."""
    for x in range(len(value)):
        window_sum[x] = value[x] if crossed[x] else _SHARE * window_sum[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _turn_row(sine, cosine, turn):
    for x in range(len(turn)):
        turn[x] = turns(sine[x], cosine[x])


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest_period(code, turn, ratio, period):
    """The period whose place with this phase is nearest to the middle of the cell."""
    for x in range(len(turn)):
        middle = (np.float32(code[x]) + _HALF) * ratio
        period[x] = np.int16(np.ceil(middle - turn[x] - _HALF))


@njit(cache=True, nogil=True, error_model="numpy")
def _distance_to_next(code, turn, period, ratio, out):
    """How far the next period's place with this phase is from the cell, in periods."""
    for x in range(len(turn)):
        middle = (np.float32(code[x]) + _HALF) * ratio
        off = np.float32(period[x]) + turn[x] - middle
        out[x] = (_ONE - abs(off)) - _HALF * ratio


@njit(cache=True, nogil=True, error_model="numpy")
def _near_edges(code, above, under, out):
    """Set where one of four neighbours is in another cell."""
    for x in range(len(out)):
        out[x] = (code[x] != above[x]) | (code[x] != under[x])
    left, right = code[:-1], code[1:]
    at_left, at_right = out[:-1], out[1:]
    for x in range(len(left)):
        at_left[x] |= left[x] != right[x]
    for x in range(len(left)):
        at_right[x] |= left[x] != right[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_seen(least, most, seen):
    """seen, set beside an edge, is set as well where a bit has lost its contrast."""
    for x in range(len(seen)):
        weak = 2 * np.int32(least[x]) < np.int32(most[x])
        seen[x] = seen[x] | weak


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_doubt(gap, reach, sigma, share, seen, bad, doubt, lost):
    """Where the next period is near, and where noise could turn one into the other.

    If no edge is seen there, nothing says which one it is.
    """
    for x in range(len(gap)):
        even = gap[x] < share * sigma[x]
        doubt[x] = EVEN if even else (POSSIBLE if gap[x] < reach else 0)
        doubt[x] = doubt[x] if (seen[x] != 0) & (bad[x] == DECODED) else 0
    for x in range(len(gap)):
        even = gap[x] < share * sigma[x]
        lost[x] = 1 if even & (seen[x] == 0) else lost[x]


@njit(inline="always", error_model="numpy")
def _surroundings(y, x, height, rows, axis):
    """Which of 3 x 3 pixels see the same surface, as bits of a number; how many.

    Not those that are bad, outside, or on the other side of a break.
    """
    # Indexed in one step: a row taken out counts as a reference, which takes time.
    sine, cosine, code, bad = rows.sine, rows.cosine, rows.code, rows.bad
    kept, width, count, around = len(bad), bad.shape[1], 0, 0
    k = y % kept
    own, s, c = np.int64(code[axis, k, x]), sine[axis, k, x], cosine[axis, k, x]
    for place in range(9):
        v, u = y + place // 3 - 1, x + place % 3 - 1
        if 0 <= v < height and 0 <= u < width:
            i = v % kept
            along = s * sine[axis, i, u] + c * cosine[axis, i, u]
            same = abs(np.int64(code[axis, i, u]) - own) <= 1
            if same and bad[i, u] == DECODED and along >= SAME:
                around |= 1 << place
                count += 1
    return around, count


@njit(inline="always", error_model="numpy")
def _bit_around(images, y, x, around, light, dark):
    """Sum of picture less inverse over pixels around, positive if they agree."""
    total = 0
    for place in range(9):
        if around >> place & 1:
            v, u = y + place // 3 - 1, x + place % 3 - 1
            total += np.int64(images[light, v, u]) - np.int64(images[dark, v, u])
    return total if images[light, y, x] > images[dark, y, x] else -total


@njit(inline="always", error_model="numpy")
def _bit_of_edge(edge, bits):
    """Which bit changes between cells edge - 1 and edge; bit 0 is the coarsest."""
    bit = bits - 1
    while edge % 2 == 0:
        edge //= 2
        bit -= 1
    return bit


@njit(inline="always", error_model="numpy")
def _is_seen(images, y, x, pairs, edge, axis, rows):
    """Whether a pixel is at an edge of its cell, by itself or one of four neighbours.

    Its own bit has lost contrast there, or a neighbour is read beyond it.
    """
    code, kept, height = rows.code, len(rows.bad), images.shape[1]
    k, above = y % kept, max(y - 1, 0) % kept
    under, left = min(y + 1, height - 1) % kept, max(x - 1, 0)
    right, behind = min(x + 1, code.shape[2] - 1), code[axis, k, x] >= edge
    beyond = (code[axis, above, x] >= edge) != behind
    beyond |= (code[axis, under, x] >= edge) != behind
    beyond |= (code[axis, k, left] >= edge) != behind
    beyond |= (code[axis, k, right] >= edge) != behind
    bit = _bit_of_edge(edge, len(pairs))
    light, dark = images[pairs[bit, 0], y, x], images[pairs[bit, 1], y, x]
    contrast = abs(np.int64(light) - np.int64(dark))
    return beyond or 2 * contrast < np.int64(rows.most[k, x])


@njit(inline="always", error_model="numpy")
def _settled(images, y, x, pairs, edges, is_even, axis, rows, below):
    """The wrap rule: at an edge of cells the phase says on which side a pixel is.

    A pixel whose phase is near the start or end of its period is at one edge of its
    cell, or beyond the other one, with that edge's bit misread. Where something is to
    be seen of that other edge, the bits of both decide, each as a mean of the 3 x 3
    pixels that see the same surface: the bit of the edge at which a pixel is has lost
    its contrast. edges: the first edge behind the last cell that is shown; neither
    there nor at the monitor's other border is anything to be seen. below: whether the
    place is below the middle of the cell.

    Returns STAYS, MOVES, or LOST where neither edge is seen and noise could turn the
    phase around (is_even).
    """
    kept = y % len(rows.bad)
    cell = np.int64(rows.code[axis, kept, x])
    near, far = (cell, cell + 1) if below else (cell + 1, cell)
    has_near, has_far = 0 < near < edges, 0 < far < edges
    if not has_far or not _is_seen(images, y, x, pairs, far, axis, rows):
        if not is_even:
            return STAYS
        seen = has_near and _is_seen(images, y, x, pairs, near, axis, rows)
        return STAYS if seen else LOST
    around, count = _surroundings(y, x, images.shape[1], rows, axis)
    half = count * np.int64(rows.most[kept, x])
    k = _bit_of_edge(far, len(pairs))
    at_far = 2 * _bit_around(images, y, x, around, pairs[k, 0], pairs[k, 1])
    at_near = half
    if has_near:
        k = _bit_of_edge(near, len(pairs))
        at_near = 2 * abs(_bit_around(images, y, x, around, pairs[k, 0], pairs[k, 1]))
    if at_far < min(half, at_near):
        return MOVES
    return LOST if is_even and at_near >= half else STAYS


@njit(cache=True, nogil=True, error_model="numpy")
def _settle(images, y, axis, plan, rows, turn, doubt, period, lost):
    """Settle the pixels in doubt: period moves by one, or lost is set."""
    pairs, edges = plan.pairs[axis, : plan.bits[axis]], plan.edges[axis]
    ratio, kept = plan.ratio[axis], y % len(rows.bad)
    code = rows.code[axis, kept]
    eight = doubt.view(np.uint64)
    # Few are in doubt: eight pixels at a time are passed over.
    for k in range(len(eight)):
        if not eight[k]:
            continue
        for x in range(8 * k, min(8 * k + 8, len(turn))):
            if not doubt[x]:
                continue
            middle = (np.float32(code[x]) + _HALF) * ratio
            below, is_even = np.float32(period[x]) + turn[x] < middle, doubt[x] == EVEN
            verdict = _settled(images, y, x, pairs, edges, is_even, axis, rows, below)
            if verdict == MOVES:
                period[x] += 1 if below else -1
            elif verdict == LOST:
                lost[x] = 1


@njit(cache=True, nogil=True, error_model="numpy")
def _sigma_row(strength, level, crossed, floor, slope, share, out):
    """Standard deviation: of the phase, times what a turn is long; less by a window."""
    for x in range(len(out)):
        spread = np.sqrt((floor + slope * level[x]) / strength[x])
        out[x] = spread if crossed[x] else share * spread


@njit(cache=True, nogil=True, error_model="numpy")
def _location_row(period, turn, length, out):
    for x in range(len(out)):
        out[x] = length * (np.float32(period[x]) + turn[x])


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_beside(location, sigma, extent, status):
    for x in range(len(status)):
        slack = BEYOND * sigma[x]
        off = (location[x] < -slack) | (location[x] > extent + slack)
        status[x] = BESIDE if (status[x] == DECODED) & off else status[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_alone(bad, beside, below, above, lost, status):
    """status: what is bad or lost, and pixels that break with all four neighbours."""
    for x in range(len(status)):
        apart = (beside[x] != 0) & (below[x] != 0) & (above[x] != 0)
        status[x] = ALONE if apart & (bad[x] == DECODED) else bad[x]
    here, left = status[1:], beside[:-1]
    for x in range(len(here)):
        here[x] = DECODED if (here[x] == ALONE) & (left[x] == 0) else here[x]
    for x in range(len(status)):
        status[x] = UNREADABLE if (lost[x] != 0) & (status[x] == DECODED) else status[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _blank(status, location, sigma):
    for x in range(len(status)):
        good = status[x] == DECODED
        location[x] = location[x] if good else _NOWHERE
        sigma[x] = sigma[x] if good else _NOWHERE


@njit(cache=True, nogil=True, error_model="numpy")
def _smooth(rows, y, axis, mixed, spare, crossed, sine, cosine):
    """Mean sine and cosine of a row's windows, the pixel's own where one is crossed."""
    own = y % len(rows.bad)
    _sum_of_window(rows.sine[axis], y, spare, sine)
    _sum_of_window(rows.cosine[axis], y, spare, cosine)
    _mark_incoherent(sine, cosine, mixed, crossed)
    _choose(crossed, rows.sine[axis, own], sine)
    _choose(crossed, rows.cosine[axis, own], cosine)


@njit(cache=True, nogil=True, error_model="numpy")
def _find_period(images, y, axis, plan, rows, turn, sigma, doubt, period, lost):
    """The period of each pixel of a row, from its code, and settled where in doubt."""
    n, gap = len(rows.bad), np.empty(len(turn), np.float32)
    k, code, ratio = y % n, rows.code[axis], plan.ratio[axis]
    _nearest_period(code[k], turn, ratio, period)
    if not plan.bits[axis]:
        return
    above, under = max(y - 1, 0) % n, min(y + 1, images.shape[1] - 1) % n
    seen = np.empty(len(turn), np.uint8)
    _near_edges(code[k], code[above], code[under], seen)
    _distance_to_next(code[k], turn, period, ratio, gap)
    _mark_seen(rows.least[axis, k], rows.most[k], seen)
    near, even = BLURRED * ratio, BEYOND / plan.length[axis]
    _mark_doubt(gap, near, sigma, even, seen, rows.bad[k], doubt, lost)
    _settle(images, y, axis, plan, rows, turn, doubt, period, lost)


@njit(cache=True, nogil=True, error_model="numpy")
def decode_rows(images, part, plan, smooth, noise, rows, out):
    """Decode rows that were read (`reading.read_rows`), REACH before, AHEAD behind.

    images: (n, H, W) uint8 or uint16; part: (first, stop, place): the rows to decode,
    and the row of `out` at which the first one goes; plan: CodePlan; noise: (floor,
    slope) float32 of the variance in grey levels; rows: Rows. out:
    location (A, h, W) float32, sigma alike, cells (A, h, W) int16 and status (h, W)
    uint8.
    """
    location, sigma, cells, statuses = out
    height, width = images.shape[1:]
    mixed, crossed = np.empty(width, np.uint8), np.empty(width, np.uint8)
    column, lost = np.empty(width, np.uint8), np.empty(width, np.uint8)
    doubt = np.zeros(-(-width // 8) * 8, np.uint8)
    s, c = np.empty(width, np.float32), np.empty(width, np.float32)
    turn, spare = np.empty(width, np.float32), np.empty(width, np.float32)
    for y in range(part[0], part[1]):
        i, k = y - part[0] + part[2], y % len(rows.bad)
        before, status = (y - 1) % len(rows.bad), statuses[i]
        windows = smooth and y >= REACH and y + REACH < height and width > 2 * REACH
        lost[:] = 0
        if windows:
            _any_in_window(rows.crossed, y, column, mixed)
        for axis in range(len(plan.bits)):
            length, spread = plan.length[axis], sigma[axis, i]
            period = cells[axis, i]
            if plan.used[axis]:
                if windows:
                    _smooth(rows, y, axis, mixed, spare, crossed, s, c)
                    _turn_row(s, c, turn)
                else:
                    crossed[:] = 1
                    _turn_row(rows.sine[axis, k], rows.cosine[axis, k], turn)
                limit = (length / _CIRCLE) ** 2 * plan.spread[axis]
                lit = rows.strength[axis, k], rows.level[axis, k]
                noises = limit * noise[0], limit * noise[1]
                _sigma_row(*lit, crossed, *noises, _SEVENTH, spread)
                _find_period(
                    images, y, axis, plan, rows, turn, spread, doubt, period, lost
                )
            else:
                turn[:] = _HALF
                for x in range(width):
                    period[x] = np.int16(rows.code[axis, k, x])
                spread[:] = length * _EVEN
            _location_row(period, turn, length, location[axis, i])
        breaks = rows.beside[k], rows.below[k], rows.below[before]
        _mark_alone(rows.bad[k], *breaks, lost, status)
        for axis in range(len(plan.bits)):
            _mark_beside(location[axis, i], sigma[axis, i], plan.extent[axis], status)
        for axis in range(len(plan.bits)):
            _blank(status, location[axis, i], sigma[axis, i])
