"""Something that passed before the monitor in some of the pictures, pixel by pixel.

A hand in two of six pictures of a sine spoils the places of those pixels that it
covers, and no others. Each pixel is asked by itself, against what noise does:

- Of N steps of a sine, N - 3 numbers are left. What the response and the light of each
  step leave there follows from phase, modulation, level and place in the picture; it is
  fitted to all pixels, by a few numbers, and taken off.
- Of three steps nothing is left, and two of four can hide from it. But the steps along
  x and those along y have one mean.
- A picture of the Gray code and its inverse add up to the same light whatever the bit.
  To turn a bit over, one of the two has to change by all of the contrast.
"""

from itertools import combinations
from typing import NamedTuple

import cv2
import numpy as np
from scipy.stats import chi2

from raxel.features.active_grid.checks.leftover import (
    Steps,
    blocks_of_rows,
    left_of,
    left_over,
    power,
    real,
    response,
    robust,
)  # fmt: skip
from raxel.features.active_grid.layout import DARK, REACH, SATURATED

WINDOW = 2 * REACH + 1
FITTED, MIN_FITTED = 4000, 1000  # pixels that the response is fitted to
ROUNDED, DITHERED = 1 / 12, 1 / 4  # grey levels squared, see `_of_mean`
SURE = 7  # standard deviations of what is left
AROUND = 4  # px about such pixels that are left out as well: half covered ones
TURNED = 0.75  # of the contrast; an edge behind a tone curve has 0.6 at most
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
    steps = [Steps.of(images, code, seen) for code in codes if len(code.steps) > 2]
    found, bands = [], [1.0, 1.0]
    for own in steps:
        passed, bands[own.axis] = _of_steps(own, seen, decoded.noise)
        found.append(passed)
    if len(steps) == 2:
        # Where one axis has told already, the means tell of it.
        alone = [one for one, own in zip(steps, found, strict=True) if own is not None]
        named = alone if len(alone) == 1 else steps
        found.append(_of_means(*steps, seen, decoded.noise, named))
    found.append(_of_bits(images, codes, seen))
    mask, pictures = np.zeros(seen.shape, bool), []
    for own in found:
        if own is not None:
            new = np.count_nonzero(own.mask & ~mask)
            if new > NEW * np.count_nonzero(own.mask):
                pictures += own.pictures
            mask |= _around(own.mask)
    return Passing(mask, tuple(dict.fromkeys(pictures)), tuple(bands))


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


def _of_steps(steps, good, noise):
    """What steps of a sine leave besides it, as Passing, or None, and by how much bands
    of light make it more than noise."""
    count = len(steps.light)
    some = np.argwhere(good)
    if count < 4 or len(some) < MIN_FITTED:
        return None, 1.0
    some = tuple(some[:: -(-len(some) // FITTED)].T)
    gains, terms = response(steps, some)
    transform = (left_over(count) * (1 - gains)).astype(np.complex64)
    left = np.empty((len(transform), *good.shape), np.complex64)
    for rows in blocks_of_rows(good.shape):
        left[:, rows] = left_of(steps, transform, terms, rows)
    variance = noise.at(steps.mean).astype(np.float32)
    mask = np.zeros(good.shape, bool)
    for size in (1, WINDOW):
        means, known = _means(left, good, size)
        squares = np.sum(np.abs(means) ** 2, axis=0) / _of_mean(variance, known)
        mask |= _beyond(squares, good, count - 3)
    bands = _bands(left, good, variance, _usual(squares, good, count - 3))
    named = _named(mask, good, lambda where: _by_steps(steps, left[:, *where]))
    return named, bands


def _bands(left, good, variance, of_windows):
    """of_windows, where whole rows or columns are off by more than windows; else 1."""
    if of_windows < WIDE:
        return 1.0
    freedom = 2 * len(left) - (not left[-1].imag.any())
    for along in (1, 0):
        known = good.sum(axis=along)
        long = known > MIN_LONG
        known = known.clip(1)
        means = np.sum(left * good, axis=along + 1) / known
        due = np.sum(variance * good, axis=along) / known**2
        squares = np.sum(np.abs(means) ** 2, axis=0)[long] / due[long]
        if long.any() and np.median(squares) > of_windows * chi2.median(freedom):
            return of_windows
    return 1.0


def _means(values, good, size):
    """Means (K, H, W) over the good pixels of windows, and of how many they are."""
    if size == 1:
        return values * good, good.astype(np.float32)
    window = {"ddepth": -1, "ksize": (size, size), "borderType": cv2.BORDER_CONSTANT}
    known = cv2.boxFilter(good.astype(np.float32), normalize=False, **window)
    sums = []
    for one in values:
        parts = cv2.merge([one.real * good, one.imag * good])
        sums.append(cv2.boxFilter(parts, normalize=False, **window))
    sums = np.array(sums)
    return (sums[..., 0] + 1j * sums[..., 1]) / np.maximum(known, 1), known


def _of_mean(variance, known):
    """Variance of a mean of so many pixels. Where next to no noise is in the picture,
    neighbours are rounded alike, and what is rounded is no smaller in their mean."""
    alone = variance / np.maximum(known, 1)
    return np.where(variance > DITHERED, alone, np.maximum(alone, ROUNDED))


def _usual(squares, good, freedom):
    """Squares of good pixels in those of noise."""
    some = squares[good][:: 1 + np.count_nonzero(good) // 50_000]
    return float(np.median(some) / chi2.median(freedom))


def _beyond(squares, good, freedom):
    """(H, W) bool: good pixels where squares are SURE beyond what most leave."""
    limit = chi2.isf(chi2.sf(SURE**2, 1), freedom)
    return good & (squares > limit * max(_usual(squares, good, freedom), 1))


def _of_means(one, other, good, noise, named):
    """Where the means of the steps along x and y differ, as Passing, or None."""
    if np.count_nonzero(good) < MIN_FITTED:
        return None
    some = np.argwhere(good)
    some = tuple(some[:: -(-len(some) // FITTED)].T)

    def columns(where):
        mean = (one.mean[where] + other.mean[where]) / 2
        found = list(mean * one.shares(where)[OF_PLACE])
        for own in (one, other):
            wave = own.size[where] * power(own.unit[where], len(own.light))
            found += [own.size[where], wave.real, wave.imag]
        return np.array(found)

    difference = one.mean - other.mean
    found = robust(difference[some][None], columns(some)[:, None])
    left, found = difference.copy(), found.astype(np.float32)
    for rows in blocks_of_rows(good.shape):
        left[rows] -= np.tensordot(found, columns(rows), 1)
    share = 1 / len(one.light) + 1 / len(other.light)
    variance = share * noise.at(one.mean).astype(np.float32)
    mask = np.zeros(good.shape, bool)
    for size in (1, WINDOW):
        means, known = _means(left[None].astype(np.complex64), good, size)
        squares = means[0].real ** 2 / _of_mean(variance, known)
        mask |= _beyond(squares, good, 1)
    return _named(mask, good, lambda where: tuple(own.pictures for own in named))


def _of_bits(images, codes, good):
    """Where a picture and its inverse add up to other light than others do."""
    pairs = [pair for code in codes for pair in code.bits if pair[1] is not None]
    if len(pairs) < MIN_PAIRS:
        return None
    sums, most = [], np.zeros(good.shape, np.float32)
    for light, dark in pairs:
        light, dark = (images[k].astype(np.float32) for k in (light, dark))
        sums.append(cv2.blur(light + dark, (3, 3)))
        most = np.maximum(most, np.abs(light - dark))
    low, high = np.minimum.reduce(sums), np.maximum.reduce(sums)
    mask = good & (high - low > TURNED * most)

    def by_pairs(where):
        own = np.array([one[where] for one in sums])
        off = np.abs(own - np.median(own, axis=0)) > TURNED / 2 * most[where]
        count = off.sum(axis=1)
        return tuple(pairs[k] for k in np.flatnonzero(count > 0.2 * count.max()))

    return _named(mask, good, by_pairs)


def _named(mask, good, pictures):
    """The Passing of what is 3 px wide at least; None of nothing, or of everything."""
    mask = cv2.morphologyEx(mask.astype(np.uint8), cv2.MORPH_OPEN, SMALLEST) > 0
    count = np.count_nonzero(mask)
    if not 0 < count < EVERYWHERE * np.count_nonzero(good):
        return None
    where = np.argwhere(mask)
    where = tuple(where[:: -(-len(where) // NAMED_OF)].T)
    return Passing(mask, pictures(where))


def _by_steps(steps, left):
    """((picture, ...), ...): the fewest that explain what is left (M, P)."""
    count = len(steps.light)
    own = real(left_over(count), count)
    left = real(left, count)
    for many in range(1, min(2, count - 4) + 1):
        shares = []
        for some in combinations(range(count), many):
            basis = np.linalg.qr(own[:, some])[0]
            shares.append((np.sum((basis.T @ left) ** 2), some))
        best, some = max(shares)
        if best > EXPLAINED * np.sum(left**2):
            return tuple((steps.pictures[k],) for k in some)
    return (tuple(steps.pictures),)
