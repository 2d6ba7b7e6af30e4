"""Errors of decoded positions: noise, blur, bias, bends and folds.

Fold: positions continue without a jump, but with another step. Facets of a mirror that
meet edge to edge and caustics, where positions reverse, have folds. A window and a blur
with total variance s^2 shift a position at a fold by s d / sqrt(2 pi), where the step
changes by d per px. On a smooth surface the second difference of positions over some
pixels is between its neighbours, or nearly so. At a fold it is not, and gives d.
"""

from itertools import product
from typing import NamedTuple

import cv2
import numpy as np
from numba import njit
from scipy.special import erfinv, ndtri

from raxel.features.active_grid.coding import BLOCK_PX, UNKNOWN, WINDOW_RADIUS
from raxel.features.active_grid.lines import corrected_waves
from raxel.features.active_grid.reading import MIN_MODULATION

# The noise of images, estimated from the images: variance against grey level.


NOISE_SAMPLES = 120_000  # pixels, in rows all over the images
MIN_NOISE_ROWS = 4
NOISE_LEVELS = 16
MIN_N_PER_LEVEL = 500
QUANTISATION_VARIANCE = 1 / 12  # variance of rounding to whole grey levels
# The median of |x| of a normal distribution with standard deviation 1.
MEDIAN_PER_SIGMA = 0.6744897501960817
# Sum of squares of (1 -2 1) by (1 -2 1).
DIFFERENCE_GAIN = 36.0


class Noise(NamedTuple):
    """Model the variance of a grey value of level I: floor + slope I, squared levels.

    It is at least `minimum`. Where black has a level above 0, as in raw images, the
    floor is lower by slope times that level and may be below 0.
    """

    floor: float
    slope: float = 0.0
    minimum: float = 0.0

    def at(self, level):
        """Return the variance at grey levels of any shape."""
        return np.maximum(self.floor + self.slope * level, self.minimum)


def estimate_noise(images, white):
    """Return the Noise of a list of images (H, W), from values that are not clipped.

    White noise is assumed. The second difference along rows of the second difference
    along columns vanishes for stripes of any shape along either axis, as on an active
    grid. Medians are robust to the remaining edges.
    """
    height, width = images[0].shape
    if height < 3 or width < 3:
        return Noise(QUANTISATION_VARIANCE)
    rows = min(height - 2, max(MIN_NOISE_ROWS, NOISE_SAMPLES // (width * len(images))))
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
        # Short integers are sorted in linear time.
        levels.append(level[~clipped].astype(image.dtype))
        responses.append(np.abs(response[~clipped]).astype(kind))
    return _fitted(np.concatenate(levels), np.concatenate(responses))


def _fitted(levels, responses):
    if len(levels) < MIN_N_PER_LEVEL:
        return Noise(QUANTISATION_VARIANCE)
    order = np.argsort(levels, kind="stable")
    parts = np.array_split(order, min(NOISE_LEVELS, len(order) // MIN_N_PER_LEVEL))
    level = np.array([levels[part].mean() for part in parts])
    spread = [_median(responses[part]) / MEDIAN_PER_SIGMA for part in parts]
    variance = np.maximum(np.square(spread) / DIFFERENCE_GAIN, QUANTISATION_VARIANCE)
    # All have about the same relative error except the darkest, where the edge of
    # the lit area mixes levels.
    weight = 1 / np.maximum(variance, variance.mean() / 8)
    basis = np.column_stack([np.ones_like(level), level]) * weight[:, None]
    floor, slope = np.linalg.lstsq(basis, variance * weight, rcond=None)[0]
    if slope < 0 or len(parts) == 1:
        floor, slope = len(level) / np.sum(1 / variance), 0.0
    return Noise(float(floor), float(slope), QUANTISATION_VARIANCE)


def _median(whole):
    """Return the median of integers, each spread uniformly over its unit."""
    below = np.sort(whole, kind="stable" if whole.dtype == np.uint16 else None)
    at = int(below[len(below) // 2])
    low, high = np.searchsorted(below, (at, at + 1))
    share = (len(whole) / 2 - low) / max(high - low, 1)
    return max(at - 0.5 + share, 0.0) if at else max(share / 2, 0.0)


# Blur of a view, from the edges of its own Gray code. An image minus its inverse goes
# from minus to plus the contrast across an edge, as the error function where lens,
# focus and monitor act as a Gaussian blur. The slope gives the width, wherever the edge
# is. A concave tone curve, as in camera files, makes the blur appear up to 50 % wider.
# An S-shaped curve, steepest in the middle, makes it appear narrower.


# Change of image plus inverse, as a share of the contrast, where one of them is
# occluded and its bit inverted; at an edge behind a tone curve it is at most 0.6.
MAX_INVERTED_SHARE = 0.75
BLUR_SAMPLES = 10_000  # pixels searched for edges, all over the image
PATCH_RADIUS_PX = 12  # of the patch around an edge
SMOOTHING_PX = 1.5  # against noise; subtracted from the result
DIFFERENCE_VARIANCE = 1 / 3  # variance, px^2, that differences over two pixels add
EDGE_CONTRAST = 0.5  # share of the contrast
MAX_EDGE_SHARE = 0.7  # of a patch near edges: more of them merge
# Contrast in standard deviations of the noise, and as a share of the usual one.
MIN_CONTRAST_SIGMAS, MIN_CONTRAST_SHARE = (10, 0.2)
AREAS_PER_SIDE = 3  # of the image; each area has its own blur
EDGES_PER_AREA = 6
MIN_N_PIXELS = 100  # of an area, or of the whole image where no area has so many
DARK_SIGMAS = 7  # standard deviations of the noise: the decoder's limit for dark pixels
BLUR_SIGMAS = 3  # standard deviations of the blur, the extent of its light


class Blur(NamedTuple):
    """Hold the standard deviation px of the blur in the worst ninth of the image.

    spill_px: distance outside the lit area with enough light to decode.
    """

    px: float
    spill_px: float = 0.0

    def margins(self, smooth):
        """Return (2,) px: distances from dark pixels and from jumps to valid pixels."""
        reach = WINDOW_RADIUS * bool(smooth) + BLUR_SIGMAS * self.px
        return int(np.ceil(reach + self.spill_px)), int(np.ceil(reach))


class _Edges(NamedTuple):
    """Hold E positions next to an edge of one bit.

    That bit, and another one with full contrast there; (row, column) before the edge
    and step (rows, columns) to a pixel after it; area of the image.
    """

    bit: np.ndarray
    other: np.ndarray
    position: np.ndarray
    step: np.ndarray
    area: np.ndarray


def measured_blur(stack, noise):
    """Return the Blur of a view, or None with too few edges of Gray code.

    stack: an ImageStack; noise: a Noise.
    """
    pairs = [pair for code in stack.codes for pair in code.bits]
    if not pairs or min(stack.shape) <= 2 * PATCH_RADIUS_PX:
        return None
    step = max(4, round(np.sqrt(np.prod(stack.shape) / BLUR_SAMPLES)))
    coarse = np.s_[step // 2 :: step, step // 2 :: step]
    difference = np.array([stack.difference(pair, coarse) for pair in pairs])
    light = stack.images[pairs[0][0]][coarse].astype(np.float32)
    contrast = np.abs(difference).max(axis=0)
    dark = light - (difference[0] + contrast) / 2
    lit = contrast > MIN_CONTRAST_SIGMAS * np.sqrt(noise.at(dark))
    if not lit.any():
        return None
    lit &= contrast > MIN_CONTRAST_SHARE * np.quantile(contrast[lit], 0.9)
    usual, dark = np.median(contrast[lit]), np.median(dark[lit])
    edges = _edges(difference, lit, step)
    if not len(edges.bit):
        return None
    spread, edge = _spread(stack, pairs, edges, MIN_CONTRAST_SHARE * usual)
    parts = (
        spread[edges.area[edge] == k] for k in range(AREAS_PER_SIDE * AREAS_PER_SIDE)
    )
    medians = [np.median(own) for own in parts if len(own) >= MIN_N_PIXELS]
    if not medians and len(spread) < MIN_N_PIXELS:
        return None
    widest = max(medians) if medians else np.median(spread)
    blur = float(np.sqrt(max(widest - SMOOTHING_PX**2 - DIFFERENCE_VARIANCE, 0)))
    share = np.clip(DARK_SIGMAS * np.sqrt(noise.at(dark)) / usual, 1e-3, 0.5)
    return Blur(blur, -blur * float(ndtri(share)))


def _edges(difference, lit, step):
    """Return edges of each area; difference: (bits, h, w), every `step` px."""
    light, strength, found = difference > 0, np.abs(difference), []
    for down, right in ((0, 1), (1, 0)):
        first = np.s_[: len(lit) - down, : lit.shape[1] - right]
        both = lit[first] & lit[down:, right:]
        changed = light[:, *first] != light[:, down:, right:]
        bit, v, u = np.nonzero(changed & both)
        found.append([bit, v, u, np.full(len(bit), down), np.full(len(bit), right)])
    bit, v, u, down, right = np.concatenate(found, axis=1)
    strength = strength[:, v, u]
    strength[bit, np.arange(len(bit))] = -1
    area = (
        AREAS_PER_SIDE * (AREAS_PER_SIDE * v // lit.shape[0])
        + AREAS_PER_SIDE * u // lit.shape[1]
    )
    position, steps = (
        step // 2 + step * np.stack([v, u]),
        step * np.stack([down, right]),
    )
    kept = []
    for k in range(AREAS_PER_SIDE * AREAS_PER_SIDE):
        own = np.flatnonzero(area == k)
        kept.append(own[:: -(-len(own) // EDGES_PER_AREA) or 1])
    kept = np.concatenate(kept)
    every = bit, strength.argmax(axis=0), position, steps, area
    return _Edges(*(array[..., kept] for array in every))


def _bit_values(values, pairs, bit, v, u):
    """Return values of bits (E,) at rows v and columns u, (E, ...) float32.

    values: `ImageStack.difference`, or `total`, NaN without an inverse.
    """
    out = np.full(np.broadcast_shapes(v.shape, u.shape), np.nan, np.float32)
    for k in np.unique(bit):
        own = bit == k
        found = values(pairs[k], (v[own], u[own]))
        if found is not None:
            out[own] = found
    return out


def _spread(stack, pairs, edges, minimum):
    """Return (P,) squared width px^2 at pixels near edges, and the edge of each.

    minimum: contrast, everywhere in the patch around an edge.
    """
    walk = np.arange(edges.step.max(initial=0) + 1)
    line = edges.position[..., None] + np.sign(edges.step)[..., None] * walk
    values = _bit_values(stack.difference, pairs, edges.bit, *line)
    crossed = np.argmax((values > 0) != (values[:, :1] > 0), axis=1)
    middle = edges.position + np.sign(edges.step) * crossed
    middle = [
        np.clip(at, PATCH_RADIUS_PX, size - 1 - PATCH_RADIUS_PX)
        for at, size in zip(middle, stack.shape, strict=True)
    ]
    around = np.arange(-PATCH_RADIUS_PX, PATCH_RADIUS_PX + 1)
    v, u = (at[:, None] + around for at in middle)
    where = v[:, :, None], u[:, None, :]
    own = _bit_values(stack.difference, pairs, edges.bit, *where)
    strongest = np.maximum(
        np.abs(own), np.abs(_bit_values(stack.difference, pairs, edges.other, *where))
    )
    # Patches are stacked vertically; their mutual influence is excluded with the
    # border.
    share = (own / np.maximum(strongest, 1)).reshape(-1, len(around))
    share = cv2.GaussianBlur(share, (0, 0), SMOOTHING_PX).reshape(own.shape)
    border = 1 + round(3 * SMOOTHING_PX)
    near = np.abs(share[:, border:-border, border:-border]) < EDGE_CONTRAST
    whole = (strongest > minimum).all(axis=(1, 2))
    # Where one image is occluded, it and its inverse are equal without an edge.
    light = [
        _bit_values(stack.total, pairs, n, *where) for n in (edges.bit, edges.other)
    ]
    deviation = cv2.blur((light[0] - light[1]).reshape(-1, len(around)), (3, 3))
    whole &= ~(
        np.abs(deviation.reshape(own.shape)) > MAX_INVERTED_SHARE * strongest
    ).any(axis=(1, 2))
    whole &= np.mean(near, axis=(1, 2)) < MAX_EDGE_SHARE
    edge, y, x = np.nonzero(near & whole[:, None, None])
    y, x = y + border, x + border
    right = (share[edge, y, x + 1] - share[edge, y, x - 1]) / 2
    down = (share[edge, y + 1, x] - share[edge, y - 1, x]) / 2
    steepest = np.sqrt(2 / np.pi) * np.exp(-(erfinv(share[edge, y, x]) ** 2))
    return steepest**2 / (right**2 + down**2 + 1e-12), edge


# Bias of averaging where a phase bends. The mean of a phase phi over a symmetric window
# or blur of variance s^2 (px^2, along each image axis) has an error of s^2 / 2 times
# the sum of phi's second derivatives. Where perspective or a curved mirror bends the
# phases, this error is not noise, and smoothing does not remove it. A blur mixes light,
# not phases. It shifts a phase towards the brighter side, by s^2 times the slope of phi
# times that of the logarithm of the modulation.


# Variances of 7 x 7 and 3 x 3 pixels, px^2.
WINDOW_VARIANCE, NEIGHBOUR_VARIANCE = (4.0, 2 / 3)
HALF_BLOCK_PX, QUARTER_BLOCK_PX = BLOCK_PX // 2, BLOCK_PX // 4
# A bias has the same sign in its neighbourhood. With 1.08 times the bias in sigma, 65
# to 80 % of the errors are within one sigma for a bias of 1 to 10 standard deviations;
# with the bias itself, half of them are.
BIAS_TO_SIGMA = 1.08
FRAME_BLOCKS = 2  # unknown blocks around the image
# Second differences over HALF_BLOCK_PX in periods: larger ones are breaks, smaller ones
# are not jumps.
MAX_CURVATURE, MIN_CURVATURE = 0.15, 0.02
# Over QUARTER_BLOCK_PX a second difference is a fourth. Where it differs from that by
# such a share and so many standard deviations, there is a break.
CURVATURE_TOL, CURVATURE_SIGMAS = 0.5, 4


def squared_bias(images, codes, of_windows, blur_px, spread, ripples, orders=None):
    """Return the squared bias, (A, ceil(H / BLOCK_PX), W) float32, squared periods.

    images: n images (H, W); codes: A AxisCodes; of_windows: variance px^2 of what is
    averaged; blur_px: standard deviation; spread: of a grey value, by noise; ripples:
    A `lines.Ripple`; orders: as in CodePlan, for phase unwrapping without Gray code.
    """
    height, width = images[0].shape
    bias = np.zeros(
        (len(codes), -(-height // BLOCK_PX), -(-width // BLOCK_PX)), np.float32
    )
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
        # A jump of the surface may be invisible along one axis.
        known = np.all([one for _, one, _ in found.values()], axis=0)
        for axis, (shift, _, chance) in found.items():
            # Partial blocks at the border take the values of their neighbours.
            left = [(0, n - m) for n, m in zip(bias[0].shape, shift.shape, strict=True)]
            filled = _filled(np.pad(shift, left), np.pad(known, left))
            bias[axis] = np.maximum(np.square(BIAS_TO_SIGMA * filled) - chance, 0)
    return np.ascontiguousarray(np.repeat(bias, BLOCK_PX, axis=2)[:, :, :width])


def _shifts(images, coding, spread, of_windows, of_blur):
    """Return the errors (h, w) in periods of whole blocks, and which are known.

    Positions at the centre of a block and of its sides give the derivatives. Also
    return the variance that noise alone would give.
    """
    rows, columns = (size // BLOCK_PX for size in images[0].shape)
    code = coding[0]
    minimum = MIN_MODULATION * spread
    middle, upright, level = (
        _block_positions(images, coding, _every_square(first, count), minimum)
        for first, count in (
            ((HALF_BLOCK_PX, HALF_BLOCK_PX), (rows, columns)),
            ((HALF_BLOCK_PX, BLOCK_PX), (rows, columns - 1)),
            ((BLOCK_PX, HALF_BLOCK_PX), (rows - 1, columns)),
        )
    )
    sd = spread / np.sqrt(2 * len(code.steps)) / (2 * np.pi * middle[1].clip(1e-6))
    shift, known, usual_step = np.zeros((rows, columns)), middle[2], 0.0
    for axis, sides in ((1, upright), (0, level)):
        bent, step, brighter, there = _across(middle, sides, axis)
        # Few blocks are so strongly curved.
        selected = np.nonzero(there & (np.abs(bent) > MIN_CURVATURE))
        near = [
            _block_positions(
                images, coding, _near_centres(selected, axis, away), minimum
            )
            for away in (-QUARTER_BLOCK_PX, QUARTER_BLOCK_PX)
        ]
        there[selected] = near[0][2] & near[1][2]
        over_quarter = near[0][0] + near[1][0] - 2 * middle[0][selected]
        # Both second differences belong to one curved surface. Of the five positions
        # the middle one has weight -2 + 8, the near ones have 4.
        own = bent[selected]
        limit = CURVATURE_SIGMAS * np.sqrt(70) * sd[selected]
        there[selected] &= (
            np.abs(own - 4 * over_quarter) < CURVATURE_TOL * np.abs(own) + limit
        )
        known = known & there
        shift += (of_windows + of_blur) / 2 * bent / HALF_BLOCK_PX**2
        shift += of_blur * step * brighter / BLOCK_PX**2
        usual_step += np.median(step[known] ** 2) if known.any() else 0.0
    if not known.any():
        return shift, known, 0.0
    # Variance of the phase and of the relative modulation of 2 x 2 pixels, rad^2.
    variance = spread**2 / (2 * len(code.steps) * np.median(middle[1][known]) ** 2)
    # In the second derivatives the middle one of the five positions has weight four.
    of_bending = (
        20 * ((of_windows + of_blur) / 2 / HALF_BLOCK_PX**2) ** 2 / (2 * np.pi) ** 2
    )
    of_drawing = 2 * (of_blur / BLOCK_PX**2) ** 2 * usual_step
    return shift, known, variance * (of_bending + of_drawing)


def _across(middle, sides, axis):
    """Return differences from side to side of each block, and which are known.

    The second difference of positions over HALF_BLOCK_PX, the first one, and that of
    the logarithm of the modulation.
    """
    frame = (0, 1) if axis else (1, 0)  # the image's border is unknown
    position, size, known = (_framed(values, *frame) for values in sides)
    bent = _first(position, axis) + _last(position, axis) - 2 * middle[0]
    shares = np.maximum(_last(size, axis), 1e-6) / np.maximum(_first(size, axis), 1e-6)
    known = _first(known, axis) & _last(known, axis) & (np.abs(bent) < MAX_CURVATURE)
    # Over twice the distance a bend is four times as large, a jump equally large.
    far, both_known = _framed(middle[0], *frame), _framed(middle[2], *frame)
    before, after = _first(_first(far, axis), axis), _last(_last(far, axis), axis)
    jump = np.abs(before + after - 2 * middle[0]) < 2 * np.abs(bent)
    jump &= _first(_first(both_known, axis), axis) & _last(
        _last(both_known, axis), axis
    )
    known &= ~(jump & (np.abs(bent) > MIN_CURVATURE))
    return bent, _last(position, axis) - _first(position, axis), np.log(shares), known


def _first(values, axis):
    """Return all but the last column or row."""
    return values[:, :-1] if axis else values[:-1]


def _last(values, axis):
    return values[:, 1:] if axis else values[1:]


def _every_square(first, count):
    """Return indices of the 2 x 2 pixels at points BLOCK_PX apart along both axes.

    first, count: (row, column) of the first point, and the number of points.
    """
    return [
        tuple(
            slice(begin - back, begin - back + BLOCK_PX * (n - 1) + 1, BLOCK_PX)
            for begin, back, n in zip(first, step, count, strict=True)
        )
        for step in product((1, 0), repeat=2)
    ]


def _near_centres(squares, axis, away):
    """Return such indices `away` px along an axis from the centres of some blocks."""
    middles = BLOCK_PX * np.array(squares) + HALF_BLOCK_PX
    middles[axis] += away
    return [
        tuple(middles - np.reshape(step, (2, 1))) for step in product((1, 0), repeat=2)
    ]


def _block_positions(images, coding, around, minimum):
    """Return positions in periods, modulation, and which are known.

    coding: an AxisCode, its Ripple, and its cells by phase unwrapping. around: four
    indices of pixels, which are averaged. A bit without an inverse is compared with the
    mean of the steps.
    """
    code, ripple, orders = coding
    count = images[0][around[0]].shape
    wave, mean = np.zeros(count, complex), np.zeros(count, np.float32)
    sine, cosine, _ = code.sines.weights
    for k, weight in zip(code.steps, cosine + 1j * sine, strict=True):
        light = sum(images[k][part].astype(np.float32) for part in around)
        wave += weight / len(around) * light
        mean += light / (len(around) * len(code.steps))
    known = np.abs(wave) > minimum
    wave = corrected_waves(ripple, wave, *_shares_of(images[0].shape, around[-1]))
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
    """Return x and y from -1 to 1 of an index (rows, columns) into images."""
    rows, columns = (
        np.linspace(-1, 1, size)[n] for size, n in zip(shape, where, strict=True)
    )
    if isinstance(where[0], slice):
        return np.broadcast_arrays(columns, rows[:, None])
    return columns, rows


def _filled(values, known):
    """Extrapolate unknown blocks from their neighbours, in two rounds; 0 elsewhere.

    Along each line through two known blocks, else with the value of the neighbours.
    """
    for _ in range(2):
        sums, count = np.zeros((2, *values.shape)), np.zeros((2, *values.shape))
        framed = (
            _framed(values, FRAME_BLOCKS, FRAME_BLOCKS),
            _framed(known, FRAME_BLOCKS, FRAME_BLOCKS),
        )
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
    """Return the values with so many rows and columns of zeros on each side."""
    height, width = values.shape
    framed = np.zeros((height + 2 * rows, width + 2 * columns), values.dtype)
    framed[rows : rows + height, columns : columns + width] = values
    return framed


def _moved(values, known, times, step):
    """Return both framed arrays without frames, moved by so many (rows, columns)."""
    part = tuple(
        slice(FRAME_BLOCKS + times * n, size - FRAME_BLOCKS + times * n)
        for n, size in zip(step, values.shape, strict=True)
    )
    return values[part], known[part]


# Bias of windows and blur at each pixel where positions bend within a few pixels.
# `squared_bias` knows the bias of blocks before decoding. A strongly curved mirror, or
# one with surface ripples, changes its curvature within a block. There, second
# differences of decoded positions give the bias; near the border of the decoded area,
# those of the nearest pixels that have them.


# Px, wider than a window, so that the noise of the positions is independent.
BEND_STEP_PX = 8
# Variance of the sum of both second differences, in that of a position.
BEND_NOISE_VARIANCE = np.float32(4 + 4**2)
# In that unit, two to three standard deviations: noise makes smaller differences on
# flat surfaces, and they would widen sigma where errors are large.
MIN_BEND_RATIO = np.float32(4)
_NO_CURVATURE, _ONE = np.float32(0), np.float32(1)


@njit(cache=True, nogil=True, error_model="numpy")
def _wider(deviation, known, by_noise, spread):
    """Return sigma (negative: marked) with the part of a bias that is not yet known.

    Known (squared) bias and noise are subtracted from it.
    """
    own = spread * spread
    more = deviation * deviation - known - by_noise * own
    # NaN, an unknown position, leaves sigma as it is.
    clear = more / (MIN_BEND_RATIO * by_noise * own) - _ONE
    clear = min(clear, _ONE) if clear > _NO_CURVATURE else _NO_CURVATURE
    wider = np.sqrt(own + (clear * more if clear > _NO_CURVATURE else _NO_CURVATURE))
    return -wider if spread < _NO_CURVATURE else wider


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest_bend(at, y, x, down, right):
    """Return the second difference over (down, right) px at or next to a pixel.

    The neighbours are used where it is unknown at the pixel; 0 if all are unknown.
    """
    height, width = at.shape
    for shift in (0, 1, -1):
        v, u = y + (shift - 1) * down, x + (shift - 1) * right
        if v < 0 or u < 0 or v + 2 * down >= height or u + 2 * right >= width:
            continue
        ends = at[v, u] + at[v + 2 * down, u + 2 * right]
        bend = ends - 2 * at[v + down, u + right]
        if not np.isnan(bend):
            return bend
    return _NO_CURVATURE


@njit(cache=True, nogil=True, error_model="numpy")
def _widen_inside(at, y, gain, of_noise, known, spread):
    """Widen a row of pixels where the positions around are decoded."""
    here, above, below = at[y], at[y - BEND_STEP_PX], at[y + BEND_STEP_PX]
    for x in range(BEND_STEP_PX, len(here) - BEND_STEP_PX):
        across = here[x - BEND_STEP_PX] + here[x + BEND_STEP_PX]
        deviation = gain * (across + above[x] + below[x] - 4 * here[x])
        spread[x] = _wider(deviation, known[x], of_noise, spread[x])


@njit(cache=True, nogil=True, error_model="numpy")
def _widen_at_borders(at, y, gain, of_noise, known, spread):
    """Widen a row of pixels where some position around is not decoded."""
    height, width = at.shape
    inside = BEND_STEP_PX <= y < height - BEND_STEP_PX
    for x in range(width):
        if np.isnan(at[y, x]):
            continue
        if inside and BEND_STEP_PX <= x < width - BEND_STEP_PX:
            across = at[y, x - BEND_STEP_PX] + at[y, x + BEND_STEP_PX]
            if not np.isnan(across + at[y - BEND_STEP_PX, x] + at[y + BEND_STEP_PX, x]):
                continue
        bend = _nearest_bend(at, y, x, 0, BEND_STEP_PX) + _nearest_bend(
            at, y, x, BEND_STEP_PX, 0
        )
        spread[x] = _wider(gain * bend, known[x], of_noise, spread[x])


@njit(cache=True, nogil=True, error_model="numpy")
def widen_at_bends(location, sigma, bias, plan, share, start, stop):
    """Add the bias of windows and blur at bends to sigma (A, H, W), rows start to stop.

    location: (A, H, W), NaN where not decoded; bias: `squared_bias`, which sigma
    contains already; share: half the variance of what is averaged, px^2. sigma may be
    marked by a minus sign.
    """
    height = location.shape[1]
    gain = np.float32(share * BIAS_TO_SIGMA / BEND_STEP_PX**2)
    by_noise = gain * gain * BEND_NOISE_VARIANCE
    for axis in range(len(location)):
        if not plan.used[axis]:
            continue
        at, squared = location[axis], plan.length[axis] * plan.length[axis]
        for y in range(start, min(stop, height)):
            known, spread = squared * bias[axis, y // BLOCK_PX], sigma[axis, y]
            if BEND_STEP_PX <= y < height - BEND_STEP_PX:
                _widen_inside(at, y, gain, by_noise, known, spread)
            _widen_at_borders(at, y, gain, by_noise, known, spread)


@njit(cache=True, nogil=True, error_model="numpy")
def share_noise(sigma, bias, length, shared):
    """Multiply the noise in sigma (A, H, W) by shared (A,), but not the bias.

    bias: `squared_bias`; length: (A,) of a period. sigma may be marked by a minus sign.
    """
    for axis in range(len(sigma)):
        more = shared[axis] * shared[axis] - 1
        squared = more * length[axis] * length[axis]
        for y in range(sigma.shape[1]):
            spread, known = sigma[axis, y], bias[axis, y // BLOCK_PX]
            for x in range(len(spread)):
                own = spread[x] * spread[x]
                wider = np.sqrt(own + more * own - squared * known[x])
                spread[x] = -wider if spread[x] < _NO_CURVATURE else wider


FOLD_STEP_PX = 8  # px; of a second difference, 2 FOLD_STEP_PX from its neighbours
# Variance, in that of a position, of such a difference minus the mean of its
# neighbours.
FOLD_VARIANCE = 7.0
# Three standard deviations of it; a sigma widened by noise is safe.
FOLD_LIMIT = np.float32(3 * np.sqrt(FOLD_VARIANCE))
MAX_CURVATURE_CHANGE = np.float32(
    0.5
)  # of the neighbours: a smooth surface may deviate so much
# Spatially correlated noise and ripples increase the scatter of differences far from
# folds as well, where differences are smallest: a quarter of the values of a normal
# distribution are within 0.3186. Number of rows in the sample.
SCATTER_ROWS, MIN_N_SCATTER, QUARTILE, QUARTILE_PER_SIGMA = 64, 100, 0.25, 0.3186
_ZERO, _HALF = np.float32(0), np.float32(0.5)


def position_scatter(location, sigma, used):
    """Return (A,) float32: actual over predicted standard deviation, at least 1.

    location, sigma: (A, H, W), NaN where not decoded; used: (A,), 0 without phases.
    """
    height, width = location.shape[1:]
    scatter = np.ones(len(used), np.float32)
    rows, last = (
        slice(None, None, -(-height // SCATTER_ROWS)),
        max(width - 6 * FOLD_STEP_PX, 0),
    )
    for axis in np.flatnonzero(used):
        p = [
            location[axis, rows, k : k + last]
            for k in range(0, 7 * FOLD_STEP_PX, FOLD_STEP_PX)
        ]
        difference = 2 * p[3] - (p[2] + p[4]) / 2 - p[1] - p[5] + (p[0] + p[6]) / 2
        difference = np.abs(
            difference / sigma[axis, rows, 3 * FOLD_STEP_PX : 3 * FOLD_STEP_PX + last]
        )
        known = difference[np.isfinite(difference)]
        if len(known) > MIN_N_SCATTER:
            usual = (
                np.quantile(known, QUARTILE)
                / QUARTILE_PER_SIGMA
                / np.sqrt(FOLD_VARIANCE)
            )
            scatter[axis] = max(1.0, usual)
    return scatter


@njit(cache=True, nogil=True, error_model="numpy")
def _raise_to_fold_excess(a, b, c, d, e, f, g, out):
    """Raise out (n,) to the excess of second differences at c, d, e; ignore NaN.

    Excess: beyond those of a, b, c and of e, f, g and a tolerance.
    """
    for x in range(len(out)):
        left, right = a[x] - 2 * b[x] + c[x], e[x] - 2 * f[x] + g[x]
        own = c[x] - 2 * d[x] + e[x]
        low = left if left < right else right
        high = right if left < right else left
        above, under = own - high, low - own
        deviation = above if above > under else under
        deviation -= MAX_CURVATURE_CHANGE * _HALF * (abs(left) + abs(right))
        out[x] = deviation if deviation > out[x] else out[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _widen(spread, deviation, limit, gain):
    """Widen spread (n,), which may be marked by a minus sign, where a fold is found."""
    for x in range(len(deviation)):
        far = deviation[x] if deviation[x] > limit * abs(spread[x]) else _ZERO
        wider = np.sqrt(spread[x] * spread[x] + gain * far * far)
        spread[x] = -wider if spread[x] < _ZERO else wider


@njit(cache=True, nogil=True, error_model="numpy")
def widen_at_folds(location, sigma, scatter, used, share, start, stop):
    """Add the bias of windows and blur at folds to sigma (A, H, W), rows start to stop.

    scatter: as `position_scatter`; share: error of a position at a fold over its second
    difference. sigma may be marked by a minus sign.
    """
    height, width = location.shape[1:]
    reach, gain = 3 * FOLD_STEP_PX, np.float32((share * BIAS_TO_SIGMA) ** 2)
    deviation, n = np.empty(width, np.float32), width - 6 * FOLD_STEP_PX
    for axis in range(len(location)):
        if not used[axis]:
            continue
        p, limit = location[axis], FOLD_LIMIT * scatter[axis]
        for y in range(start, min(stop, height)):
            deviation[:] = _ZERO
            if n > 0:
                r = p[y]
                left, right = (
                    (r[:n], r[FOLD_STEP_PX:], r[2 * FOLD_STEP_PX :]),
                    (
                        r[4 * FOLD_STEP_PX :],
                        r[5 * FOLD_STEP_PX :],
                        r[6 * FOLD_STEP_PX :],
                    ),
                )
                _raise_to_fold_excess(
                    *left, r[reach:], *right, deviation[reach : reach + n]
                )
            if reach <= y < height - reach:
                above = p[y - reach], p[y - 2 * FOLD_STEP_PX], p[y - FOLD_STEP_PX]
                below = p[y + FOLD_STEP_PX], p[y + 2 * FOLD_STEP_PX], p[y + reach]
                _raise_to_fold_excess(*above, p[y], *below, deviation)
            _widen(sigma[axis, y], deviation, limit, gain)


def share_at_folds(variance):
    """Return the error of a position at a fold over its second difference.

    variance: of windows and blur together, px^2. The difference itself is smaller by
    twice the error. A blur wider than the difference is not decoded.
    """

    deviation = np.sqrt(variance / (2 * np.pi))
    return float(deviation / max(FOLD_STEP_PX - 2 * deviation, FOLD_STEP_PX / 4))
