"""From cells and phases to places, row by row, in compiled loops.

Written as `reading`: few arrays to a loop, float32, and all that these functions call
in this file.
"""

import numpy as np
from numba import njit

from raxel.features.active_grid import layout
from raxel.features.active_grid.layout import ALONE, BESIDE, DECODED, REACH, UNREADABLE

# Kinds of doubt about the period, and what becomes of it.
POSSIBLE, CLOSE, EVEN = 1, 2, 3
_CLOSE = np.float32(0.02)  # of a period; what a response shifts phases by is less
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
def _mean_of_window(mixed, own_sine, own_cosine, sine, cosine, crossed):
    """Sums of unit vectors become means, or a pixel's own where they are no mean.

    crossed: set where mixed is, and where the mean is short.
    """
    for x in range(len(crossed)):
        s, c = _SHARE * sine[x], _SHARE * cosine[x]
        crossed[x] = 1 if s * s + c * c < COHERENT else mixed[x]
    for x in range(len(crossed)):
        sine[x] = own_sine[x] if crossed[x] else _SHARE * sine[x]
    for x in range(len(crossed)):
        cosine[x] = own_cosine[x] if crossed[x] else _SHARE * cosine[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _turn_row(sine, cosine, turn):
    for x in range(len(turn)):
        turn[x] = turns(sine[x], cosine[x])


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest_period(code, turn, ratio, period, off):
    """The period whose place with this phase is nearest to the middle of the cell.

    off: by how much it is beyond the middle, in periods.
    """
    for x in range(len(turn)):
        middle = (np.float32(code[x]) + _HALF) * ratio
        nearest = np.ceil(middle - turn[x] - _HALF)
        period[x] = np.int16(nearest)
        off[x] = nearest + turn[x] - middle


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_seen(code, above, under, least, most, seen):
    """Set beside an edge: one of four neighbours is elsewhere, or a bit is weak."""
    for x in range(len(seen)):
        weak = 2 * np.int32(least[x]) < np.int32(most[x])
        seen[x] = (code[x] != above[x]) | (code[x] != under[x]) | weak
    left, right = code[:-1], code[1:]
    at_left, at_right = seen[:-1], seen[1:]
    for x in range(len(left)):
        at_left[x] |= left[x] != right[x]
    for x in range(len(left)):
        at_right[x] |= left[x] != right[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_doubt(off, ratio, sigma, share, seen, bad, doubt, lost):
    """Where the next period is near, and where noise could turn one into the other.

    If no edge is seen there, nothing says which one it is.
    """
    farthest, reach = _ONE - _HALF * ratio, BLURRED * ratio
    for x in range(len(off)):
        gap = farthest - abs(off[x])
        even = gap < share * sigma[x]
        near = CLOSE if gap < _CLOSE else (POSSIBLE if gap < reach else 0)
        asked = (seen[x] != 0) & (bad[x] == DECODED)
        doubt[x] = (EVEN if even else near) if asked else 0
        lost[x] = 1 if even & (seen[x] == 0) else lost[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _bit_of_edge(edge, bits):
    """Which bit changes between cells edge - 1 and edge; bit 0 is the coarsest."""
    bit = bits - 1
    while edge % 2 == 0:
        edge //= 2
        bit -= 1
    return bit


@njit(cache=True, nogil=True, error_model="numpy")
def _look_for_edges(images, y, pairs, edges, codes, most, off, doubt, lost):
    """Done with where nothing is seen of the edge that lies across the cell.

    A pixel whose phase is near the start or end of its period is at one edge of its
    cell, or beyond the other one, with that edge's bit misread: then the bit has lost
    contrast. Where noise could turn the phase around, one of the two must be seen, by
    that or by four neighbours, of which one is read beyond it.

    edges: the first edge behind the last cell that is shown; neither there nor at the
    monitor's other border is anything to be seen. codes: of the rows above, here and
    below. doubt becomes 0, and stays where the edge across is seen.
    """
    above, code, under = codes
    last, eight = len(off) - 1, doubt.view(np.uint64)
    # Few are in doubt: eight pixels at a time are passed over. Nothing called here
    # takes arrays, as counting their references would take longer than all else.
    for k in range(len(eight)):
        if not eight[k]:
            continue
        for x in range(8 * k, min(8 * k + 8, len(off))):
            if not doubt[x]:
                continue
            cell, below = np.int64(code[x]), off[x] < _ZERO
            near = across = False
            for edge in range(max(cell, 1), min(cell + 2, edges)):
                behind = cell >= edge
                seen = (above[x] >= edge) != behind
                seen |= (under[x] >= edge) != behind
                seen |= (code[max(x - 1, 0)] >= edge) != behind
                seen |= (code[min(x + 1, last)] >= edge) != behind
                bit = _bit_of_edge(edge, len(pairs))
                light = np.int64(images[pairs[bit, 0], y, x])
                dark = np.int64(images[pairs[bit, 1], y, x])
                weak = 4 * abs(light - dark) < 3 * np.int64(most[x])
                if behind == below:
                    near = seen | weak
                else:
                    across = weak | (seen & (doubt[x] >= CLOSE))
            if not across:
                lost[x] = 1 if (doubt[x] == EVEN) & (not near) else lost[x]
                doubt[x] = 0


@njit(cache=True, nogil=True, error_model="numpy")
def _sums_around(images, y, x, first, second, axis, rows):
    """How many of 3 x 3 pixels see the same surface, and two bits' sums over them.

    Not those that are bad, outside, or on the other side of a break. The sums are of
    picture less inverse, positive where the pixel in the middle agrees.
    """
    sine, cosine, code = rows.sine[axis], rows.cosine[axis], rows.code[axis]
    bad, kept, k = rows.bad, len(rows.bad), y % len(rows.bad)
    count, sums, own = 0, np.zeros(2, np.int64), np.int64(code[k, x])
    for v in range(max(y - 1, 0), min(y + 2, images.shape[1])):
        i = v % kept
        for u in range(max(x - 1, 0), min(x + 2, images.shape[2])):
            along = sine[k, x] * sine[i, u] + cosine[k, x] * cosine[i, u]
            same = abs(np.int64(code[i, u]) - own) <= 1
            if same and bad[i, u] == DECODED and along >= SAME:
                count += 1
                for n, pair in enumerate((first, second)):
                    sums[n] += np.int64(images[pair[0], v, u])
                    sums[n] -= np.int64(images[pair[1], v, u])
    for n, pair in enumerate((first, second)):
        if images[pair[0], y, x] <= images[pair[1], y, x]:
            sums[n] = -sums[n]
    return count, sums


@njit(cache=True, nogil=True, error_model="numpy")
def _settled(images, y, x, pairs, edges, is_even, axis, rows, below):
    """The wrap rule: at an edge of cells the phase says on which side a pixel is.

    The bit of the edge at which a pixel is has lost its contrast, so the bits of both
    edges of its cell decide, each as a mean of the 3 x 3 pixels that see the same
    surface. below: whether the place is below the middle of the cell.

    Returns STAYS, MOVES, or LOST where neither bit has lost contrast and noise could
    turn the phase around (is_even).
    """
    k = y % len(rows.bad)
    cell, most = np.int64(rows.code[axis, k, x]), np.int64(rows.most[k, x])
    near, across = (cell, cell + 1) if below else (cell + 1, cell)
    second = first = pairs[_bit_of_edge(across, len(pairs))]
    if 0 < near < edges:
        second = pairs[_bit_of_edge(near, len(pairs))]
    count, sums = _sums_around(images, y, x, first, second, axis, rows)
    half = count * most
    at_near = 2 * abs(sums[1]) if 0 < near < edges else half
    if 2 * sums[0] < min(half, at_near):
        return MOVES
    return LOST if is_even and at_near >= half else STAYS


@njit(cache=True, nogil=True, error_model="numpy")
def _settle(images, y, axis, plan, rows, off, doubt, period, lost):
    """Settle the pixels in doubt: period moves by one, or lost is set."""
    pairs, edges = plan.pairs[axis, : plan.bits[axis]], plan.edges[axis]
    height, kept, code = images.shape[1], len(rows.bad), rows.code[axis]
    above, under = code[max(y - 1, 0) % kept], code[min(y + 1, height - 1) % kept]
    codes, most = (above, code[y % kept], under), rows.most[y % kept]
    _look_for_edges(images, y, pairs, edges, codes, most, off, doubt, lost)
    eight = doubt.view(np.uint64)
    for k in range(len(eight)):
        if not eight[k]:
            continue
        for x in range(8 * k, min(8 * k + 8, len(off))):
            if not doubt[x]:
                continue
            below, even = off[x] < _ZERO, doubt[x] == EVEN
            verdict = _settled(images, y, x, pairs, edges, even, axis, rows, below)
            if verdict == MOVES:
                period[x] += 1 if below else -1
            elif verdict == LOST:
                lost[x] = 1


@njit(cache=True, nogil=True, error_model="numpy")
def _sigma_row(strength, level, crossed, floor, slope, least, share, out):
    """Standard deviation: of the phase, times what a turn is long; less by a window."""
    for x in range(len(out)):
        spread = np.sqrt(max(floor + slope * level[x], least) / strength[x])
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
def _finish(status, length, bias, crossed, mark, location, sigma):
    """NaN where nothing is decoded; the square of a bias in turns goes into sigma.

    mark: sigma becomes negative where crossed is set.
    """
    for x in range(len(status)):
        location[x] = location[x] if status[x] == DECODED else _NOWHERE
    square = length * length
    for x in range(len(status)):
        spread = np.sqrt(sigma[x] * sigma[x] + square * bias[x])
        sigma[x] = spread if status[x] == DECODED else _NOWHERE
    if mark:
        for x in range(len(status)):
            sigma[x] = -sigma[x] if crossed[x] else sigma[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _smooth(rows, y, axis, mixed, spare, crossed, sine, cosine):
    """Mean sine and cosine of a row's windows, the pixel's own where one is crossed."""
    own = y % len(rows.bad)
    _sum_of_window(rows.sine[axis], y, spare, sine)
    _sum_of_window(rows.cosine[axis], y, spare, cosine)
    alone = rows.sine[axis, own], rows.cosine[axis, own]
    _mean_of_window(mixed, *alone, sine, cosine, crossed)


@njit(cache=True, nogil=True, error_model="numpy")
def _find_period(images, y, axis, plan, rows, turn, sigma, doubt, period, lost):
    """The period of each pixel of a row, from its code, and settled where in doubt."""
    n, off = len(rows.bad), np.empty(len(turn), np.float32)
    k, code, ratio = y % n, rows.code[axis], plan.ratio[axis]
    _nearest_period(code[k], turn, ratio, period, off)
    if not plan.bits[axis]:
        return
    above, under = max(y - 1, 0) % n, min(y + 1, images.shape[1] - 1) % n
    seen = np.empty(len(turn), np.uint8)
    far = rows.least[axis, k], rows.most[k]
    _mark_seen(code[k], code[above], code[under], *far, seen)
    even = BEYOND / plan.length[axis]
    _mark_doubt(off, ratio, sigma, even, seen, rows.bad[k], doubt, lost)
    _settle(images, y, axis, plan, rows, off, doubt, period, lost)


@njit(cache=True, nogil=True, error_model="numpy")
def decode_rows(images, part, plan, smooth, mark, noise, bias, rows, out):
    """Decode rows that were read (`reading.read_rows`), REACH before, AHEAD behind.

    images: (n, H, W) uint8 or uint16; part: (first, stop, place): the rows to decode,
    and the row of `out` at which the first one goes; plan: CodePlan; smooth: over
    windows; mark: negative sigma for those that are not; noise: a Noise in float32
    of the variance in grey levels; bias: `bias.squared_bias`; rows: Rows. out: location
    (A, h, W) float32, sigma alike, cells (A, h, W) int16 and status (h, W) uint8.
    """
    location, sigma, cells, statuses = out
    height, width = images.shape[1:]
    crossed = np.zeros((len(plan.bits), width), np.uint8)
    mixed, column, lost = np.empty((3, width), np.uint8)
    doubt = np.zeros(-(-width // 8) * 8, np.uint8)
    s, c = np.empty(width, np.float32), np.empty(width, np.float32)
    turn, spare = np.empty(width, np.float32), np.empty(width, np.float32)
    for y in range(part[0], part[1]):
        i, k = y - part[0] + part[2], y % len(rows.bad)
        before, status = (y - 1) % len(rows.bad), statuses[i]
        windows = smooth and y >= REACH and y + REACH < height and width > 2 * REACH
        lost[:] = 0
        if windows:
            mixed[:] = 1  # at the borders, where there are no windows
            _sum_of_window(rows.crossed, y, column, mixed)
        for axis in range(len(plan.bits)):
            length, spread = plan.length[axis], sigma[axis, i]
            period = cells[axis, i]
            if plan.used[axis]:
                if windows:
                    _smooth(rows, y, axis, mixed, spare, crossed[axis], s, c)
                    _turn_row(s, c, turn)
                else:
                    crossed[axis] = 1
                    _turn_row(rows.sine[axis, k], rows.cosine[axis, k], turn)
                limit = (length / _CIRCLE) ** 2 * plan.spread[axis]
                lit = rows.strength[axis, k], rows.level[axis, k]
                noises = limit * noise[0], limit * noise[1], limit * noise[2]
                _sigma_row(*lit, crossed[axis], *noises, _SEVENTH, spread)
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
            bent = bias[axis, i // layout.SQUARE]
            places = location[axis, i], sigma[axis, i]
            _finish(status, plan.length[axis], bent, crossed[axis], mark, *places)
