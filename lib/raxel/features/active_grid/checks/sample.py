"""The part of the pixels that doubts are looked for in, and what codes make of it."""

from dataclasses import dataclass
from typing import NamedTuple

import numpy as np

PIXELS = 250_000
BAND = 16  # rows that are taken together, so that there are neighbours both ways
MIN_CONTRAST = 10  # standard deviations of the noise
MIN_SHARE = 0.1  # of what the better lit pixels have
MIN_LIT = 500  # pixels; of fewer, nothing is said


class Doubt(NamedTuple):
    """What was found and what to do. code: of its kind, for programs; `spoils`: what
    was decoded is wrong."""

    code: str
    spoils: bool
    text: str


@dataclass(frozen=True, eq=False)
class Sample:
    """Bands of rows of all pictures (n, bands, BAND, W) float32, and their codes.

    high, low: the brightest and darkest of each pixel; lit: bool, whether they are far
    apart. codes: the AxisCodes; extents: (A,) of the monitor, px; names: of the
    pictures. middle: halfway, for bits without inverse.
    """

    pictures: np.ndarray
    names: list
    codes: tuple
    extents: np.ndarray
    high: np.ndarray
    low: np.ndarray
    lit: np.ndarray
    middle: np.ndarray

    def apart(self, axis, bit):
        """Picture less inverse of a bit, in shares of the contrast, -1 to 1."""
        light, dark = self.codes[axis].bits[bit]
        if dark is None:
            value = 2 * (self.pictures[light] - self.middle)
        else:
            value = self.pictures[light] - self.pictures[dark]
        return value / np.maximum(self.high - self.low, 1e-6)

    def wave(self, axis):
        """(B exp(i phi), mean) of the steps that places are read from."""
        sines = self.codes[axis].sines
        return self.wave_of(sines, sines.steps)

    def wave_of(self, sines, pictures):
        """As `wave`, of these pictures in the place of the steps of some Sines."""
        weights = sines.weights.astype(np.float32)
        parts = np.tensordot(weights, self.pictures[list(pictures)], 1)
        return parts[1] + 1j * parts[0], parts[2]


def sampled(images, patterns, codes, monitor, noise, levels):
    """The Sample of a view's pictures, or None where too little of it is lit."""
    height, width = images[0].shape
    rows = _rows(height, width)
    levels = [level for level in levels if level is not None]
    extents = np.array([monitor.monitor_px[code.axis] for code in codes])
    taken = np.array([image[rows] for image in (*images, *levels)], np.float32)
    taken = taken.reshape(len(taken), -1, min(BAND, height), width)
    high, low = taken.max(axis=0), taken.min(axis=0)
    contrast = high - low
    spread = np.sqrt(noise.at((high + low) / 2))
    usual = np.quantile(contrast, 0.95)
    lit = contrast > np.maximum(MIN_CONTRAST * spread, MIN_SHARE * usual)
    if np.count_nonzero(lit) < MIN_LIT:
        return None
    names = [p.image for p in patterns]
    own = taken[: len(images)], names, codes, extents
    return Sample(*own, high, low, lit, (high + low) / 2)


def _rows(height, width):
    """Bands of rows, evenly spread, of about PIXELS pixels."""
    band = min(BAND, height)
    count = min(max(1, PIXELS // (band * width)), height // band)
    first = np.linspace(0, height - band, count).round().astype(int)
    return (first[:, None] + np.arange(band)).ravel()


def neighbours(distance):
    """Slices of pixels and of those so far to the right of, or below, them."""
    every = slice(None)
    return (
        ((every, every, slice(None, -distance)), (every, every, slice(distance, None))),
        ((every, slice(None, -distance), every), (every, slice(distance, None), every)),
    )
