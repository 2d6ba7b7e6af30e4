"""By how much averaging over pixels shifts a phase that bends.

A mean of a phase phi over a symmetric window or blur of variance s^2 (px^2, along each
axis of the picture) is off by s^2 / 2 times the sum of phi's second derivatives. Where
perspective or a curved mirror bends the phases, that is no noise, and smoothing does
not take it away. A blur of variance s^2 mixes light, not phases, and draws them to
where more of it comes from: by s^2 times the slope of phi along that of the logarithm
of the modulation.
"""

from itertools import product

import numpy as np

from raxel.features.active_grid.layout import SQUARE, UNKNOWN
from raxel.features.active_grid.reading import MIN_MODULATION
from raxel.features.active_grid.undoing import undone

OF_WINDOWS, OF_NEIGHBOURS = 4.0, 2 / 3  # variances of 7 x 7 and 3 x 3 pixels, px^2
HALF, QUARTER = SQUARE // 2, SQUARE // 4
# A bias of several standard deviations has the same sign all around: with 1.08 times
# it, 65 to 80 % of errors are within one where it is 1 to 10 of them; with the bias
# itself it is half of them.
OF_SIGMA = 1.08
FRAME = 2  # squares around the picture, of which nothing is known
# Second differences over HALF px in periods: above is a break; below is no jump.
MAX_BENT, MIN_JUMP = 0.15, 0.02
# Over QUARTER px bending is a fourth of it. What departs from that by such a share, and
# by so many standard deviations, is none.
UNLIKE, BEYOND = 0.5, 4


def squared_bias(images, codes, of_windows, blur_px, spread, ripples, orders=None):
    """(A, ceil(H / SQUARE), W) float32, squared periods: a row for each row of squares.

    images: n pictures (H, W); codes: A AxisCodes; of_windows: variance px^2 of what is
    averaged; blur_px: standard deviation; spread: of a grey value, by noise; ripples:
    A `response.Ripple`; orders: as of CodePlan, where sines tell of periods.
    """
    height, width = images[0].shape
    bias = np.zeros((len(codes), -(-height // SQUARE), -(-width // SQUARE)), np.float32)
    if min(bias.shape[1:]) > 2 and (of_windows or blur_px):
        settings = spread, of_windows, blur_px**2
        found = {
            axis: _shifts(
                images,
                (code, ripples[axis], orders[axis] if code.others else None),
                *settings,
            )
            for axis, code in enumerate(codes)
            if code.steps
        }
        # A jump of what is seen may not show along one of them.
        known = np.all([one for _, one, _ in found.values()], axis=0)
        for axis, (shift, _, chance) in found.items():
            # What lies in no whole square goes on as those beside.
            left = [(0, n - m) for n, m in zip(bias[0].shape, shift.shape, strict=True)]
            filled = _filled(np.pad(shift, left), np.pad(known, left))
            bias[axis] = np.maximum(np.square(OF_SIGMA * filled) - chance, 0)
    return np.ascontiguousarray(np.repeat(bias, SQUARE, axis=2)[:, :, :width])


def _shifts(images, coding, spread, of_windows, of_blur):
    """(h, w) periods by which places in whole squares are off, and which are known.

    Places in the middle of a square and of its sides give the derivatives. Also the
    variance of what noise alone would give.
    """
    rows, columns = (size // SQUARE for size in images[0].shape)
    code = coding[0]
    least = MIN_MODULATION * spread
    middle, upright, level = (
        _seen_places(images, coding, _every_square(first, count), least)
        for first, count in (
            ((HALF, HALF), (rows, columns)),
            ((HALF, SQUARE), (rows, columns - 1)),
            ((SQUARE, HALF), (rows - 1, columns)),
        )
    )
    sd = spread / np.sqrt(2 * len(code.steps)) / (2 * np.pi * middle[1].clip(1e-6))
    shift, known, usual_step = np.zeros((rows, columns)), middle[2], 0.0
    for axis, sides in ((1, upright), (0, level)):
        bent, step, brighter, there = _across(middle, sides, axis)
        # Few squares are so far from flat.
        asked = np.nonzero(there & (np.abs(bent) > MIN_JUMP))
        near = [
            _seen_places(images, coding, _near_middles(asked, axis, away), least)
            for away in (-QUARTER, QUARTER)
        ]
        there[asked] = near[0][2] & near[1][2]
        over_quarter = near[0][0] + near[1][0] - 2 * middle[0][asked]
        there[asked] &= _alike(bent[asked], over_quarter, sd[asked])
        known = known & there
        shift += (of_windows + of_blur) / 2 * bent / HALF**2
        shift += of_blur * step * brighter / SQUARE**2
        usual_step += np.median(step[known] ** 2) if known.any() else 0.0
    if not known.any():
        return shift, known, 0.0
    # Of the phase and, in shares, the modulation of 2 x 2 pixels, rad^2.
    variance = spread**2 / (2 * len(code.steps) * np.median(middle[1][known]) ** 2)
    # Of the five places of the second derivatives the middle one counts four times.
    of_bending = 20 * ((of_windows + of_blur) / 2 / HALF**2) ** 2 / (2 * np.pi) ** 2
    of_drawing = 2 * (of_blur / SQUARE**2) ** 2 * usual_step
    return shift, known, variance * (of_bending + of_drawing)


def _across(middle, sides, axis):
    """From side to side of each square: the second difference of places over HALF px,
    the first one, that of the logarithm of the modulation, and what is known."""
    frame = (0, 1) if axis else (1, 0)  # the picture's border: nothing is known there
    place, size, known = (_framed(values, *frame) for values in sides)
    bent = _first(place, axis) + _last(place, axis) - 2 * middle[0]
    shares = np.maximum(_last(size, axis), 1e-6) / np.maximum(_first(size, axis), 1e-6)
    known = _first(known, axis) & _last(known, axis) & (np.abs(bent) < MAX_BENT)
    # Over twice the distance, bending is four times as much, and a jump the same.
    far, beside = _framed(middle[0], *frame), _framed(middle[2], *frame)
    before, behind = _first(_first(far, axis), axis), _last(_last(far, axis), axis)
    jump = np.abs(before + behind - 2 * middle[0]) < 2 * np.abs(bent)
    jump &= _first(_first(beside, axis), axis) & _last(_last(beside, axis), axis)
    known &= ~(jump & (np.abs(bent) > MIN_JUMP))
    return bent, _last(place, axis) - _first(place, axis), np.log(shares), known


def _alike(bent, near, sd):
    """Where second differences over HALF and QUARTER px are of one bent surface.

    sd: of a place.
    """
    # Of the five places the middle one counts -2 + 8 times, the near ones 4 times.
    limit = UNLIKE * np.abs(bent) + BEYOND * np.sqrt(70) * sd
    return np.abs(bent - 4 * near) < limit


def _first(values, axis):
    """All but the last of each column or row."""
    return values[:, :-1] if axis else values[:-1]


def _last(values, axis):
    return values[:, 1:] if axis else values[1:]


def _every_square(first, count):
    """Of 2 x 2 pixels that meet, SQUARE px apart both ways, the indices of each.

    first, count: (row, column) of where the first meet, and how many.
    """
    return [
        tuple(
            slice(begin - back, begin - back + SQUARE * (n - 1) + 1, SQUARE)
            for begin, back, n in zip(first, step, count, strict=True)
        )
        for step in product((1, 0), repeat=2)
    ]


def _near_middles(squares, axis, away):
    """The same, `away` px along an axis from the middles of some squares."""
    middles = SQUARE * np.array(squares) + HALF
    middles[axis] += away
    return [
        tuple(middles - np.reshape(step, (2, 1))) for step in product((1, 0), repeat=2)
    ]


def _seen_places(images, coding, around, least):
    """Places in periods, modulation, and what is known.

    coding: an AxisCode, its Ripple, and its cells where sines tell of these. around:
    four indices of pixels, whose mean is taken. A bit without an inverse is compared
    with the mean of the steps.
    """
    code, ripple, orders = coding
    count = images[0][around[0]].shape
    wave, mean = np.zeros(count, complex), np.zeros(count, np.float32)
    sine, cosine, _ = code.sines.weights
    for k, weight in zip(code.steps, cosine + 1j * sine, strict=True):
        light = sum(images[k][part].astype(np.float32) for part in around)
        wave += weight / len(around) * light
        mean += light / (len(around) * len(code.steps))
    known = np.abs(wave) > least
    wave = undone(ripple, wave, *_shares_of(images[0].shape, around[-1]))
    turn = np.angle(wave) / (2 * np.pi) % 1
    value, cell = np.zeros(count, bool), np.zeros(count, int)
    for picture, inverse in code.bits:
        other = mean if inverse is None else images[inverse][around[0]]
        value = value ^ (images[picture][around[0]] > other)
        cell = 2 * cell + value
    if code.others:
        cell = orders[around[0]].astype(int)
    of_cell = (cell + 0.5) * code.cell / code.period
    known &= cell != UNKNOWN
    return np.ceil(of_cell - turn - 0.5) + turn, np.abs(wave), known


def _shares_of(shape, where):
    """x and y from -1 to 1 of an index (rows, columns) into pictures."""
    rows, columns = (
        np.linspace(-1, 1, size)[n] for size, n in zip(shape, where, strict=True)
    )
    if isinstance(where[0], slice):
        return np.broadcast_arrays(columns, rows[:, None])
    return columns, rows


def _filled(values, known):
    """Squares that are not known go on as their neighbours do, twice; or 0.

    Along each line through two that are known, else as those beside.
    """
    for _ in range(2):
        sums, count = np.zeros((2, *values.shape)), np.zeros((2, *values.shape))
        framed = _framed(values, FRAME, FRAME), _framed(known, FRAME, FRAME)
        for step in product((-1, 0, 1), repeat=2):
            if step != (0, 0):
                one, two = (_moved(*framed, n, step) for n in (1, 2))
                both = one[1] & two[1]
                sums += np.where([one[1], both], [one[0], 2 * one[0] - two[0]], 0)
                count += [one[1], both]
        means = sums / count.clip(1)
        values = np.where(known, values, np.where(count[1] > 0, means[1], means[0]))
        known = known | (count[0] > 0)
    return values


def _framed(values, rows, columns):
    """With so many more of zeros on all sides."""
    height, width = values.shape
    framed = np.zeros((height + 2 * rows, width + 2 * columns), values.dtype)
    framed[rows : rows + height, columns : columns + width] = values
    return framed


def _moved(values, known, times, step):
    """Both framed arrays without their frames, so many steps (rows, columns) away."""
    part = tuple(
        slice(FRAME + times * n, size - FRAME + times * n)
        for n, size in zip(step, values.shape, strict=True)
    )
    return values[part], known[part]
