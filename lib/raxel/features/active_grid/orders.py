"""Which period each pixel sees, where sines tell it in the place of a Gray code.

Phases are those of windows of 7 x 7 pixels, or of one pixel where its window shows no
single place (`periods`).
"""

import cv2
import numpy as np

from raxel.features.active_grid.coding import CELLS
from raxel.features.active_grid.layout import REACH, UNKNOWN
from raxel.features.active_grid.periods import Phases, fitted_periods, scatter_of
from raxel.features.active_grid.reading import MIN_MODULATION

ROWS = 256  # worked through at a time
WINDOW = 2 * REACH + 1
# Periods by which a pixel's phase departs from its window's on a surface, beside noise.
OF_BENDING, BEYOND_NOISE = np.float32(0.05), np.float32(6)
BLOCKS = 8  # of rows, all over the picture, by which the scatter of phases is known


def told_cells(images, codes, monitor_px, noise, smooth):
    """(A, H, W) uint16: `period_cells` of the axes where sines tell of periods."""
    cells = np.zeros((len(codes), *images[0].shape), np.uint16)
    for axis, code in enumerate(codes):
        if code.others:
            extent = monitor_px[code.axis]
            cells[axis] = period_cells(images, code, extent, noise, smooth)
    return cells


def period_cells(images, code, extent, noise, smooth):
    """(H, W) uint16: the cell of each pixel, CELLS to a period, or UNKNOWN.

    images: pictures (H, W) of a view; code: the AxisCode of its sines; extent: of the
    monitor along that axis, px; noise: a Noise; smooth: whether windows are averaged.
    Where phases scatter more than noise lets them, as a response makes them that is not
    linear, they are taken to be as uncertain as they scatter.
    """
    height, width = images[0].shape
    starts = range(0, height, ROWS)
    every = starts[:: -(-len(starts) // BLOCKS)]
    sines = code.sines, *code.others
    periods = np.array([extent / one.period for one in sines], np.float32)
    some = zip(*(_phases(images, sines, first, noise) for first in every), strict=True)
    scatter = [scatter_of(phases, periods) for phases in some]
    cells = np.empty((height, width), np.uint16)
    for first in starts:
        own, means = _phases(images, sines, first, noise)
        found = _cells(own, own, periods, scatter[0])
        if smooth:
            of_means = _cells(own, means, periods, scatter[1])
            found = np.where(of_means == UNKNOWN, found, of_means)
        cells[first : first + ROWS] = found
    return cells


def _cells(own, phases, periods, scatter):
    """(h, w) uint16; own: the pixels' own phases, beside those of windows."""
    fit = fitted_periods(phases, periods)
    good = own.lit & fit.told(scatter)
    apart = np.abs(own.turns - phases.turns)
    apart = np.minimum(apart, 1 - apart)
    limit = OF_BENDING + BEYOND_NOISE * np.sqrt(own.variances)
    good &= np.all(apart <= limit, axis=0)
    cells = np.clip(np.floor(CELLS * fit.place), 0, UNKNOWN - 1)
    return np.where(good, cells, UNKNOWN).astype(np.uint16)


def _phases(images, sines, first, noise):
    """Phases of ROWS rows from `first`: of each pixel, and of the windows around."""
    height, width = images[0].shape
    start, stop = max(first - REACH, 0), min(first + ROWS + REACH, height)
    inner = slice(first - start, min(first + ROWS, height) - start)
    shape = 2, len(sines), stop - start, width
    turns, variances = np.empty(shape, np.float32), np.empty(shape, np.float32)
    lit = np.ones(shape[2:], bool)
    for k, one in enumerate(sines):
        parts = np.zeros((3, *shape[2:]), np.float32)
        for picture, weights in zip(one.steps, one.weights.T, strict=True):
            light = images[picture][start:stop].astype(np.float32)
            for part, weight in zip(parts, weights, strict=True):
                part += np.float32(weight) * light
        of_wave = 2 / len(one.steps) * noise.at(parts[2])
        lit &= parts[0] ** 2 + parts[1] ** 2 > MIN_MODULATION**2 * of_wave
        means = [cv2.blur(part, (WINDOW, WINDOW)) for part in parts[:2]]
        for n, (sine, cosine) in enumerate((parts[:2], means)):
            turns[n, k] = np.arctan2(sine, cosine) / (2 * np.pi) % 1
            variances[n, k] = of_wave / WINDOW ** (2 * n) / (sine**2 + cosine**2 + 1e-6)
    variances /= (2 * np.pi) ** 2
    turns, variances, lit = turns[:, :, inner], variances[:, :, inner], lit[inner]
    return Phases(turns[0], variances[0], lit), Phases(turns[1], variances[1], lit)
