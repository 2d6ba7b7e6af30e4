"""Errors of decoded positions: noise, blur, bias, bends and folds.

Where a surface is folded: places go on without a jump, but by another step.

Facets of a mirror that meet edge to edge show it, and so do caustics, where places turn
round. A window and a blur of variance s^2 together put a fold, where the step changes
by d per px, off by s d / sqrt(2 pi). On one surface, however bent, the second
difference of places over some pixels lies between those beside it, or nearly so. At a
fold it does not, and says how large d is.
"""

from itertools import product
from typing import NamedTuple

import cv2
import numpy as np
from numba import njit
from scipy.special import erfinv, ndtri

from raxel.features.active_grid.coding import REACH, SQUARE, UNKNOWN
from raxel.features.active_grid.lines import undone
from raxel.features.active_grid.reading import MIN_MODULATION

# The noise of images, from the images: variance against grey level.


SAMPLES = 120_000  # pixels looked at, in rows all over the images
LEVELS = 16
MIN_IN_LEVEL = 500
QUANTISATION = 1 / 12  # variance of rounding to whole grey levels
# The median of |x| of a normal law with standard deviation 1.
MEDIAN = 0.6744897501960817
# Of the sum of squares of (1 -2 1) by (1 -2 1).
GAIN = 36.0


class Noise(NamedTuple):
    """Variance of a grey value of level I: floor + slope I, grey levels squared.

    It is nowhere below `least`. Where black is a level above 0, as in raw images, the
    floor is that much slope lower, and may be below 0.
    """

    floor: float
    slope: float = 0.0
    least: float = 0.0

    def at(self, level):
        """The variance at grey levels of any shape."""
        return np.maximum(self.floor + self.slope * level, self.least)


def estimate_noise(images, white):
    """The Noise of images (H, W), a list of them, by the values that are not clipped.

    White noise is taken for granted. The second difference along rows of the second
    difference along columns is blind to stripes of any shape along either, as an active
    grid shows; medians are blind to the edges that remain.
    """
    height, width = images[0].shape
    if height < 3 or width < 3:
        return Noise(QUANTISATION)
    rows = min(height - 2, max(1, SAMPLES // (width * len(images))))
    middle = 1 + (np.arange(rows) * (height - 2)) // rows
    levels, responses = [], []
    kind = np.uint16 if images[0].dtype == np.uint8 else np.uint32
    for image in images:
        three = [image[middle + d].astype(np.int32) for d in (-1, 0, 1)]
        clipped = [(row == 0) | (row >= white) for row in three]
        clipped = clipped[0] | clipped[1] | clipped[2]
        clipped = clipped[:, :-2] | clipped[:, 1:-1] | clipped[:, 2:]
        down = three[0] - 2 * three[1] + three[2]
        response = down[:, :-2] - 2 * down[:, 1:-1] + down[:, 2:]
        level = (three[0] + three[2])[:, 1:-1] // 2
        # Whole numbers so short are sorted in linear time.
        levels.append(level[~clipped].astype(image.dtype))
        responses.append(np.abs(response[~clipped]).astype(kind))
    return _fitted(np.concatenate(levels), np.concatenate(responses))


def _fitted(levels, responses):
    if len(levels) < MIN_IN_LEVEL:
        return Noise(QUANTISATION)
    order = np.argsort(levels, kind="stable")
    parts = np.array_split(order, min(LEVELS, len(order) // MIN_IN_LEVEL))
    level = np.array([levels[part].mean() for part in parts])
    spread = [_median(responses[part]) / MEDIAN for part in parts]
    variance = np.maximum(np.square(spread) / GAIN, QUANTISATION)
    # The relative error of each is alike, but that of the darkest, where the edge of
    # the lit area mixes levels.
    weight = 1 / np.maximum(variance, variance.mean() / 8)
    basis = np.column_stack([np.ones_like(level), level]) * weight[:, None]
    floor, slope = np.linalg.lstsq(basis, variance * weight, rcond=None)[0]
    if slope < 0 or len(parts) == 1:
        floor, slope = len(level) / np.sum(1 / variance), 0.0
    return Noise(float(floor), float(slope), QUANTISATION)


def _median(whole):
    """The median of whole numbers, each taken as spread over its unit."""
    below = np.sort(whole, kind="stable" if whole.dtype == np.uint16 else None)
    at = int(below[len(below) // 2])
    low, high = np.searchsorted(below, (at, at + 1))
    share = (len(whole) / 2 - low) / max(high - low, 1)
    return max(at - 0.5 + share, 0.0) if at else max(share / 2, 0.0)


# How blurred a view is, from the edges of its own Gray code. An image less its
# inverse goes from minus to plus the contrast across an edge, as the error function
# does where lens, focus and monitor blur it like a Gaussian. Its slope says how wide
# that is, wherever the edge lies. A tone curve that is concave, as files of cameras
# have, makes the blur look up to half as wide again; one like an S, which is steepest
# in the middle, by its steepness there too narrow.


# Of the contrast: by how much an image and its inverse together change where one of
# them is covered and its bit turned over; at an edge behind a tone curve 0.6 at most.
TURNED = 0.75
BLUR_SAMPLES = 10_000  # pixels looked at for edges, all over the image
REACH_PX = 12  # of the patch around an edge
SMOOTHED_PX = 1.5  # against noise; taken off again
OF_DIFFERENCES = 1 / 3  # variance, px^2, that differences over two pixels add
NEAR_EDGE = 0.5  # of the contrast
TOO_FINE = 0.7  # share of a patch near edges: they flow together
CLEAR, MIN_SHARE = 10, 0.2  # contrast in deviations of the noise, and of the usual
AREAS = 3  # along each side of the image, each with a blur of its own
EDGES = 6  # of each area
MIN_PIXELS = 100  # of an area, or of the whole image where no area has so many
DARK_BELOW = 7  # deviations of the noise: contrasts that the decoder takes for none
FARTHEST = 3  # standard deviations of the blur, beyond which there is no light


class Blur(NamedTuple):
    """Standard deviation px of the blur of a view, in the worst ninth of the image.

    beyond_px: so far beyond the rim of the lit area there is light enough to decode.
    """

    px: float
    beyond_px: float = 0.0

    def margins(self, smooth):
        """(2,) px: from where there is no light, and from jumps, to sound pixels."""
        reach = REACH * bool(smooth) + FARTHEST * self.px
        return int(np.ceil(reach + self.beyond_px)), int(np.ceil(reach))


class _Edges(NamedTuple):
    """E places beside an edge of one bit: that bit, and another with full contrast
    there; (row, column) before the edge and step (rows, columns) to one behind it;
    area of the image."""

    bit: np.ndarray
    other: np.ndarray
    place: np.ndarray
    step: np.ndarray
    area: np.ndarray


def measured_blur(stack, noise):
    """The Blur of a view, or None where too few edges of Gray code are seen.

    stack: a PictureStack; noise: a Noise.
    """
    pairs = [pair for code in stack.codes for pair in code.bits]
    if not pairs or min(stack.shape) <= 2 * REACH_PX:
        return None
    step = max(4, round(np.sqrt(np.prod(stack.shape) / BLUR_SAMPLES)))
    coarse = np.s_[step // 2 :: step, step // 2 :: step]
    apart = np.array([stack.apart(pair, coarse) for pair in pairs])
    light = stack.images[pairs[0][0]][coarse].astype(np.float32)
    contrast = np.abs(apart).max(axis=0)
    dark = light - (apart[0] + contrast) / 2
    lit = contrast > CLEAR * np.sqrt(noise.at(dark))
    if not lit.any():
        return None
    lit &= contrast > MIN_SHARE * np.quantile(contrast[lit], 0.9)
    usual, dark = np.median(contrast[lit]), np.median(dark[lit])
    edges = _edges(apart, lit, step)
    if not len(edges.bit):
        return None
    spread, edge = _spread(stack, pairs, edges, MIN_SHARE * usual)
    parts = (spread[edges.area[edge] == k] for k in range(AREAS * AREAS))
    medians = [np.median(own) for own in parts if len(own) >= MIN_PIXELS]
    if not medians and len(spread) < MIN_PIXELS:
        return None
    widest = max(medians) if medians else np.median(spread)
    blur = float(np.sqrt(max(widest - SMOOTHED_PX**2 - OF_DIFFERENCES, 0)))
    share = np.clip(DARK_BELOW * np.sqrt(noise.at(dark)) / usual, 1e-3, 0.5)
    return Blur(blur, -blur * float(ndtri(share)))


def _edges(apart, lit, step):
    """Some edges in each area; apart: (bits, h, w), every `step` px; lit: (h, w)."""
    light, strength, found = apart > 0, np.abs(apart), []
    for down, right in ((0, 1), (1, 0)):
        first = np.s_[: len(lit) - down, : lit.shape[1] - right]
        both = lit[first] & lit[down:, right:]
        changed = light[:, *first] != light[:, down:, right:]
        bit, v, u = np.nonzero(changed & both)
        found.append([bit, v, u, np.full(len(bit), down), np.full(len(bit), right)])
    bit, v, u, down, right = np.concatenate(found, axis=1)
    strength = strength[:, v, u]
    strength[bit, np.arange(len(bit))] = -1
    area = AREAS * (AREAS * v // lit.shape[0]) + AREAS * u // lit.shape[1]
    place, steps = step // 2 + step * np.stack([v, u]), step * np.stack([down, right])
    kept = []
    for k in range(AREAS * AREAS):
        own = np.flatnonzero(area == k)
        kept.append(own[:: -(-len(own) // EDGES) or 1])
    kept = np.concatenate(kept)
    every = bit, strength.argmax(axis=0), place, steps, area
    return _Edges(*(array[..., kept] for array in every))


def _apart(values, pairs, bit, v, u):
    """Pictures less inverses of bits (E,) at rows v and columns u, (E, ...) float32.

    values: `PictureStack.apart`, or `together`, NaN where there is no inverse.
    """
    out = np.full(np.broadcast_shapes(v.shape, u.shape), np.nan, np.float32)
    for k in np.unique(bit):
        own = bit == k
        found = values(pairs[k], (v[own], u[own]))
        if found is not None:
            out[own] = found
    return out


def _spread(stack, pairs, edges, least):
    """(P,) squared width px^2 at pixels near edges, and the edge of each.

    least: contrast, all over the patch around an edge.
    """
    walk = np.arange(edges.step.max(initial=0) + 1)
    line = edges.place[..., None] + np.sign(edges.step)[..., None] * walk
    values = _apart(stack.apart, pairs, edges.bit, *line)
    crossed = np.argmax((values > 0) != (values[:, :1] > 0), axis=1)
    middle = edges.place + np.sign(edges.step) * crossed
    middle = [
        np.clip(at, REACH_PX, size - 1 - REACH_PX)
        for at, size in zip(middle, stack.shape, strict=True)
    ]
    around = np.arange(-REACH_PX, REACH_PX + 1)
    v, u = (at[:, None] + around for at in middle)
    where = v[:, :, None], u[:, None, :]
    own = _apart(stack.apart, pairs, edges.bit, *where)
    most = np.maximum(
        np.abs(own), np.abs(_apart(stack.apart, pairs, edges.other, *where))
    )
    # Patches one below the other; what they give each other is left out with the rim.
    share = (own / np.maximum(most, 1)).reshape(-1, len(around))
    share = cv2.GaussianBlur(share, (0, 0), SMOOTHED_PX).reshape(own.shape)
    rim = 1 + round(3 * SMOOTHED_PX)
    near = np.abs(share[:, rim:-rim, rim:-rim]) < NEAR_EDGE
    whole = (most > least).all(axis=(1, 2))
    # Where something covers one image, it and its inverse are alike without an edge.
    light = [_apart(stack.together, pairs, n, *where) for n in (edges.bit, edges.other)]
    off = cv2.blur((light[0] - light[1]).reshape(-1, len(around)), (3, 3))
    whole &= ~(np.abs(off.reshape(own.shape)) > TURNED * most).any(axis=(1, 2))
    whole &= np.mean(near, axis=(1, 2)) < TOO_FINE
    edge, y, x = np.nonzero(near & whole[:, None, None])
    y, x = y + rim, x + rim
    right = (share[edge, y, x + 1] - share[edge, y, x - 1]) / 2
    down = (share[edge, y + 1, x] - share[edge, y - 1, x]) / 2
    steepest = np.sqrt(2 / np.pi) * np.exp(-(erfinv(share[edge, y, x]) ** 2))
    return steepest**2 / (right**2 + down**2 + 1e-12), edge


# By how much averaging over pixels shifts a phase that bends. A mean of a phase phi
# over a symmetric window or blur of variance s^2 (px^2, along each axis of the
# image) is off by s^2 / 2 times the sum of phi's second derivatives. Where
# perspective or a curved mirror bends the phases, that is no noise, and smoothing
# does not take it away. A blur of variance s^2 mixes light, not phases, and draws
# them to where more of it comes from: by s^2 times the slope of phi along that of the
# logarithm of the modulation.


OF_WINDOWS, OF_NEIGHBOURS = 4.0, 2 / 3  # variances of 7 x 7 and 3 x 3 pixels, px^2
HALF, QUARTER = SQUARE // 2, SQUARE // 4
# A bias of several standard deviations has the same sign all around: with 1.08 times
# it, 65 to 80 % of errors are within one where it is 1 to 10 of them; with the bias
# itself it is half of them.
OF_SIGMA = 1.08
FRAME = 2  # squares around the image, of which nothing is known
# Second differences over HALF px in periods: above is a break; below is no jump.
MAX_BENT, MIN_JUMP = 0.15, 0.02
# Over QUARTER px bending is a fourth of it. What departs from that by such a share, and
# by so many standard deviations, is none.
UNLIKE, BEYOND = 0.5, 4


def squared_bias(images, codes, of_windows, blur_px, spread, ripples, orders=None):
    """(A, ceil(H / SQUARE), W) float32, squared periods: a row for each row of squares.

    images: n images (H, W); codes: A AxisCodes; of_windows: variance px^2 of what is
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
    frame = (0, 1) if axis else (1, 0)  # the image's border: nothing is known there
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
    for image, inverse in code.bits:
        other = mean if inverse is None else images[inverse][around[0]]
        value = value ^ (images[image][around[0]] > other)
        cell = 2 * cell + value
    if code.others:
        cell = orders[around[0]].astype(int)
    of_cell = (cell + 0.5) * code.cell / code.period
    known &= cell != UNKNOWN
    return np.ceil(of_cell - turn - 0.5) + turn, np.abs(wave), known


def _shares_of(shape, where):
    """x and y from -1 to 1 of an index (rows, columns) into images."""
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


# Where places bend within a few pixels: the bias of windows and blur at each pixel.
# `bias` knows it for squares of the image, before anything is decoded. A mirror
# that curves strongly, or whose surface ripples, changes its bending within a square.
# Second differences of the decoded places over some pixels tell it there; near the
# rim of what is decoded, those of the nearest pixels that have them.


HALF_BEND = 8  # px, beyond a window, so that what noise does to each place is its own
# Of a place's variance, that of the sum of both second differences.
BENDS_OF_NOISE = np.float32(4 + 4**2)
# Times that, two to three deviations: less is what noise makes of flat surfaces, and
# would widen sigma where errors are large.
BENDS_BEYOND = np.float32(4)
_NO_BEND, _ONE = np.float32(0), np.float32(1)


@njit(cache=True, nogil=True, error_model="numpy")
def _wider(off, known, by_noise, spread):
    """A sigma (minus: marked) with the bias `off` as far as it is more than is known
    (squared), and than noise makes of it."""
    own = spread * spread
    more = off * off - known - by_noise * own
    # Not so where one of the places is not known, which is NaN.
    clear = more / (BENDS_BEYOND * by_noise * own) - _ONE
    clear = min(clear, _ONE) if clear > _NO_BEND else _NO_BEND
    wider = np.sqrt(own + (clear * more if clear > _NO_BEND else _NO_BEND))
    return -wider if spread < _NO_BEND else wider


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest_bend(at, y, x, down, right):
    """Second difference over (down, right) px, or so far before or behind the pixel
    where it is not known there; 0 where it is not known at all."""
    height, width = at.shape
    for shift in (0, 1, -1):
        v, u = y + (shift - 1) * down, x + (shift - 1) * right
        if v < 0 or u < 0 or v + 2 * down >= height or u + 2 * right >= width:
            continue
        ends = at[v, u] + at[v + 2 * down, u + 2 * right]
        bend = ends - 2 * at[v + down, u + right]
        if not np.isnan(bend):
            return bend
    return _NO_BEND


@njit(cache=True, nogil=True, error_model="numpy")
def _widen_inside(at, y, gain, of_noise, known, spread):
    """A row of pixels, where places about each are decoded."""
    here, above, below = at[y], at[y - HALF_BEND], at[y + HALF_BEND]
    for x in range(HALF_BEND, len(here) - HALF_BEND):
        across = here[x - HALF_BEND] + here[x + HALF_BEND]
        off = gain * (across + above[x] + below[x] - 4 * here[x])
        spread[x] = _wider(off, known[x], of_noise, spread[x])


@njit(cache=True, nogil=True, error_model="numpy")
def _widen_at_rims(at, y, gain, of_noise, known, spread):
    """A row of pixels, where some place about them is not decoded."""
    height, width = at.shape
    inside = HALF_BEND <= y < height - HALF_BEND
    for x in range(width):
        if np.isnan(at[y, x]):
            continue
        if inside and HALF_BEND <= x < width - HALF_BEND:
            across = at[y, x - HALF_BEND] + at[y, x + HALF_BEND]
            if not np.isnan(across + at[y - HALF_BEND, x] + at[y + HALF_BEND, x]):
                continue
        bend = _nearest_bend(at, y, x, 0, HALF_BEND) + _nearest_bend(
            at, y, x, HALF_BEND, 0
        )
        spread[x] = _wider(gain * bend, known[x], of_noise, spread[x])


@njit(cache=True, nogil=True, error_model="numpy")
def widen_at_bends(location, sigma, bias, plan, share, start, stop):
    """Let sigma (A, H, W) hold the bias of windows and blur, rows start to stop.

    location: (A, H, W), NaN where not decoded; bias: `bias.squared_bias`, which sigma
    holds already; share: half the variance of what is averaged, px^2. sigma may be
    marked by a minus sign.
    """
    height = location.shape[1]
    gain = np.float32(share * OF_SIGMA / HALF_BEND**2)
    by_noise = gain * gain * BENDS_OF_NOISE
    for axis in range(len(location)):
        if not plan.used[axis]:
            continue
        at, squared = location[axis], plan.length[axis] * plan.length[axis]
        for y in range(start, min(stop, height)):
            known, spread = squared * bias[axis, y // SQUARE], sigma[axis, y]
            if HALF_BEND <= y < height - HALF_BEND:
                _widen_inside(at, y, gain, by_noise, known, spread)
            _widen_at_rims(at, y, gain, by_noise, known, spread)


@njit(cache=True, nogil=True, error_model="numpy")
def share_noise(sigma, bias, length, shared):
    """Multiply what noise has in sigma (A, H, W) by shared (A,), but not the bias.

    bias: `bias.squared_bias`; length: (A,) of a period. sigma may be marked by a minus
    sign.
    """
    for axis in range(len(sigma)):
        more = shared[axis] * shared[axis] - 1
        squared = more * length[axis] * length[axis]
        for y in range(sigma.shape[1]):
            spread, known = sigma[axis, y], bias[axis, y // SQUARE]
            for x in range(len(spread)):
                own = spread[x] * spread[x]
                wider = np.sqrt(own + more * own - squared * known[x])
                spread[x] = -wider if spread[x] < _NO_BEND else wider


HALF_FOLD = 8  # px; of a second difference, which lies 2 HALF from those beside it
# Variance, in that of a place, of such a difference less the mean of those beside it.
OF_PLACES = 7.0
# Three standard deviations of it; sigma that noise has widened does no harm.
OF_NOISE = np.float32(3 * np.sqrt(OF_PLACES))
BENT = np.float32(0.5)  # of those beside: a smooth surface may depart so much
# Differences that scatter more than noise lets them, by noise that neighbours share or
# by ripples, do so far from folds as well, where they are least: a quarter of those of
# a normal law are within 0.3186. Rows that are looked at for it.
ROWS, MANY, PART, OF_PART = 64, 100, 0.25, 0.3186
_ZERO, _HALF = np.float32(0), np.float32(0.5)


def scatter_of_places(location, sigma, used):
    """(A,) float32: standard deviations of places over stated ones, 1 at least.

    location, sigma: (A, H, W), NaN where not decoded; used: (A,), 0 without phases.
    """
    height, width = location.shape[1:]
    scatter = np.ones(len(used), np.float32)
    rows, last = slice(None, None, -(-height // ROWS)), max(width - 6 * HALF_FOLD, 0)
    for axis in np.flatnonzero(used):
        p = [
            location[axis, rows, k : k + last]
            for k in range(0, 7 * HALF_FOLD, HALF_FOLD)
        ]
        apart = 2 * p[3] - (p[2] + p[4]) / 2 - p[1] - p[5] + (p[0] + p[6]) / 2
        apart = np.abs(apart / sigma[axis, rows, 3 * HALF_FOLD : 3 * HALF_FOLD + last])
        known = apart[np.isfinite(apart)]
        if len(known) > MANY:
            usual = np.quantile(known, PART) / OF_PART / np.sqrt(OF_PLACES)
            scatter[axis] = max(1.0, usual)
    return scatter


@njit(cache=True, nogil=True, error_model="numpy")
def _fold_beyond(a, b, c, d, e, f, g, out):
    """Raise out (n,) to by how much the second difference of (n,) places c, d, e is
    beyond those of a, b, c and e, f, g and what it may be; NaN counts as nothing."""
    for x in range(len(out)):
        left, right = a[x] - 2 * b[x] + c[x], e[x] - 2 * f[x] + g[x]
        own = c[x] - 2 * d[x] + e[x]
        low = left if left < right else right
        high = right if left < right else left
        above, under = own - high, low - own
        off = above if above > under else under
        off -= BENT * _HALF * (abs(left) + abs(right))
        out[x] = off if off > out[x] else out[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _widen(spread, off, limit, gain):
    """Widen spread (n,), which may be marked by a minus sign, where off is too far."""
    for x in range(len(off)):
        far = off[x] if off[x] > limit * abs(spread[x]) else _ZERO
        wider = np.sqrt(spread[x] * spread[x] + gain * far * far)
        spread[x] = -wider if spread[x] < _ZERO else wider


@njit(cache=True, nogil=True, error_model="numpy")
def widen_at_folds(location, sigma, scatter, used, share, start, stop):
    """Let sigma (A, H, W) hold what windows and blur do to folds, rows start to stop.

    scatter: as `scatter_of_places`; share: by how much a place is off at a fold, of
    what its second difference is. sigma may be marked by a minus sign.
    """
    height, width = location.shape[1:]
    reach, gain = 3 * HALF_FOLD, np.float32((share * OF_SIGMA) ** 2)
    off, n = np.empty(width, np.float32), width - 6 * HALF_FOLD
    for axis in range(len(location)):
        if not used[axis]:
            continue
        p, limit = location[axis], OF_NOISE * scatter[axis]
        for y in range(start, min(stop, height)):
            off[:] = _ZERO
            if n > 0:
                r = p[y]
                left, right = (
                    (r[:n], r[HALF_FOLD:], r[2 * HALF_FOLD :]),
                    (r[4 * HALF_FOLD :], r[5 * HALF_FOLD :], r[6 * HALF_FOLD :]),
                )
                _fold_beyond(*left, r[reach:], *right, off[reach : reach + n])
            if reach <= y < height - reach:
                above = p[y - reach], p[y - 2 * HALF_FOLD], p[y - HALF_FOLD]
                below = p[y + HALF_FOLD], p[y + 2 * HALF_FOLD], p[y + reach]
                _fold_beyond(*above, p[y], *below, off)
            _widen(sigma[axis, y], off, limit, gain)


def share_at_folds(variance):
    """By how much a place is off at a fold, of what its second difference is.

    variance: of windows and blur together, px^2. The difference itself is less by twice
    that; blur of more than it spans is none that is decoded.
    """
    off = np.sqrt(variance / (2 * np.pi))
    return float(off / max(HALF_FOLD - 2 * off, HALF_FOLD / 4))
