"""What each row of an active grid's pictures says by itself, in compiled loops.

Loops over few arrays of one type are compiled to run on many pixels at once. Arithmetic
on grey values is in whole numbers where they are, or in float32 with one rounding for
each operation. What these functions call stands in this file: compiled code is kept
from run to run, and made again when this file changes, not when another one does.
"""

import numpy as np
from numba import njit

from raxel.features.active_grid.layout import (
    DARK,
    DECODED,
    ROWS_A_PIECE,
    SATURATED,
    UNREADABLE,
)

# A pixel is dark below so many standard deviations of its noise.
LEAST_CONTRAST = np.float32(7.0)
LEAST_MODULATION = np.float32(5.0)
# The cosine of what is more than a quarter of a turn; not quite 0, as it is rounded.
APART = np.float32(-1e-6)
_ZERO, _HALF, _ONE = np.float32(0), np.float32(0.5), np.float32(1)
_TINY, _FOUR = np.float32(1e-20), np.float32(4)
_FAINTEST, _WEAKEST = LEAST_CONTRAST**2, LEAST_MODULATION**2
_TURN = np.float32(1 / (2 * np.pi) ** 2)  # squared turns in a squared radian


@njit(cache=True, nogil=True, error_model="numpy")
def _read_gray(images, part, pairs, apart, code, least, second, most):
    """Gray code: the cell, and how far apart pictures and inverses are.

    least, second, most: the smallest, second smallest and largest distance, the largest
    value there is where there are not so many; the last one is of all axes and not
    begun anew.
    """
    distant = np.iinfo(apart.dtype).max
    code[:] = 0
    least[:] = distant
    second[:] = distant
    for k in range(len(pairs)):
        light, dark = images[pairs[k, 0], part], images[pairs[k, 1], part]
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
def _weigh(images, part, steps, weights, out):
    """out (W,) float32: a weighted sum of the steps, two at a time."""
    begun = False
    for k in range(0, len(steps), 2):
        p, q = weights[k], weights[k + 1]
        if p == _ZERO and q == _ZERO:
            break
        a, b = images[steps[k], part], images[steps[k + 1], part]
        if begun:
            for x in range(len(out)):
                out[x] += p * np.float32(a[x]) + q * np.float32(b[x])
        else:
            for x in range(len(out)):
                out[x] = p * np.float32(a[x]) + q * np.float32(b[x])
        begun = True


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_saturated(images, part, steps, white, bad):
    for k in range(0, len(steps), 2):
        a, b = images[steps[k], part], images[steps[k + 1], part]
        for x in range(len(bad)):
            full = (a[x] >= white) | (b[x] >= white)
            bad[x] = SATURATED if full else bad[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_weak(level, floor, slope, least, spread, strength, bad):
    """Dark is where the modulation is small beside its noise of floor + slope level.

    strength, its square, becomes the variance of the phase; spread: times that of a
    grey value, the variance of the modulation.
    """
    for x in range(len(bad)):
        noise = spread * max(floor + slope * level[x], least)
        bad[x] = DARK if strength[x] < _WEAKEST * noise else bad[x]
        strength[x] = _TURN * noise / strength[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_code(level, second, most, floor, slope, least, bad):
    """Dark is too little contrast; two edges at one place are no Gray code."""
    for x in range(len(bad)):
        contrast = np.float32(most[x])
        bad[x] = UNREADABLE if _FOUR * second[x] < contrast else bad[x]
        noise = max(floor + slope * level[x], least)
        bad[x] = DARK if contrast * contrast < _FAINTEST * noise else bad[x]


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
def _mark_breaks(sine, cosine, code, sine2, cosine2, code2, jump, broken):
    """Where the phases of two neighbours are more than a quarter of a turn apart.

    Or their cells more than `jump`.
    """
    for x in range(len(broken)):
        along = sine[x] * sine2[x] + cosine[x] * cosine2[x]
        apart = abs(np.int32(code[x]) - np.int32(code2[x]))
        broken[x] |= (along < APART) | (apart > jump)


@njit(cache=True, nogil=True, error_model="numpy")
def _either(first, second, out):
    for x in range(len(out)):
        out[x] = (first[x] != 0) | (second[x] != 0)


@njit(cache=True, nogil=True, error_model="numpy")
def _read_piece(images, y, count, plan, white, noise, rows):
    """All that the own pixels of some rows say, into the rows kept, in one piece."""
    width, k = rows.bad.shape[1], y % len(rows.bad)
    piece, size = slice(k * width, (k + count) * width), count * width
    images, part = images.reshape(len(images), -1), slice(y * width, y * width + size)
    most, bad, beside = rows.most, rows.bad, rows.beside
    most, bad = most.reshape(-1)[piece], bad.reshape(-1)[piece]
    most[:] = 0
    bad[:] = DECODED
    for axis in range(len(plan.bits)):
        bits, used, level = plan.bits[axis], plan.used[axis], rows.level[axis, :size]
        if bits:
            code = rows.code[axis].reshape(-1)[piece]
            least = rows.least[axis].reshape(-1)[piece]
            far = rows.apart[:size], code, least, rows.second[axis, :size], most
            _read_gray(images, part, plan.pairs[axis, :bits], *far)
        if used:
            own, share = plan.steps[axis, :, :used], plan.weights[axis]
            sine = rows.sine[axis].reshape(-1)[piece]
            cosine = rows.cosine[axis].reshape(-1)[piece]
            _weigh(images, part, own[0], share[0], sine)
            _weigh(images, part, own[1], share[1], cosine)
            _weigh(images, part, own[2], share[2], level)
            _to_unit_length(sine, cosine, rows.variance[axis].reshape(-1)[piece])
        else:
            light, dark = plan.pairs[axis, 0]
            _mean_row(images[light, part], images[dark, part], level)
    for axis in range(len(plan.bits)):
        bits, used, level = plan.bits[axis], plan.used[axis], rows.level[axis, :size]
        if bits:
            _mark_code(level, rows.second[axis, :size], most, *noise, bad)
        if used:
            strength = rows.variance[axis].reshape(-1)[piece]
            _mark_weak(level, *noise, plan.spread[axis], strength, bad)
            _mark_saturated(images, part, plan.steps[axis, 2, :used], white, bad)
    # Breaks to the right; the picture's border is one.
    to_right = beside.reshape(-1)[piece][:-1]
    _either(bad[:-1], bad[1:], to_right)
    for axis in range(len(plan.bits)):
        s = rows.sine[axis].reshape(-1)[piece]
        c = rows.cosine[axis].reshape(-1)[piece]
        code = rows.code[axis].reshape(-1)[piece]
        here, after = (s[:-1], c[:-1], code[:-1]), (s[1:], c[1:], code[1:])
        _mark_breaks(*here, *after, plan.jump[axis], to_right)
    beside[k : k + count, -1] = 1


@njit(cache=True, nogil=True, error_model="numpy")
def _mean_row(light, dark, out):
    for x in range(len(out)):
        out[x] = _HALF * (np.float32(light[x]) + np.float32(dark[x]))


@njit(cache=True, nogil=True, error_model="numpy")
def _break_below(y, is_last, plan, rows):
    """Breaks between rows y and y + 1, and with them where a window is crossed."""
    k, after = y % len(rows.bad), (y + 1) % len(rows.bad)
    below = rows.below[k]
    if is_last:
        below[:] = 1
    else:
        _either(rows.bad[k], rows.bad[after], below)
        for axis in range(len(plan.bits)):
            s, c, code = rows.sine[axis], rows.cosine[axis], rows.code[axis]
            here, there = (s[k], c[k], code[k]), (s[after], c[after], code[after])
            _mark_breaks(*here, *there, plan.jump[axis], below)
    _either(rows.beside[k], below, rows.crossed[k])


@njit(cache=True, nogil=True, error_model="numpy")
def read_rows(images, first, stop, plan, white, noise, rows):
    """Read rows of a stack of pictures (n, H, W) into the rows kept.

    first, stop: rows of the stack; the one before `first` is known, unless it is the
    first that is read. plan: CodePlan; white: the value from which a phase step counts
    as saturated, of the pictures' type; noise: a Noise in float32, of the variance
    in grey levels; rows: Rows.
    """
    height = images.shape[1]
    if first == 0:
        rows.below[-1] = 1  # above the first row is a break
    y, kept = first, len(rows.bad)
    while y < stop:
        count = min(ROWS_A_PIECE, stop - y, kept - y % kept)
        _read_piece(images, y, count, plan, white, noise, rows)
        y += count
    for y in range(max(first - 1, 0), stop - 1):
        _break_below(y, False, plan, rows)
    if stop == height:
        _break_below(stop - 1, True, plan, rows)
