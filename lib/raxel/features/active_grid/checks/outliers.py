"""Pixels beyond noise, alone or with their neighbours, in pictures of any size.

Of a large picture every STRIDE-th pixel each way is asked first, and only rows about
those that may be beyond are asked in whole: what is narrower than STRIDE is not looked
for. All is done in blocks of rows, so that memory does not grow with the picture but by
some bytes a pixel.
"""

from typing import NamedTuple

import cv2
import numpy as np
from scipy.stats import chi2

from raxel.features.active_grid.layout import REACH

SIZES = 1, 2 * REACH + 1  # of windows: a pixel alone, and as places are averaged
WHOLE = 2**19  # pixels of a picture of which all are asked
STRIDE = 3
AT_ONCE = 2**17  # pixels, of which each takes some 300 bytes meanwhile
SURE, SUSPECT = 7, 5  # standard deviations: beyond, and to be looked at closely
AROUND = 14  # rows of every STRIDE-th about such that are asked in whole
STRIPS, HIGH = 8, 10  # and their rows, for what is usual in windows of a large picture
ROUNDED, DITHERED = 1 / 12, 1 / 4  # grey levels squared, see `_of_mean`


class Beyond(NamedTuple):
    """mask: (H, W) bool, pixels beyond noise; of_windows: usual squares of means over
    windows, in those of noise; left, variance, good: of every pixel, or of every
    STRIDE-th of a large picture, what it leaves, its variance, whether it counts."""

    mask: np.ndarray
    of_windows: float
    left: np.ndarray
    variance: np.ndarray
    good: np.ndarray


def beyond_noise(asked, good, freedom):
    """Beyond of the pixels that count.

    asked: index into pictures, a tuple -> what is left there, (M, ...) complex, and the
    variance by noise of each of the `freedom` numbers in it; good: (H, W) bool.
    """
    stride = 1 if good.size <= WHOLE else STRIDE
    left, variance = _assembled(asked, good.shape, stride)
    lit = good[::stride, ::stride]
    squares = [_squares(left, variance, lit, size) for size in SIZES]
    usual = [_usual(each[lit], freedom) for each in squares]
    if stride == 1:
        sure = [_limit(SURE, freedom, each) for each in usual]
        return Beyond(_any(squares, sure, lit), usual[-1], left, variance, lit)
    limits = [_limit(SUSPECT, freedom, each) for each in usual]
    suspects = _any(squares, limits, lit)
    usual = _usual_in_strips(asked, good, freedom)
    limits = [_limit(SURE, freedom, each) for each in usual]
    mask = np.zeros(good.shape, bool)
    for rows in rows_near(suspects, good.shape):
        near, own = with_margin(rows, REACH)
        found = asked((near,))
        squares = [_squares(*found, good[near], size) for size in SIZES]
        mask[rows] = _any(squares, limits, good[near])[own]
    return Beyond(mask, usual[-1], left, variance, lit)


def rows_near(suspects, shape):
    """Slices of a picture's rows with suspects (every STRIDE-th pixel) near them."""
    rows = np.flatnonzero(suspects.any(axis=1)) * STRIDE
    reach = AROUND * STRIDE
    return [
        block
        for block in _blocks(shape, 1)
        if np.any((rows >= block.start - reach) & (rows < block.stop + reach))
    ]


def with_margin(rows, reach):
    """(rows with some more to both sides, where the rows are among these)."""
    near = slice(max(rows.start - reach, 0), rows.stop + reach)
    return near, slice(rows.start - near.start, rows.stop - near.start)


def _blocks(shape, stride):
    """Slices of rows with AT_ONCE pixels each, every stride-th counted, or one row."""
    high = stride * max(1, AT_ONCE * stride // shape[1])
    stops = min(shape[0], high)
    return [slice(top, top + stops, stride) for top in range(0, shape[0], stops)]


def _assembled(asked, shape, stride):
    parts = [
        asked((rows, slice(None, None, stride))) for rows in _blocks(shape, stride)
    ]
    left, variance = zip(*parts, strict=True)
    return np.concatenate(left, axis=1), np.concatenate(variance)


def _usual_in_strips(asked, good, freedom):
    """Of each of SIZES, what is usual in whole rows all over the picture."""
    found = [[] for _ in SIZES]
    inner = slice(REACH, -REACH)
    for top in np.linspace(0, len(good) - HIGH, STRIPS).astype(int):
        rows = slice(top, top + HIGH)
        left, variance = asked((rows,))
        for own, size in zip(found, SIZES, strict=True):
            squares = _squares(left, variance, good[rows], size)
            own.append(squares[inner][good[rows][inner]])
    return [_usual(np.concatenate(own), freedom) for own in found]


def _any(squares, limits, good):
    pairs = zip(squares, limits, strict=True)
    return good & np.any([each > limit for each, limit in pairs], axis=0)


def _squares(left, variance, good, size):
    """(H, W) squares of means over windows, in the variance of one of their numbers."""
    means, known = _means(left, good, size)
    return np.sum(np.abs(means) ** 2, axis=0) / _of_mean(variance, known)


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


def _usual(squares, freedom):
    """Squares in those of noise; 1 of none."""
    if not len(squares):
        return 1.0
    some = squares[:: 1 + len(squares) // 50_000]
    return float(np.median(some) / chi2.median(freedom))


def _limit(sure, freedom, usual):
    """Squares that are so many standard deviations beyond what most leave."""
    return chi2.isf(chi2.sf(sure**2, 1), freedom) * max(usual, 1)
