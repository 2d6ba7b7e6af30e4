"""Reading of rows of an active grid's images, pixel by pixel, in compiled loops.

Loops are vectorised where few arrays are read and written; fields of one array count
once (`coding`). Arithmetic on grey values uses their integers, or float32 with one
rounding for each operation. All functions called here are in this file: numba's cache
of compiled code depends on this file, not on others.
"""

import numpy as np
from numba import njit

from raxel.features.active_grid.coding import (
    BAD,
    BELOW,
    CELL_OFFSET,
    COSINE,
    CROSSED,
    DARK,
    DECODED,
    DIFFERENCE,
    HIGHEST,
    LEVEL,
    LOWEST,
    PERIOD,
    POSITION,
    RIGHT,
    RING_ROWS,
    SATURATED,
    SECOND,
    SINE,
    SPREAD,
    TURN,
    UNKNOWN,
    UNREADABLE,
    VARIANCE,
)

# Displayed phase from the observed phase behind a nonlinear response. To N steps,
# harmonics m N +- 1 of a sinusoid look like the first one (Appendix A). Write the
# pattern as a cosine of psi. Then light is even in psi for any response and symmetric
# blur, and the steps add up to exp(i psi) f, f = 1 + r1 P* + r2 P*^2 + r3 P*^3, with
# P = exp(i N psi) and real r. The observed phase is psi + e, e = arg f. r1 is the share
# of harmonic N - 1 minus that of N + 1; to first order the two have the same effect.
# An asymmetric blur gives r1 an imaginary part. psi follows by Newton's method on P.


# Fields of Rows.work that are free while rows are read: r1 of each pixel, P, the
# current shift e, and the rate of psi relative to the observed phase.
SHARE, REAL, IMAGINARY, SHIFT, RATE = TURN, SPREAD, PERIOD, CELL_OFFSET, POSITION
# For a monotonic response psi + e increases with psi: by gamma 2.4 the rate is at least
# 0.27 (three steps). Noise can make it appear smaller.
MIN_RATE = np.float32(0.2)
MAX_STEP_RAD = np.float32(1)  # rotation of P in one of Newton's steps
RIPPLE_FAST = {"contract", "arcp"}  # fused multiply-add; x * (1 / y) for x / y
_RIPPLE_ONE, _TWO, _THREE = np.float32(1), np.float32(2), np.float32(3)
# arctan(q) / q as a polynomial in q^2, accurate to 6e-7 for |q| < 0.7. Beyond, f is not
# that of a response, and q is clipped.
_STEEPEST, _LEAST = np.float32(0.7), np.float32(0.1)
_ARCTAN = (0.99999092, -0.33293666, 0.19506967, -0.11675641, 0.04361909)
_ARCTAN = tuple(map(np.float32, _ARCTAN))  # type: ignore[assignment]
# cos a and sin a / a as polynomials in a^2, accurate to 3e-7 for |a| < 1.
_COSINE = tuple(map(np.float32, (1, -1 / 2, 1 / 24, -1 / 720, 1 / 40320)))
_SINE = tuple(map(np.float32, (1, -1 / 6, 1 / 120, -1 / 5040)))


@njit(cache=True, nogil=True, error_model="numpy", fastmath=RIPPLE_FAST)
def _rotation(angle):
    """Return (cos, sin) of a small angle."""
    z = angle * angle
    cosine = (((_COSINE[4] * z + _COSINE[3]) * z + _COSINE[2]) * z + _COSINE[1]) * z
    sine = ((_SINE[3] * z + _SINE[2]) * z + _SINE[1]) * z
    return _RIPPLE_ONE + cosine, angle * (_RIPPLE_ONE + sine)


@njit(cache=True, nogil=True, error_model="numpy", fastmath=RIPPLE_FAST)
def _arctan(q):
    z = q * q
    e = ((_ARCTAN[4] * z + _ARCTAN[3]) * z + _ARCTAN[2]) * z + _ARCTAN[1]
    return q * (e * z + _ARCTAN[0])


def origin(offset):
    """Return (2,) float32, exp(i psi) at phi = 0: psi = phi + 2 pi offset - pi / 2.

    offset: of the first step, in periods.
    """
    turn = 2 * np.pi * offset
    return np.float32(np.sin(turn)), np.float32(-np.cos(turn))


@njit(cache=True, nogil=True, error_model="numpy", fastmath=RIPPLE_FAST)
def _to_power(n, steps, start, waves, work):
    """Set REAL, IMAGINARY: P of the observed phase."""
    p, q = start
    for x in range(n):
        c, d = waves[COSINE + x], waves[SINE + x]
        work[REAL + x] = p * c - q * d
        work[IMAGINARY + x] = p * d + q * c
    bit = 1
    while 2 * bit <= steps:
        bit *= 2
    bit //= 2
    while bit:
        for x in range(n):
            a, b = work[REAL + x], work[IMAGINARY + x]
            work[REAL + x] = a * a - b * b
            work[IMAGINARY + x] = _TWO * a * b
        if steps & bit:
            for x in range(n):
                a, b = work[REAL + x], work[IMAGINARY + x]
                c, d = waves[COSINE + x], waves[SINE + x]
                c, d = p * c - q * d, p * d + q * c
                work[REAL + x] = a * c - b * d
                work[IMAGINARY + x] = a * d + b * c
        bit //= 2


@njit(cache=True, nogil=True, error_model="numpy", fastmath=RIPPLE_FAST)
def _improve(n, steps, terms, work):
    """Take one step of Newton's method for SHIFT = e(psi), psi = phi - SHIFT."""
    skew, second, third = terms
    many = np.float32(steps)
    for x in range(n):
        share = work[SHARE + x]
        c, s = work[REAL + x], work[IMAGINARY + x]
        c2, s2 = c * c - s * s, _TWO * c * s
        c3, s3 = c * c2 - s * s2, c * s2 + s * c2
        # (share + i skew) P* and the other terms; and each times its order.
        a1, b1 = share * c + skew * s, skew * c - share * s
        a2, b2 = second * c2, -second * s2
        a3, b3 = third * c3, -third * s3
        real = max(_RIPPLE_ONE + a1 + a2 + a3, _LEAST)
        imaginary = b1 + b2 + b3
        up, across = a1 + _TWO * a2 + _THREE * a3, b1 + _TWO * b2 + _THREE * b3
        size = real * real + imaginary * imaginary
        slope = _RIPPLE_ONE - many * (up * real + across * imaginary) / size
        rate = _RIPPLE_ONE / max(slope, MIN_RATE)
        tangent = min(max(imaginary / real, -_STEEPEST), _STEEPEST)
        step = (_arctan(tangent) - work[SHIFT + x]) * rate
        step = min(max(step, -MAX_STEP_RAD / many), MAX_STEP_RAD / many)
        work[SHIFT + x] += step
        work[RATE + x] = rate
        turned, aside = _rotation(many * step)
        work[REAL + x] = c * turned + s * aside
        work[IMAGINARY + x] = s * turned - c * aside


@njit(cache=True, nogil=True, error_model="numpy", fastmath=RIPPLE_FAST)
def _turn_back(n, waves, work):
    for x in range(n):
        turned, aside = _rotation(work[SHIFT + x])
        sine, cosine = waves[SINE + x], waves[COSINE + x]
        waves[SINE + x] = sine * turned - cosine * aside
        waves[COSINE + x] = cosine * turned + sine * aside
        waves[VARIANCE + x] *= work[RATE + x] * work[RATE + x]


@njit(cache=True, nogil=True, error_model="numpy", fastmath=RIPPLE_FAST)
def undo_ripple(n, steps, start, times, terms, waves, work):
    """Rotate n unit vectors (cosine, sine) of phases back to the displayed phases.

    steps: N; start: `origin`; times: Newton's steps; terms: (imaginary part of r1, r2,
    r3) float32; waves, work: of a row, as `coding.Rows`, with the real part of r1 in
    SHARE. The variance of a phase is multiplied by RATE squared.
    """
    _to_power(n, steps, start, waves, work)
    work[SHIFT : SHIFT + n] = 0
    for _ in range(times):
        _improve(n, steps, terms, work)
    _turn_back(n, waves, work)


# Pixels are dark below so many standard deviations of the noise.
MIN_CONTRAST = np.float32(7.0)
MIN_MODULATION = np.float32(5.0)
# Cosine of more than a quarter of a period; not quite 0 because of rounding.
OPPOSITE_COSINE = np.float32(-1e-6)
# Where the last bit does not matter: approximate 1 / sqrt, fused multiply-add.
FAST = {"arcp", "contract"}
_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)
_TINY, _FOUR = np.float32(1e-20), np.float32(4)
_FAINTEST, _WEAKEST = MIN_CONTRAST**2, MIN_MODULATION**2
_TURN = np.float32(1 / (2 * np.pi) ** 2)  # squared turns per squared radian


@njit(cache=True, nogil=True, error_model="numpy")
def _read_bit(light, dark, axis, k, rows):
    """Add one bit to the cell, and set the difference between image and inverse."""
    codes, greys = rows.codes, rows.greys
    for x in range(len(light)):
        one = light[x] > dark[x]
        # Written values have the type of grey values, so that arrays stay short.
        greys[axis, k, DIFFERENCE + x] = (
            light[x] - dark[x] if one else dark[x] - light[x]
        )
        difference = greys[axis, k, DIFFERENCE + x]
        lowest, second = greys[axis, k, LOWEST + x], greys[axis, k, SECOND + x]
        highest = greys[axis, k, HIGHEST + x]
        higher = lowest if difference < lowest else difference
        greys[axis, k, LOWEST + x] = difference if difference < lowest else lowest
        greys[axis, k, SECOND + x] = higher if higher < second else second
        greys[axis, k, HIGHEST + x] = difference if difference > highest else highest
    # Loops over arrays of one type are twice as fast.
    for x in range(len(light)):
        code = codes[axis, k, x]
        codes[axis, k, x] = 2 * code + ((code & 1) ^ (light[x] > dark[x]))


@njit(cache=True, nogil=True, error_model="numpy")
def _read_gray(images, y, strip, pairs, axis, k, rows):
    """Read the Gray code: the cell, and the differences between images and inverses.

    Missing differences have the largest value of the type.
    """
    n, greys = strip.width, rows.greys[axis, k]
    columns = slice(strip.start, strip.start + n)
    distant = np.iinfo(greys.dtype).max
    rows.codes[axis, k, :n] = 0
    greys[LOWEST : LOWEST + n] = distant
    greys[SECOND : SECOND + n] = distant
    for bit in range(len(pairs)):
        light, dark = (
            images[pairs[bit, 0], y, columns],
            images[pairs[bit, 1], y, columns],
        )
        _read_bit(light, dark, axis, k, rows)


@njit(cache=True, nogil=True, error_model="numpy")
def _take_cells(cells, axis, k, rows):
    """Copy cells from phase unwrapping, and mark where they are unknown."""
    codes, marks = rows.codes, rows.marks
    for x in range(len(cells)):
        codes[axis, k, x] = cells[x]
    for x in range(len(cells)):
        marks[k, BAD + x] = UNREADABLE if cells[x] == UNKNOWN else marks[k, BAD + x]


@njit(cache=True, nogil=True, error_model="numpy")
def _weigh(images, y, strip, steps, weights, out):
    """Set out (n,) float32: a weighted sum of the steps, two at a time."""
    begun, columns = False, slice(strip.start, strip.start + strip.width)
    for k in range(0, len(steps), 2):
        p, q = weights[k], weights[k + 1]
        if p == _ZERO and q == _ZERO:
            break
        a, b = images[steps[k], y, columns], images[steps[k + 1], y, columns]
        if begun:
            for x in range(len(out)):
                out[x] += p * np.float32(a[x]) + q * np.float32(b[x])
        else:
            for x in range(len(out)):
                out[x] = p * np.float32(a[x]) + q * np.float32(b[x])
        begun = True


@njit(cache=True, nogil=True, error_model="numpy")
def _join_highest(axis, k, n, rows):
    greys = rows.greys
    for x in range(n):
        one, other = greys[0, k, HIGHEST + x], greys[axis, k, HIGHEST + x]
        greys[0, k, HIGHEST + x] = other if other > one else one


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_saturated(images, y, strip, steps, white, k, rows):
    columns, marks = slice(strip.start, strip.start + strip.width), rows.marks
    for step in range(0, len(steps), 2):
        a, b = images[steps[step], y, columns], images[steps[step + 1], y, columns]
        for x in range(len(a)):
            full = (a[x] >= white) | (b[x] >= white)
            marks[k, BAD + x] = SATURATED if full else marks[k, BAD + x]


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_code(axis, k, n, noise, rows):
    """Mark dark pixels (low contrast) and unreadable ones (two edges at a position)."""
    (floor, slope, lowest), work, greys, marks = (
        noise,
        rows.work,
        rows.greys,
        rows.marks,
    )
    for x in range(n):
        contrast = np.float32(greys[0, k, HIGHEST + x])
        second = np.float32(greys[axis, k, SECOND + x])
        bad = UNREADABLE if _FOUR * second < contrast else marks[k, BAD + x]
        variance = max(floor + slope * work[axis, LEVEL + x], lowest)
        bad = DARK if contrast * contrast < _FAINTEST * variance else bad
        marks[k, BAD + x] = bad


@njit(cache=True, nogil=True, error_model="numpy", fastmath=FAST)
def _to_unit_length(axis, k, n, spread, noise, rows):
    """Divide sine and cosine by the modulation, and set the variance of the phase.

    A pixel is dark where the modulation is small compared with its noise.
    spread: variance of the modulation in that of a grey value.
    """
    (floor, slope, lowest), work, waves, marks = (
        noise,
        rows.work,
        rows.waves,
        rows.marks,
    )
    for x in range(n):
        sine, cosine = waves[axis, k, SINE + x], waves[axis, k, COSINE + x]
        strength = sine * sine + cosine * cosine + _TINY
        share = _ONE / np.sqrt(strength)
        waves[axis, k, SINE + x] = share * sine
        waves[axis, k, COSINE + x] = share * cosine
        variance = spread * max(floor + slope * work[axis, LEVEL + x], lowest)
        waves[axis, k, VARIANCE + x] = _TURN * variance * (share * share)
        weak = strength < _WEAKEST * variance
        marks[k, BAD + x] = DARK if weak else marks[k, BAD + x]


@njit(cache=True, nogil=True, error_model="numpy")
def _undo_response(axis, y, k, strip, ripples, rows):
    """Correct phases for the response; y: row of the image."""
    n, steps, share = strip.width, ripples.steps[axis], ripples.share[axis]
    if not steps:
        return
    across, down = ripples.across, np.float32(y) * ripples.down - _ONE
    level = share[0] + down * (share[2] + down * share[5])
    slope, bend = share[1] + down * share[4], share[3]
    waves, work = rows.waves[axis, k], rows.work[axis]
    for x in range(n):
        right = np.float32(strip.start + x) * across - _ONE
        work[SHARE + x] = level + right * (slope + right * bend)
    skew, second, third = ripples.terms[axis]
    terms = skew, second, third
    start = ripples.origin[axis, 0], ripples.origin[axis, 1]
    undo_ripple(n, steps, start, ripples.times[axis], terms, waves, work)


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_breaks_right(axis, k, n, jump, rows):
    """Mark breaks: phases that differ by more than a quarter of a period.

    Also cells that differ by more than `jump`.
    """
    waves, codes, marks = rows.waves, rows.codes, rows.marks
    for x in range(n - 1):
        sines = waves[axis, k, SINE + x] * waves[axis, k, SINE + x + 1]
        cosines = waves[axis, k, COSINE + x] * waves[axis, k, COSINE + x + 1]
        difference = abs(np.int32(codes[axis, k, x]) - np.int32(codes[axis, k, x + 1]))
        marks[k, RIGHT + x] |= (sines + cosines < OPPOSITE_COSINE) | (difference > jump)


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_breaks_below(axis, k, after, n, jump, rows):
    """Mark breaks as `_mark_breaks_right`, with the next row."""
    waves, codes, marks = rows.waves, rows.codes, rows.marks
    for x in range(n):
        sines = waves[axis, k, SINE + x] * waves[axis, after, SINE + x]
        cosines = waves[axis, k, COSINE + x] * waves[axis, after, COSINE + x]
        difference = abs(np.int32(codes[axis, k, x]) - np.int32(codes[axis, after, x]))
        marks[k, BELOW + x] |= (sines + cosines < OPPOSITE_COSINE) | (difference > jump)


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_bad_right(k, n, marks):
    for x in range(n - 1):
        marks[k, RIGHT + x] = (marks[k, BAD + x] != 0) | (marks[k, BAD + x + 1] != 0)
    marks[k, RIGHT + n - 1] = 1  # the image's border


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_bad_below(k, after, n, marks):
    for x in range(n):
        marks[k, BELOW + x] = (marks[k, BAD + x] != 0) | (marks[after, BAD + x] != 0)


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_crossed(k, n, marks):
    for x in range(n):
        crossed = (marks[k, RIGHT + x] != 0) | (marks[k, BELOW + x] != 0)
        marks[k, CROSSED + x] = crossed


@njit(cache=True, nogil=True, error_model="numpy")
def _mean_row(light, dark, out):
    for x in range(len(out)):
        out[x] = _HALF * (np.float32(light[x]) + np.float32(dark[x]))


@njit(cache=True, nogil=True, error_model="numpy")
def _read_row(images, y, top, strip, plan, white, noise, ripples, rows):
    """Set everything that a row's own pixels determine."""
    n, k, marks = strip.width, y % RING_ROWS, rows.marks
    count, columns = len(plan.bits), slice(strip.start, strip.start + n)
    rows.greys[:, k, HIGHEST : HIGHEST + n] = 0
    marks[k, BAD : BAD + n] = DECODED
    for axis in range(count):
        bits, used = plan.bits[axis], plan.used[axis]
        level = rows.work[axis, LEVEL : LEVEL + n]
        if bits:
            _read_gray(images, y, strip, plan.pairs[axis, :bits], axis, k, rows)
        elif plan.unwrapped[axis]:
            _take_cells(plan.orders[axis, y, columns], axis, k, rows)
        if axis:
            _join_highest(axis, k, n, rows)
        if used:
            own, share = plan.steps[axis, :, :used], plan.weights[axis]
            sine = rows.waves[axis, k, SINE : SINE + n]
            cosine = rows.waves[axis, k, COSINE : COSINE + n]
            _weigh(images, y, strip, own[0], share[0], sine)
            _weigh(images, y, strip, own[1], share[1], cosine)
            _weigh(images, y, strip, own[2], share[2], level)
        else:
            light, dark = plan.pairs[axis, 0]
            _mean_row(images[light, y, columns], images[dark, y, columns], level)
    for axis in range(count):
        used = plan.used[axis]
        if plan.bits[axis]:
            _mark_code(axis, k, n, noise, rows)
        if used:
            _to_unit_length(axis, k, n, plan.spread[axis], noise, rows)
            _undo_response(axis, top + y, k, strip, ripples, rows)
            own = plan.steps[axis, 2, :used]
            _mark_saturated(images, y, strip, own, white, k, rows)
    _mark_bad_right(k, n, marks)
    for axis in range(count):
        _mark_breaks_right(axis, k, n, plan.jump[axis], rows)


@njit(cache=True, nogil=True, error_model="numpy")
def _close_row(y, is_last, n, plan, rows):
    """Mark breaks between rows y and y + 1, and any break next to a pixel."""
    k, after, marks = y % RING_ROWS, (y + 1) % RING_ROWS, rows.marks
    if is_last:
        marks[k, BELOW : BELOW + n] = 1
    else:
        _mark_bad_below(k, after, n, marks)
        for axis in range(len(plan.bits)):
            _mark_breaks_below(axis, k, after, n, plan.jump[axis], rows)
    _mark_crossed(k, n, marks)


@njit(cache=True, nogil=True, error_model="numpy")
def read_rows(images, part, strip, plan, white, noise, ripples, rows):
    """Read rows of a stack of images (n, H, W) into the row buffers.

    part: (first, stop, top): rows of the stack; the row before `first` was read before,
    unless `first` is the first one; and the image row where the stack begins. strip:
    Strip; plan: CodePlan; white: the grey level from which a phase step counts as
    saturated; noise: a Noise in float32; ripples: Ripples; rows:
    Rows.
    """
    first, stop, top = part
    height, n = images.shape[1], strip.width
    if first == 0:
        rows.marks[-1, BELOW : BELOW + n] = 1  # above the first row is a break
    for y in range(first, stop):
        _read_row(images, y, top, strip, plan, white, noise, ripples, rows)
    for y in range(max(first - 1, 0), stop - 1):
        _close_row(y, False, n, plan, rows)
    if stop == height:
        _close_row(stop - 1, True, n, plan, rows)
