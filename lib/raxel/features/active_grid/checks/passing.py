"""Something that passed before the monitor in some of the pictures, pixel by pixel.

A hand in two of six pictures of a sine spoils the places of those pixels that it
covers, and no others. Each pixel is asked by itself, against what noise does:

- Of N steps of a sine, N - 3 numbers are left. What the response and the light of each
  step leave there follows from phase, modulation, level and place in the picture; it is
  fitted to all pixels, by a few numbers, and taken off.
- Of three steps nothing is left, and two of four can hide from it. But the steps along
  x and those along y have one mean.
- A picture of the Gray code and its inverse add up to the same light whatever the bit.
  To turn a bit over, one of the two has to change by all of the contrast. Of one
  without its inverse, the code runs against the phase (`turned`).
"""

from itertools import combinations
from typing import NamedTuple

import cv2
import numpy as np
from scipy.stats import chi2

from raxel.features.active_grid.checks.leftover import (
    Steps,
    left_of,
    left_over,
    power,
    real,
    response,
    robust,
)  # fmt: skip
from raxel.features.active_grid.checks.outliers import (
    STRIDE,
    WHOLE,
    beyond_noise,
    rows_near,
    with_margin,
)
from raxel.features.active_grid.checks.turned import turned_over
from raxel.features.active_grid.layout import (
    BESIDE,
    BRIGHT,
    DARK,
    LIT,
    RIM,
    SATURATED,
    TURNED,
)

FITTED, MIN_FITTED = 4000, 1000  # pixels that the response is fitted to
AROUND = 4  # px about such pixels that are left out as well: half covered ones
NEARLY_TURNED = 0.65
MIN_PAIRS = 3  # of pictures and inverses: one of two is as likely as the other
SMALLEST = np.ones((3, 3), np.uint8)
EVERYWHERE = 0.5  # of all pixels: something else is wrong
NEW = 0.1  # of the pixels that a test finds, for its pictures to be named as well
EXPLAINED = 0.9  # of what is left, by the pictures that are named
WORTH_SAYING = 30  # pixels
WIDE = 3  # times the variance of noise: less is what a response leaves
MIN_LONG = 60  # pixels of a row or column
NAMED_OF = 2000  # pixels, enough to tell pictures by
OF_PLACE = [0, 6, 7, 8, 9, 10]  # of the shares, those that go with the place alone


class Passing(NamedTuple):
    """mask: (H, W) bool, where something passed, None where that was not asked;
    pictures: by their place in the stack, of each tuple one or several in which it did.
    bands: along x and y, by how much bands of light, which change from step to step,
    make the variance of means over windows larger than noise does; 1 where none do.
    """

    mask: np.ndarray
    pictures: tuple[tuple[int, ...], ...]
    bands: tuple[float, float] = (1.0, 1.0)


NOTHING = Passing(None, ())


def passing(images, codes, decoded):
    """The Passing of pictures that were decoded.

    images: n pictures (H, W); codes: AxisCodes; decoded: their Decoded.
    """
    seen = ~np.isin(decoded.status, (DARK, SATURATED))
    found, bands = [], [1.0, 1.0]
    of_sines = [code for code in codes if len(code.steps) > 2]
    lit = seen & _lit(images, of_sines, seen)
    if np.count_nonzero(lit) >= MIN_FITTED:
        some = _some(lit)
        steps = [Steps.of(images, code, some) for code in of_sines]
        for own in steps:
            passed, bands[own.axis] = _of_steps(own, some, lit, decoded.noise)
            found.append(passed)
        if len(steps) == 2:
            # Where one axis has told already, the means tell of it.
            told = [own for own, it in zip(steps, found, strict=True) if it]
            named = told if len(told) == 1 else steps
            found.append(_of_means(*steps, some, lit, decoded.noise, named))
    found.append(_of_bits(images, codes, seen))
    found += [_of_single_bits(images, code, decoded) for code in of_sines]
    mask, pictures = np.zeros(seen.shape, bool), []
    for own in found:
        if own is not None:
            new = np.count_nonzero(own.mask & ~mask)
            if new > NEW * np.count_nonzero(own.mask):
                pictures += own.pictures
            mask |= _around(own.mask)
    return Passing(mask, tuple(dict.fromkeys(pictures)), tuple(bands))


def _lit(images, codes, seen):
    """(H, W) bool: pixels that see the monitor's sines along x or y. In the dark beside
    it noise is not what it is where there is light."""
    stride = 1 if seen.size <= WHOLE else STRIDE
    every = (slice(None, None, stride),) * 2
    lit = np.zeros(seen[every].shape, bool)
    for code in codes if seen.any() else ():
        size = Steps.of(images, code, _some(seen)).at(every).size
        lit |= size > LIT * np.percentile(size[seen[every]], BRIGHT)
    height, width = seen.shape
    return lit.repeat(stride, axis=0).repeat(stride, axis=1)[:height, :width]


def _some(good):
    """An index of FITTED pixels that count, or of all."""
    found = np.flatnonzero(good)
    return np.unravel_index(found[:: -(-len(found) // FITTED)], good.shape)


def _around(mask):
    """What is near, too."""
    square = np.ones((2 * AROUND + 1,) * 2, np.uint8)
    return cv2.dilate(mask.astype(np.uint8), square) > 0


def passing_warnings(passed, patterns, count):
    """Lines on a Passing of pictures with these Patterns; count: of pixels that it
    took their places."""
    if count < WORTH_SAYING:
        return []
    named = [_any_of([patterns[k].image for k in some]) for some in passed.pictures]
    return [
        f"something passed before the monitor in {' and '.join(named)}: "
        f"{count} pixels are left out there; take these "
        "pictures again to have them"
    ]


def _any_of(names):
    if len(names) > 2:
        return f"some of {names[0]} to {names[-1]}"
    return " or ".join(names)


def _of_steps(steps, some, good, noise):
    """What steps of a sine leave besides it, as Passing, or None, and by how much bands
    of light make it more than noise."""
    count = len(steps.pictures)
    if count < 4:
        return None, 1.0
    gains, terms = response(steps.at(some))
    transform = (left_over(count) * (1 - gains)).astype(np.complex64)

    def asked(where):
        seen = steps.at(where)
        left = left_of(seen, transform, terms)
        return left, noise.at(seen.mean).astype(np.float32)

    found = beyond_noise(asked, good, count - 3)
    named = _named(found.mask, good, lambda where: _by_steps(count, asked(where)[0]))
    if named is not None:
        numbers = [tuple(steps.numbers[k] for k in some) for some in named.pictures]
        named = named._replace(pictures=tuple(numbers))
    return named, _bands(found)


def _bands(found):
    """By how much windows are off, where whole rows or columns are by more; else 1."""
    if found.of_windows < WIDE:
        return 1.0
    left, good = found.left, found.good
    freedom = 2 * len(left) - (not left[-1].imag.any())
    for along in (1, 0):
        known = good.sum(axis=along)
        long = known > MIN_LONG
        known = known.clip(1)
        means = np.sum(left * good, axis=along + 1) / known
        due = np.sum(found.variance * good, axis=along) / known**2
        squares = np.sum(np.abs(means) ** 2, axis=0)[long] / due[long]
        if long.any() and np.median(squares) > found.of_windows * chi2.median(freedom):
            return found.of_windows
    return 1.0


def _of_means(one, other, some, good, noise, named):
    """Where the means of the steps along x and y differ, as Passing, or None."""

    def columns(pair):
        found = list((pair[0].mean + pair[1].mean) / 2 * pair[0].shares()[OF_PLACE])
        for own in pair:
            wave = own.size * power(own.unit, len(own.light))
            found += [own.size, wave.real, wave.imag]
        return np.array(found)

    pair = one.at(some), other.at(some)
    difference = pair[0].mean - pair[1].mean
    found = robust(difference[None], columns(pair)[:, None]).astype(np.float32)
    share = 1 / len(one.pictures) + 1 / len(other.pictures)

    def asked(where):
        pair = one.at(where), other.at(where)
        left = pair[0].mean - pair[1].mean - np.tensordot(found, columns(pair), 1)
        variance = share * noise.at(pair[0].mean).astype(np.float32)
        return left[None].astype(np.complex64), variance

    mask = beyond_noise(asked, good, 1).mask
    return _named(mask, good, lambda where: tuple(own.numbers for own in named))


def _of_bits(images, codes, good):
    """Where a picture and its inverse add up to other light than others do."""
    pairs = [pair for code in codes for pair in code.bits if pair[1] is not None]
    if len(pairs) < MIN_PAIRS:
        return None
    mask = np.zeros(good.shape, bool)
    for rows in _rows_of_bits(images, pairs, good):
        near, own = with_margin(rows, 1)
        parts = [[images[k][near] for k in pair] for pair in pairs]
        spread, most = _spread(parts, lambda light: cv2.blur(light, (3, 3)))
        mask[rows] = good[rows] & (spread > TURNED * most)[own]

    def by_pairs(where):
        light = [[_about(images[k], where) for k in pair] for pair in pairs]
        own, apart = np.sum(light, axis=1), np.abs(np.diff(light, axis=1))
        off = np.abs(own - np.median(own, axis=0)) > TURNED / 2 * apart.max(axis=0)
        count = off.sum(axis=1)
        return tuple(pairs[k] for k in np.flatnonzero(count > 0.2 * count.max()))

    return _named(mask, good, by_pairs)


def _of_single_bits(images, code, decoded):
    """Where bits of an axis that have no inverse were turned over, as Passing."""
    alone = tuple(light for light, dark in code.bits if dark is None)
    good = ~np.isin(decoded.status, (DARK, SATURATED, BESIDE, RIM))
    if not alone or np.count_nonzero(good) < MIN_FITTED:
        return None
    mask = turned_over(images, code, good, decoded.blur_px)
    return _named(mask, good, lambda where: (alone,))


def _spread(pairs, smooth):
    """How far apart the light of pictures and inverses together lies, smooth, and the
    most that the two of a pair are apart; pairs: [(picture, inverse), ...]."""
    low = high = most = None
    for pair in pairs:
        light, dark = (one.astype(np.float32) for one in pair)
        own, apart = smooth(light + dark), np.abs(light - dark)
        low = own if low is None else np.minimum(low, own)
        high = own if high is None else np.maximum(high, own)
        most = apart if most is None else np.maximum(most, apart)
    return high - low, most


def _rows_of_bits(images, pairs, good):
    """Slices of rows in which a bit may have been turned over: all of a small picture;
    those where the means of STRIDE x STRIDE pixels nearly say so of a large one."""
    if good.size <= WHOLE:
        return [slice(0, len(good))]
    size = good.shape[1] // STRIDE, good.shape[0] // STRIDE
    small = (
        [cv2.resize(images[k], size, interpolation=cv2.INTER_AREA) for k in pair]
        for pair in pairs
    )
    spread, most = _spread(small, lambda light: light)
    middle = slice(STRIDE // 2, None, STRIDE)
    lit = good[middle, middle][: size[1], : size[0]]
    return rows_near(lit & (spread > NEARLY_TURNED * most), good.shape)


def _about(picture, where):
    """(P,) means of the 3 x 3 pixels about some."""
    v, u = (np.array(at)[:, None] + np.arange(-1, 2) for at in where)
    v, u = (at.clip(0, n - 1) for at, n in zip((v, u), picture.shape, strict=True))
    return picture[v[:, :, None], u[:, None, :]].mean(axis=(1, 2), dtype=float)


def _named(mask, good, pictures):
    """The Passing of what is 3 px wide at least; None of nothing, or of everything."""
    mask = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, SMALLEST) > 0
    count = np.count_nonzero(mask)
    if not 0 < count < EVERYWHERE * np.count_nonzero(good):
        return None
    where = np.argwhere(mask)
    where = tuple(where[:: -(-len(where) // NAMED_OF)].T)
    return Passing(mask, pictures(where))


def _by_steps(count, left):
    """((step, ...), ...): the fewest of N steps that explain what is left (M, P)."""
    own = real(left_over(count), count)
    left = real(left, count)
    for many in range(1, min(2, count - 4) + 1):
        shares = []
        for some in combinations(range(count), many):
            basis = np.linalg.qr(own[:, some])[0]
            shares.append((np.sum((basis.T @ left) ** 2), some))
        best, some = max(shares)
        if best > EXPLAINED * np.sum(left**2):
            return tuple((k,) for k in some)
    return (tuple(range(count)),)
