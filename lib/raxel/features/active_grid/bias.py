"""By how much averaging over pixels shifts a phase that bends.

A mean of a phase phi over a symmetric window or blur of variance s^2 (px^2, along each
axis of the picture) is off by s^2 / 2 times the sum of phi's second derivatives. Where
perspective or a curved mirror bends the phases, that is no noise, and smoothing does
not take it away.
"""

import cv2
import numpy as np

from raxel.features.active_grid.coding import phase_weights
from raxel.features.active_grid.layout import SQUARE

OF_WINDOWS, OF_NEIGHBOURS = 4.0, 2 / 3  # variances of 7 x 7 and 3 x 3 pixels, px^2
MOST_BENT = 0.15  # second difference in periods; what is above is a break


def squared_bias(images, codes, variance_px2, least):
    """(A, ceil(H / SQUARE), W) float32, squared periods: a row for each row of squares.

    images: n pictures (H, W); codes: A AxisCodes; variance_px2: of windows and blur;
    least: modulation in grey levels below which there is no phase.
    """
    height, width = images[0].shape
    shape = len(codes), -(-height // SQUARE), -(-width // SQUARE)
    bias = np.zeros(shape, np.float32)
    if min(shape[1:]) > 2 and variance_px2:
        for axis, code in enumerate(codes):
            if code.steps:
                bent = _bending(*_seen_places(images, code, shape[1:], least))
                bias[axis] = np.square(variance_px2 / 2 * bent)
    return np.ascontiguousarray(np.repeat(bias, SQUARE, axis=2)[:, :, :width])


def _seen_places(images, code, shape, least):
    """(h, w) places in the middle of squares, in periods, and which are known.

    The phase is of 3 x 3 pixels; bits without an inverse are left out.
    """
    height, width = images[0].shape
    y = SQUARE // 2 + SQUARE * np.arange(shape[0])
    x = SQUARE // 2 + SQUARE * np.arange(shape[1])
    whole = np.ix_(y < height - 1, x < width - 1)
    y, x = np.minimum(y, height - 2), np.minimum(x, width - 2)
    wave = np.zeros(shape, complex)
    sine, cosine, _ = phase_weights(len(code.steps))
    for k, weight in zip(code.steps, cosine + 1j * sine, strict=True):
        for down, right in np.ndindex(3, 3):
            wave += weight / 9 * images[k][np.ix_(y + down - 1, x + right - 1)]
    turn = np.angle(wave) / (2 * np.pi) % 1
    value, cell, middle = np.zeros(shape, bool), np.zeros(shape, int), np.ix_(y, x)
    for picture, inverse in code.bits:
        if inverse is not None:
            value = value ^ (images[picture][middle] > images[inverse][middle])
            cell = 2 * cell + value
    of_cell = (cell + 0.5) * code.cell / code.period
    known = np.zeros(shape, bool)
    known[whole] = np.abs(wave[whole]) > least
    return np.ceil(of_cell - turn - 0.5) + turn, known


def _bending(place, known):
    """(h, w) periods / px^2: sum of the second derivatives of places."""
    along = place[1:-1, 2:] + place[1:-1, :-2] - 2 * place[1:-1, 1:-1]
    down = place[2:, 1:-1] + place[:-2, 1:-1] - 2 * place[1:-1, 1:-1]
    bent = np.pad(np.maximum(abs(along), abs(down)) < MOST_BENT, 1)
    for shift in ((0, 0), (0, 1), (1, 0), (0, -1), (-1, 0)):
        bent &= np.roll(known, shift, (0, 1))
    return _filled(np.pad(along + down, 1), bent) / SQUARE**2


def _filled(values, known):
    """Squares that are not known get the mean of neighbours that are, twice; or 0."""
    for _ in range(2):
        count, sums = (
            9 * cv2.blur(array.astype(float), (3, 3), borderType=cv2.BORDER_CONSTANT)
            for array in (known, np.where(known, values, 0))
        )
        values = np.where(known, values, sums / count.clip(1))
        known = count > 0.5
    return values
