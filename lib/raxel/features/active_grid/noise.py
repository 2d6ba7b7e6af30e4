"""The noise of pictures, from the pictures: variance against grey level."""

from typing import NamedTuple

import numpy as np

SAMPLES = 120_000  # pixels looked at, in rows all over the pictures
LEVELS = 16
MIN_IN_LEVEL = 500
QUANTISATION = 1 / 12  # variance of rounding to whole grey levels
# The median of |x| of a normal law with standard deviation 1.
MEDIAN = 0.6744897501960817
# Of the sum of squares of (1 -2 1) by (1 -2 1).
GAIN = 36.0


class Noise(NamedTuple):
    """Variance of a grey value of level I: floor + slope I, grey levels squared.

    It is nowhere below `least`. Where black is a level above 0, as in raw pictures, the
    floor is that much slope lower, and may be below 0.
    """

    floor: float
    slope: float = 0.0
    least: float = 0.0

    def at(self, level):
        """The variance at grey levels of any shape."""
        return np.maximum(self.floor + self.slope * level, self.least)


def estimate_noise(images, white):
    """The Noise of pictures (H, W), a list of them, by the values that are not clipped.

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
    for picture in images:
        three = [picture[middle + d].astype(np.int32) for d in (-1, 0, 1)]
        clipped = [(row == 0) | (row >= white) for row in three]
        clipped = clipped[0] | clipped[1] | clipped[2]
        clipped = clipped[:, :-2] | clipped[:, 1:-1] | clipped[:, 2:]
        down = three[0] - 2 * three[1] + three[2]
        response = down[:, :-2] - 2 * down[:, 1:-1] + down[:, 2:]
        level = (three[0] + three[2])[:, 1:-1] // 2
        # Whole numbers so short are sorted in linear time.
        levels.append(level[~clipped].astype(picture.dtype))
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
