"""The decoder's loops over pixels, compiled: one pass over the rows of a picture stack.

What a row needs from the rows around it is kept for eight rows, so that memory does not
grow with the picture. Arithmetic on grey values is in whole numbers where they are, or
in float32 with one rounding for each operation. What these functions call, and their
constants, stand in this file: compiled code is kept from run to run, and made again
when this file changes, not when another one does.
"""

import numpy as np
from numba import njit

DECODED, FILLED, DARK, SATURATED, UNREADABLE, ALONE, BESIDE, RIM = range(8)

# Kinds of doubt about the period.
POSSIBLE, EVEN = 1, 2

KEPT = 8  # rows kept at a time; a power of two
REACH = 3  # of the smoothing window, 7 x 7, to each side
AHEAD = REACH + 1  # rows read before one is decoded: breaks need one more
# A pixel is dark below so many standard deviations of its noise.
LEAST_CONTRAST = np.float32(7.0)
LEAST_MODULATION = np.float32(5.0)
# A window whose mean is shorter (its square) holds more than one slope.
COHERENT = np.float32(0.49)
# The cosine of what is more than a quarter of a turn; not quite 0, as it is rounded.
APART = np.float32(-1e-6)
# So far from a cell, in cells, its code may be read when an edge is blurred.
BLURRED = np.float32(0.3)
# Beyond the monitor's border by so many standard deviations there is no light.
BEYOND = np.float32(4.0)

# Columns of a plan's whole and real numbers.
BITS, STEPS, EDGES, JUMP = range(4)
RATIO, LENGTH, EXTENT, SPREAD = range(4)

_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)
_QUARTER, _SHARE = np.float32(0.25), np.float32(1 / 49)
_TINY, _FOUR = np.float32(1e-20), np.float32(4)
_CIRCLE, _SEVENTH = np.float32(2 * np.pi), np.float32(1 / 7)
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
def _read_gray(images, y, pairs, distant, apart, code, least, second, most):
    """One row of Gray code: the cell, and how far apart pictures and inverses are.

    least, second, most: the smallest, second smallest and largest distance, `distant`
    where there are not so many; the last one is of all axes and not begun anew.
    """
    code[:] = 0
    least[:] = distant
    second[:] = distant
    # Loops over few arrays of one type are compiled to run on many pixels at once.
    for k in range(len(pairs)):
        light, dark = images[pairs[k, 0], y], images[pairs[k, 1], y]
        for x in range(len(code)):
            one = light[x] > dark[x]
            apart[x] = light[x] - dark[x] if one else dark[x] - light[x]
        for x in range(len(code)):
            higher = least[x] if apart[x] < least[x] else apart[x]
            least[x] = apart[x] if apart[x] < least[x] else least[x]
            second[x] = higher if higher < second[x] else second[x]
        for x in range(len(code)):
            most[x] = apart[x] if apart[x] > most[x] else most[x]
        for x in range(len(code)):
            one = light[x] > dark[x]
            code[x] = 2 * code[x] + ((code[x] & 1) ^ one)


@njit(cache=True, nogil=True, error_model="numpy")
def _weigh(images, y, steps, weights, out):
    """out (W,) float32: a weighted sum of a row of the steps, two at a time."""
    begun = False
    for k in range(0, len(steps), 2):
        p, q = weights[k], weights[k + 1]
        if p == _ZERO and q == _ZERO:
            break
        a, b = images[steps[k], y], images[steps[k + 1], y]
        if begun:
            for x in range(len(out)):
                out[x] += p * np.float32(a[x]) + q * np.float32(b[x])
        else:
            for x in range(len(out)):
                out[x] = p * np.float32(a[x]) + q * np.float32(b[x])
        begun = True


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_saturated(images, y, steps, white, bad):
    for k in range(0, len(steps), 2):
        a, b = images[steps[k], y], images[steps[k + 1], y]
        for x in range(len(bad)):
            full = (a[x] >= white) | (b[x] >= white)
            bad[x] = SATURATED if full else bad[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_weak(strength, level, floor, slope, bad):
    """Dark is where the modulation is small beside its noise of floor + slope level."""
    for x in range(len(bad)):
        bad[x] = DARK if strength[x] < floor + slope * level[x] else bad[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_code(level, second, most, floor, slope, bad):
    """Dark is too little contrast; two edges at one place are no Gray code."""
    for x in range(len(bad)):
        contrast = np.float32(most[x])
        bad[x] = UNREADABLE if _FOUR * second[x] < contrast else bad[x]
        square = contrast * contrast
        bad[x] = DARK if square < floor + slope * level[x] else bad[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _to_unit_length(sine, cosine, strength):
    """Divide sine and cosine by the modulation; strength becomes its square."""
    for x in range(len(strength)):
        strength[x] = sine[x] * sine[x] + cosine[x] * cosine[x] + _TINY
    for x in range(len(strength)):
        share = _ONE / np.sqrt(strength[x])
        sine[x] = share * sine[x]
        cosine[x] = share * cosine[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_breaks(sine, cosine, sine2, cosine2, broken):
    """Where the phases of two neighbours are more than a quarter of a turn apart."""
    for x in range(len(broken)):
        along = sine[x] * sine2[x] + cosine[x] * cosine2[x]
        broken[x] = 1 if along < APART else broken[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_jumps(code, code2, limit, broken):
    for x in range(len(broken)):
        apart = abs(np.int32(code[x]) - np.int32(code2[x]))
        broken[x] = 1 if apart > limit else broken[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _either(first, second, out):
    for x in range(len(out)):
        out[x] = (first[x] != 0) | (second[x] != 0)


@njit(cache=True, nogil=True, error_model="numpy")
def _sum_of_window(rows, y, column, out):
    """out[x] for REACH <= x < W - REACH: the sum over 7 x 7 of rows kept around y."""
    a, b, c = rows[(y - 3) % KEPT], rows[(y - 2) % KEPT], rows[(y - 1) % KEPT]
    d, e = rows[y % KEPT], rows[(y + 1) % KEPT]
    f, g = rows[(y + 2) % KEPT], rows[(y + 3) % KEPT]
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
    a, b, c = rows[(y - 3) % KEPT], rows[(y - 2) % KEPT], rows[(y - 1) % KEPT]
    d, e = rows[y % KEPT], rows[(y + 1) % KEPT]
    f, g = rows[(y + 2) % KEPT], rows[(y + 3) % KEPT]
    for x in range(len(column)):
        column[x] = a[x] | b[x] | c[x] | d[x] | e[x] | f[x] | g[x]
    n = len(out) - 6
    a, b, c, d = column[0:n], column[1 : n + 1], column[2 : n + 2], column[3 : n + 3]
    e, f, g = column[4 : n + 4], column[5 : n + 5], column[6 : n + 6]
    middle = out[3 : n + 3]
    for x in range(n):
        middle[x] = a[x] | b[x] | c[x] | d[x] | e[x] | f[x] | g[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_incoherent(sine_sum, cosine_sum, crossed):
    """Set where the mean of a window is shorter than 0.7, each of its parts being 1."""
    for x in range(len(crossed)):
        s, c = _SHARE * sine_sum[x], _SHARE * cosine_sum[x]
        crossed[x] = 1 if s * s + c * c < COHERENT else crossed[x]


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
def _mark_doubt(least, most, at_edge, gap, reach, doubt):
    """Set where the next period is near and a bit is weak, or its edge near as well."""
    for x in range(len(doubt)):
        weak = 2 * np.int32(least[x]) < np.int32(most[x])
        doubt[x] = POSSIBLE if (gap[x] < reach) & (weak | (at_edge[x] != 0)) else 0


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_even(gap, sigma, share, doubt):
    """Set where noise alone could turn one of two periods into the other."""
    for x in range(len(doubt)):
        doubt[x] = EVEN if gap[x] < share * sigma[x] else doubt[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _surroundings(y, x, height, rows, axis, out):
    """Which of 3 x 3 pixels (their rows and columns) see the same surface; how many.

    Not those that are bad, outside, or on the other side of a break.
    """
    sine, cosine, code, bad = rows[0][axis], rows[1][axis], rows[3][axis], rows[7]
    width, count, k = code.shape[1], 0, y % KEPT
    own = np.int64(code[k, x])
    for v in range(max(y - 1, 0), min(y + 2, height)):
        i = v % KEPT
        for u in range(max(x - 1, 0), min(x + 2, width)):
            along = sine[k, x] * sine[i, u] + cosine[k, x] * cosine[i, u]
            same = abs(np.int64(code[i, u]) - own) <= 1
            if same and bad[i, u] == DECODED and along >= APART:
                out[count, 0], out[count, 1] = v, u
                count += 1
    return count


@njit(cache=True, nogil=True, error_model="numpy")
def _bit_around(images, y, x, around, light, dark):
    """Sum of picture less inverse over pixels around, positive if they agree."""
    total = 0
    for v, u in around:
        total += np.int64(images[light, v, u]) - np.int64(images[dark, v, u])
    return total if images[light, y, x] > images[dark, y, x] else -total


@njit(cache=True, nogil=True, error_model="numpy")
def _bit_of_edge(edge, bits):
    """Which bit changes between cells edge - 1 and edge; bit 0 is the coarsest."""
    bit = bits - 1
    while edge % 2 == 0:
        edge //= 2
        bit -= 1
    return bit


@njit(cache=True, nogil=True, error_model="numpy")
def _settle(images, y, pairs, axis, numbers, rows, turn, doubt, period, lost):
    """The wrap rule: at an edge of cells the phase says on which side a pixel is.

    A pixel whose phase is near the start or end of its period is at one edge of its
    cell, or beyond the other one, with that edge's bit misread. The bit of the edge at
    which it is has lost its contrast, so the bits of both edges decide, each as a mean
    of the 3 x 3 pixels that see the same surface. Where neither has, and noise could
    turn the phase around, the pixel is lost. numbers: (edges, ratio); edges: the first
    edge behind the last cell that is shown; neither there nor at the monitor's other
    border is anything to be seen.
    """
    edges, ratio = numbers
    code, most, bad = rows[3][axis, y % KEPT], rows[6][y % KEPT], rows[7][y % KEPT]
    places = np.empty((9, 2), np.int64)
    for x in range(len(doubt)):
        if not doubt[x] or bad[x] != DECODED:
            continue
        cell = np.int64(code[x])
        middle = (np.float32(code[x]) + _HALF) * ratio
        below = np.float32(period[x]) + turn[x] < middle
        near, far = (cell, cell + 1) if below else (cell + 1, cell)
        count = _surroundings(y, x, images.shape[1], rows, axis, places)
        around, half = places[:count], count * np.int64(most[x])
        at_near = at_far = half
        if 0 < far < edges:
            k = _bit_of_edge(far, len(pairs))
            at_far = 2 * _bit_around(images, y, x, around, pairs[k, 0], pairs[k, 1])
        if at_far >= half and doubt[x] != EVEN:
            continue
        if 0 < near < edges:
            k = _bit_of_edge(near, len(pairs))
            near_sum = _bit_around(images, y, x, around, pairs[k, 0], pairs[k, 1])
            at_near = 2 * abs(near_sum)
        if at_far < min(half, at_near):
            period[x] += 1 if below else -1
        elif doubt[x] == EVEN and at_near >= half:
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
def _mark_alone(bad, beside, below, above, status):
    """status: what is bad, and pixels that break with all four neighbours."""
    for x in range(len(status)):
        apart = (beside[x] != 0) & (below[x] != 0) & (above[x] != 0)
        status[x] = ALONE if apart & (bad[x] == DECODED) else bad[x]
    here, left = status[1:], beside[:-1]
    for x in range(len(here)):
        here[x] = DECODED if (here[x] == ALONE) & (left[x] == 0) else here[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _blank(status, location, sigma):
    for x in range(len(status)):
        good = status[x] == DECODED
        location[x] = location[x] if good else _NOWHERE
        sigma[x] = sigma[x] if good else _NOWHERE


@njit(cache=True, nogil=True, error_model="numpy")
def _read_row(images, y, plan, white, noise, rows):
    """All that one row's own pixels say, into the rows kept; returns nothing.

    plan: as for `decode_rows`; rows: those that it keeps.
    """
    pairs, steps, weights, whole, real = plan
    sine, cosine, level, code, least, second, most, bad, beside = rows[:9]
    apart, strength = rows[11:]
    k, distant = y % KEPT, most.dtype.type(np.iinfo(most.dtype).max)
    most[k] = 0
    bad[k] = DECODED
    for axis in range(len(whole)):
        bits, used = whole[axis, BITS], whole[axis, STEPS]
        if bits:
            own = pairs[axis, :bits]
            places = code[axis, k], least[axis, k], second[axis, k], most[k]
            _read_gray(images, y, own, distant, apart, *places)
        if used:
            own, share = steps[axis, :, :used], weights[axis]
            _weigh(images, y, own[0], share[0], sine[axis, k])
            _weigh(images, y, own[1], share[1], cosine[axis, k])
            _weigh(images, y, own[2], share[2], level[axis, k])
            _to_unit_length(sine[axis, k], cosine[axis, k], strength[axis, k])
        else:
            light, dark = images[pairs[axis, 0, 0], y], images[pairs[axis, 0, 1], y]
            for x in range(len(light)):
                level[axis, k, x] = _HALF * (np.float32(light[x]) + np.float32(dark[x]))
    for axis in range(len(whole)):
        if whole[axis, BITS]:
            limit = LEAST_CONTRAST * LEAST_CONTRAST
            floor, slope = limit * noise[0], limit * noise[1]
            _mark_code(level[axis, k], second[axis, k], most[k], floor, slope, bad[k])
        if whole[axis, STEPS]:
            limit = LEAST_MODULATION * LEAST_MODULATION * real[axis, SPREAD]
            floor, slope = limit * noise[0], limit * noise[1]
            _mark_weak(strength[axis, k], level[axis, k], floor, slope, bad[k])
            _mark_saturated(
                images, y, steps[axis, 2, : whole[axis, STEPS]], white, bad[k]
            )
    # Breaks to the right; the picture's border is one.
    beside[k, -1] = 1
    _either(bad[k, :-1], bad[k, 1:], beside[k, :-1])
    for axis in range(len(whole)):
        s, c = sine[axis, k], cosine[axis, k]
        if whole[axis, STEPS]:
            _mark_breaks(s[:-1], c[:-1], s[1:], c[1:], beside[k, :-1])
        own = code[axis, k]
        _mark_jumps(own[:-1], own[1:], whole[axis, JUMP], beside[k, :-1])


@njit(cache=True, nogil=True, error_model="numpy")
def _break_below(y, is_last, plan, rows):
    """Breaks between rows y and y + 1, and with them where a window is crossed."""
    whole = plan[3]
    sine, cosine, _, code, _, _, _, bad, beside, below, crossed = rows[:11]
    k, next_k = y % KEPT, (y + 1) % KEPT
    if is_last:
        below[k] = 1
    else:
        _either(bad[k], bad[next_k], below[k])
        for axis in range(len(whole)):
            s, c = sine[axis], cosine[axis]
            if whole[axis, STEPS]:
                _mark_breaks(s[k], c[k], s[next_k], c[next_k], below[k])
            own = code[axis]
            _mark_jumps(own[k], own[next_k], whole[axis, JUMP], below[k])
    _either(beside[k], below[k], crossed[k])


@njit(cache=True, nogil=True, error_model="numpy")
def _decode_row(images, y, i, windows, plan, noise, rows, spare, out):
    """Row y decoded from the rows kept, into row i; windows: if 7 x 7 are in it."""
    pairs, _, _, whole, real = plan
    sine, cosine, level, code, least, _, most, bad, beside, below, crossed = rows[:11]
    flags, column, s, c, turn, gap, column8, mixed, doubt, at_edge, lost, period = spare
    strength = rows[12]
    location, sigma, cells = out[0], out[1], out[2]
    status, k, before = out[3][i], y % KEPT, (y - 1) % KEPT
    lost[:] = 0
    if windows:
        _any_in_window(crossed, y, column8, mixed)
    else:
        mixed[:] = 1
    for axis in range(len(whole)):
        if whole[axis, STEPS] and windows:
            flags[:] = mixed
            _sum_of_window(sine[axis], y, column, s)
            _sum_of_window(cosine[axis], y, column, c)
            _mark_incoherent(s, c, flags)
            _choose(flags, sine[axis, k], s)
            _choose(flags, cosine[axis, k], c)
        else:
            flags[:] = 1
            s[:] = sine[axis, k]
            c[:] = cosine[axis, k]
        own, ratio, length = code[axis, k], real[axis, RATIO], real[axis, LENGTH]
        if whole[axis, STEPS]:
            _turn_row(s, c, turn)
            _nearest_period(own, turn, ratio, period)
            edges = whole[axis, EDGES]
            limit = (length / _CIRCLE) ** 2 * real[axis, SPREAD]
            floor, slope = limit * noise[0], limit * noise[1]
            spread = sigma[axis, i]
            lit = strength[axis, k], level[axis, k]
            _sigma_row(*lit, flags, floor, slope, _SEVENTH, spread)
            _distance_to_next(own, turn, period, ratio, gap)
            above, under = max(y - 1, 0) % KEPT, min(y + 1, len(images[0]) - 1) % KEPT
            _near_edges(own, code[axis, above], code[axis, under], at_edge)
            _mark_doubt(least[axis, k], most[k], at_edge, gap, BLURRED * ratio, doubt)
            if whole[axis, BITS]:
                _mark_even(gap, spread, BEYOND / length, doubt)
            around = pairs[axis, : whole[axis, BITS]]
            numbers = edges, ratio
            _settle(images, y, around, axis, numbers, rows, turn, doubt, period, lost)
        else:
            turn[:] = _HALF
            for x in range(len(own)):
                period[x] = np.int16(own[x])
            sigma[axis, i] = length * _EVEN
        cells[axis, i] = period
        _location_row(period, turn, length, location[axis, i])
    _mark_alone(bad[k], beside[k], below[k], below[before], status)
    for x in range(len(status)):
        status[x] = UNREADABLE if (lost[x] != 0) & (status[x] == DECODED) else status[x]
    for axis in range(len(whole)):
        places = location[axis, i], sigma[axis, i]
        _mark_beside(*places, real[axis, EXTENT], status)
    for axis in range(len(whole)):
        _blank(status, location[axis, i], sigma[axis, i])


@njit(cache=True, nogil=True, error_model="numpy")
def decode_rows(images, part, plan, smooth, white, noise, out):
    """Decode some rows of a stack of pictures.

    images: (n, H, W) uint8 or uint16; part: (first, stop, place): the rows to decode,
    and the row of `out` at which the first one goes. The stack has REACH rows before
    them and AHEAD behind, as far as the picture goes. plan: (pairs (A, bits, 2),
    steps (A, 3, K), weights (A, 3, K), whole (A, 4) int64, real (A, 4) float32),
    indexed by BITS to SPREAD; see `raxel.features.active_grid.coding`. white: the value
    from which a phase step counts as saturated. noise: (floor, slope) float32 of the
    variance in grey levels. out: location (A, h, W) float32, sigma alike, cells
    (A, h, W) int16 and status (h, W) uint8.
    """
    first, stop, place = part
    height, width = images.shape[1:]
    count = len(out[0])
    grey = np.zeros((KEPT, width), images.dtype)
    rows = (
        np.zeros((count, KEPT, width), np.float32),  # sine
        np.zeros((count, KEPT, width), np.float32),  # cosine
        np.zeros((count, KEPT, width), np.float32),  # level
        np.zeros((count, KEPT, width), np.uint16),  # code
        np.zeros((count, KEPT, width), images.dtype),  # least
        np.zeros((count, KEPT, width), images.dtype),  # second
        grey,  # most
        np.zeros((KEPT, width), np.uint8),  # bad
        np.zeros((KEPT, width), np.uint8),  # beside
        np.ones((KEPT, width), np.uint8),  # below
        np.zeros((KEPT, width), np.uint8),  # crossed
        np.zeros(width, images.dtype),
        np.zeros((count, KEPT, width), np.float32),  # strength
    )
    spare = (
        np.empty(width, np.uint8),
        *(np.empty(width, np.float32), np.empty(width, np.float32)),
        *(np.empty(width, np.float32), np.empty(width, np.float32)),
        np.empty(width, np.float32),
        *(np.empty(width, np.uint8), np.empty(width, np.uint8)),
        *(np.empty(width, np.uint8), np.empty(width, np.uint8)),
        *(np.empty(width, np.uint8), np.empty(width, np.int16)),
    )
    known = max(first - REACH, 0)
    for y in range(first, stop):
        while known < min(y + AHEAD + 1, height):
            _read_row(images, known, plan, white, noise, rows)
            if known:
                _break_below(known - 1, False, plan, rows)
            known += 1
            if known == height:
                _break_below(known - 1, True, plan, rows)
        windows = smooth and y >= REACH and y + REACH < height and width > 2 * REACH
        i = y - first + place
        _decode_row(images, y, i, windows, plan, noise, rows, spare, out)
