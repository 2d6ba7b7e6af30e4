"""From cells and phases to places, row by row, in compiled loops.

Written as `reading`: few arrays to a loop, float32, and all that these functions call
in this file.
"""

import numpy as np
from numba import njit

from raxel.features.active_grid import layout
from raxel.features.active_grid.layout import ALONE, BESIDE, DECODED, REACH, UNREADABLE

# Kinds of doubt about the period, and what becomes of it.
SEEN, EVEN = np.uint8(1), np.uint8(2)
_CLOSE = np.float32(0.02)  # of a period; what a response shifts phases by is less
STAYS, MOVES, LOST = range(3)
# A window whose sum is shorter (its square) holds more than one slope.
COHERENT = np.float32(0.49 * 49**2)
# The cosine of phases on one surface is above this: as for breaks, `reading.APART`.
SAME = np.float32(-1e-6)
# So far from a cell, in cells, its code may be read when an edge is blurred.
BLURRED = np.float32(0.3)
# Beyond the monitor's border by four standard deviations there is no light.
BEYOND_SQUARED = np.float32(16.0)
_ZERO, _QUARTER, _HALF = np.float32(0), np.float32(0.25), np.float32(0.5)
_ONE, _TINY = np.float32(1), np.float32(1e-20)
_SHARE, _OF_CELL = np.float32(1 / 49), np.float32(1 / 12)
_NOWHERE = np.float32(np.nan)
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
def _mark_crossed(sine, cosine, mixed, crossed):
    """Set where a window holds a break (mixed), or its sum of unit vectors is short."""
    for x in range(len(mixed)):
        length = sine[x] * sine[x] + cosine[x] * cosine[x]
        crossed[x] = (mixed[x] != 0) | (length < COHERENT)


@njit(cache=True, nogil=True, error_model="numpy")
def _turn_row(sine, cosine, turn):
    for x in range(len(turn)):
        turn[x] = turns(sine[x], cosine[x])


@njit(cache=True, nogil=True, error_model="numpy")
def _turn_alone(sine, cosine, k, bad, crossed, turn):
    """The own phase of those decoded pixels whose windows are crossed."""
    eight = crossed.view(np.uint64)
    for word in range(len(eight)):
        if eight[word]:
            for x in range(8 * word, min(8 * word + 8, len(turn))):
                if crossed[x] and bad[k, x] == DECODED:
                    turn[x] = turns(sine[k, x], cosine[k, x])


@njit(cache=True, nogil=True, error_model="numpy")
def _variance_row(own, k, crossed, out):
    """Variance of the phase; less by a window."""
    for x in range(len(out)):
        variance = own[k, x]
        out[x] = variance if crossed[x] else _SHARE * variance


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest_period(code, k, turn, ratio, period, off):
    """The period whose place with this phase is nearest to the middle of the cell.

    off: by how much it is beyond the middle, in periods.
    """
    for x in range(len(turn)):
        middle = (np.float32(code[k, x]) + _HALF) * ratio
        nearest = np.ceil(middle - turn[x] - _HALF)
        period[x] = np.int16(nearest)
        off[x] = nearest + turn[x] - middle


@njit(cache=True, nogil=True, error_model="numpy")
def _take_code(code, k, period):
    for x in range(len(period)):
        period[x] = np.int16(code[k, x])


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_seen(code, k, above, under, least, most, seen):
    """Set beside an edge: one of four neighbours is elsewhere, or a bit is weak."""
    width = code.shape[1]
    for x in range(width):
        own = code[k, x]
        weak = 2 * np.int32(least[k, x]) < np.int32(most[k, x])
        elsewhere = (own != code[above, x]) | (own != code[under, x])
        seen[x] = SEEN * (weak | elsewhere)
    for x in range(width - 1):
        seen[x] |= SEEN * (code[k, x] != code[k, x + 1])
    for x in range(width - 1):
        seen[x + 1] |= SEEN * (code[k, x] != code[k, x + 1])


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_even(off, ratio, variance, bad, k, doubt):
    """Add where noise could turn one period into the next; nothing where bad is set."""
    farthest = _ONE - _HALF * ratio
    for x in range(len(off)):
        gap = farthest - abs(off[x])
        even = EVEN * (gap * abs(gap) < BEYOND_SQUARED * variance[x])
        doubt[x] = doubt[x] | even if bad[k, x] == DECODED else 0


@njit(cache=True, nogil=True, error_model="numpy")
def _bit_of_edge(edge, bits):
    """Which bit changes between cells edge - 1 and edge; bit 0 is the coarsest."""
    bit = bits - 1
    while edge % 2 == 0:
        edge //= 2
        bit -= 1
    return bit


@njit(cache=True, nogil=True, error_model="numpy")
def _look_for_edges(images, y, pairs, edges, ratio, axis, rows, off, doubt, lost):
    """Done with where the next period is far, or nothing is seen of the edge across.

    A pixel whose phase is near the start or end of its period is at one edge of its
    cell, or beyond the other one, with that edge's bit misread: then the bit has lost
    contrast. Where noise could turn the phase around, one of the two must be seen, by
    that or by four neighbours, of which one is read beyond it.

    edges: the first edge behind the last cell that is shown; neither there nor at the
    monitor's other border is anything to be seen. doubt becomes 0, and stays where the
    edge across is seen.
    """
    code, most, k = rows.code, rows.most, y % len(rows.bad)
    above, under = _rows_beside(images, y, rows)
    last, eight = len(off) - 1, doubt.view(np.uint64)
    farthest, reach = _ONE - _HALF * ratio, BLURRED * ratio
    # Few are in doubt: eight pixels at a time are passed over. Nothing called here
    # takes arrays, as counting their references would take longer than all else.
    for word in range(len(eight)):
        if not eight[word]:
            continue
        for x in range(8 * word, min(8 * word + 8, len(off))):
            if not doubt[x]:
                continue
            seen, even = doubt[x] & SEEN != 0, doubt[x] & EVEN != 0
            gap = farthest - abs(off[x])
            if not seen or (gap >= reach and not even):
                lost[x] = 1 if even else lost[x]
                doubt[x] = 0
                continue
            cell, below = np.int64(code[axis, k, x]), off[x] < _ZERO
            near = across = False
            for edge in range(max(cell, 1), min(cell + 2, edges)):
                behind = cell >= edge
                seen = (code[axis, above, x] >= edge) != behind
                seen |= (code[axis, under, x] >= edge) != behind
                seen |= (code[axis, k, max(x - 1, 0)] >= edge) != behind
                seen |= (code[axis, k, min(x + 1, last)] >= edge) != behind
                bit = _bit_of_edge(edge, len(pairs))
                light = np.int64(images[pairs[bit, 0], y, x])
                dark = np.int64(images[pairs[bit, 1], y, x])
                weak = 4 * abs(light - dark) < 3 * np.int64(most[k, x])
                if behind == below:
                    near = seen | weak
                else:
                    across = weak | (seen & (even | (gap < _CLOSE)))
            if not across:
                lost[x] = 1 if even & (not near) else lost[x]
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
    ratio = plan.ratio[axis]
    _look_for_edges(images, y, pairs, edges, ratio, axis, rows, off, doubt, lost)
    eight = doubt.view(np.uint64)
    for word in range(len(eight)):
        if not eight[word]:
            continue
        for x in range(8 * word, min(8 * word + 8, len(off))):
            if not doubt[x]:
                continue
            below, even = off[x] < _ZERO, doubt[x] & EVEN != 0
            verdict = _settled(images, y, x, pairs, edges, even, axis, rows, below)
            if verdict == MOVES:
                period[x] += 1 if below else -1
            elif verdict == LOST:
                lost[x] = 1


@njit(cache=True, nogil=True, error_model="numpy")
def _place_row(period, turn, variance, length, extent, location, status):
    """Locations, and where they are beyond the monitor's border by more than noise."""
    slack = BEYOND_SQUARED * length * length
    for x in range(len(status)):
        place = length * (np.float32(period[x]) + turn[x])
        location[x] = place
        beyond = max(-place, place - extent)
        off = (beyond > _ZERO) & (beyond * beyond > slack * variance[x])
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
def _finish(status, variance, bias, length, location, sigma):
    """Standard deviations, and NaN where nothing is decoded; bias: squared turns."""
    for x in range(len(status)):
        known = status[x] == DECODED
        spread = length * np.sqrt(variance[x] + bias[x])
        sigma[x] = spread if known else _NOWHERE
        location[x] = location[x] if known else _NOWHERE


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_windows(crossed, sigma):
    """Sigma becomes negative where a phase is not the mean of a window."""
    for x in range(len(sigma)):
        sigma[x] = -sigma[x] if crossed[x] else sigma[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _rows_beside(images, y, rows):
    """Where the rows above and below row y are kept; at the border, row y."""
    kept, height = len(rows.bad), images.shape[1]
    return max(y - 1, 0) % kept, min(y + 1, height - 1) % kept


@njit(cache=True, nogil=True, error_model="numpy")
def _smooth(unit, y, is_first, columns, sums, mixed, bad, crossed, turn):
    """The phases of a row from the sums of unit vectors over 7 x 7 pixels.

    unit, columns, sums: each of sine and cosine: rows kept; sums of seven rows, those
    around row y - 1 unless y is the first; a row to work in. A pixel keeps its own
    phase where its window is crossed.
    """
    for part in range(2):
        if is_first:
            _add_rows(unit[part], y, columns[part])
        else:
            _move_rows(unit[part], y, columns[part])
        _add_columns(columns[part], sums[part])
    _mark_crossed(*sums, mixed, crossed)
    _turn_row(*sums, turn)
    _turn_alone(*unit, y % len(bad), bad, crossed, turn)


@njit(cache=True, nogil=True, error_model="numpy")
def _find_period(images, y, axis, plan, rows, turn, variance, off, doubt, period, lost):
    """The period of each pixel of a row, from its code, and settled where in doubt."""
    k, code, ratio = y % len(rows.bad), rows.code[axis], plan.ratio[axis]
    _nearest_period(code, k, turn, ratio, period, off)
    if plan.bits[axis]:
        beside = _rows_beside(images, y, rows)
        _mark_seen(code, k, *beside, rows.least[axis], rows.most, doubt)
        _mark_even(off, ratio, variance, rows.bad, k, doubt)
        _settle(images, y, axis, plan, rows, off, doubt, period, lost)


@njit(cache=True, nogil=True, error_model="numpy")
def decode_rows(images, part, plan, smooth, mark, bias, rows, out):
    """Decode rows that were read (`reading.read_rows`), REACH before, AHEAD behind.

    images: (n, H, W) uint8 or uint16; part: (first, stop, place): the rows to decode,
    and the row of `out` at which the first one goes; plan: CodePlan; smooth: over
    windows; mark: negative sigma for those that are not; bias: `bias.squared_bias`;
    rows: Rows. out: location (A, h, W) float32, sigma alike, cells (A, h, W) int16 and
    status (h, W) uint8.
    """
    location, sigma, cells, statuses = out
    count, (height, width) = len(plan.bits), images.shape[1:]
    eights = -(-width // 8) * 8  # so that eight can be looked at together
    crossed, doubt = np.zeros((count, eights), np.uint8), np.zeros(eights, np.uint8)
    # An array that is taken apart by unpacking loses that its rows are in one piece.
    mixed, of_breaks = np.ones(width, np.uint8), np.empty(width, np.uint8)
    lost, off = np.empty(width, np.uint8), np.empty(width, np.float32)
    sine, cosine = np.empty(width, np.float32), np.empty(width, np.float32)
    turn = np.empty((count, width), np.float32)
    variance = np.empty((count, width), np.float32)
    columns = np.empty((count, 2, width), np.float32)
    for y in range(part[0], part[1]):
        i, k = y - part[0] + part[2], y % len(rows.bad)
        windows = smooth and y >= REACH and y + REACH < height and width > 2 * REACH
        if windows:
            _add_rows(rows.crossed, y, of_breaks)
            _add_columns(of_breaks, mixed)
        lost[:] = 0
        for axis in range(count):
            unit = rows.sine[axis], rows.cosine[axis]
            if not plan.used[axis]:
                turn[axis], variance[axis] = _HALF, _OF_CELL
                _take_code(rows.code[axis], k, cells[axis, i])
                continue
            if windows:
                is_first = y == max(part[0], REACH)
                sums = (columns[axis, 0], columns[axis, 1]), (sine, cosine)
                own = mixed, rows.bad, crossed[axis], turn[axis]
                _smooth(unit, y, is_first, *sums, *own)
            else:
                crossed[axis] = 1
                _turn_row(unit[0][k], unit[1][k], turn[axis])
            _variance_row(rows.variance[axis], k, crossed[axis], variance[axis])
            found = turn[axis], variance[axis], off, doubt, cells[axis, i], lost
            _find_period(images, y, axis, plan, rows, *found)
        status, before = statuses[i], (y - 1) % len(rows.bad)
        _mark_alone(rows.bad, rows.beside, rows.below, k, before, lost, status)
        for axis in range(count):
            own = cells[axis, i], turn[axis], variance[axis], plan.length[axis]
            _place_row(*own, plan.extent[axis], location[axis, i], status)
        for axis in range(count):
            bent, length = bias[axis, i // layout.SQUARE], plan.length[axis]
            places = location[axis, i], sigma[axis, i]
            _finish(status, variance[axis], bent, length, *places)
            if mark:
                _mark_windows(crossed[axis], sigma[axis, i])
