"""What N >= 4 steps of a sine leave besides it: noise that is not white, and drift.

Of N steps, N - 3 numbers a pixel are left when a sine has been taken off. Their
variance is that of grey values, of one pixel and of a mean over a window alike: noise
that neighbours share, as the blocks of a JPEG file make it, is less averaged away than
white noise, and a window says by how much. Light that changes from step to step leaves
them in proportion to the light: with M what takes off a sine, and pictures I_j that
are brighter by g_j, the sum of M_kj I_j / (1 + g_j) over j is nothing but noise. Its
square is a form of 1 / (1 + g_j), which the vector of its least eigenvalue makes least.
"""

from typing import NamedTuple

import numpy as np
from scipy.stats import chi2

WINDOW = 7
# Of windows side by side, left - 2 middle + right has six times the variance of one.
OF_THREE = 6
KNOWN = 0.02  # of the light's square; five times more where whole periods are seen


class Scatter(NamedTuple):
    """of_windows, of_one: variance of grey values, of means over windows and of single
    pixels, over that of white noise as it was measured; drift: (N,) light of the steps
    over its mean, less 1, 0 where it is not known; periods: RMS error of places by it.
    """

    of_windows: float
    of_one: float
    drift: np.ndarray
    periods: float

    def of(self, smooth):
        """The variance of what places are read from."""
        return self.of_windows if smooth else self.of_one


def sine_taken_off(count):
    """(N, N): takes the sine of the steps off their values at a pixel."""
    steps = 2 * np.pi / count * np.arange(count)
    return np.eye(count) - (1 + 2 * np.cos(steps[:, None] - steps)) / count


def scatter_of_steps(light, harmonics, variance):
    """The Scatter of N steps of pixels.

    light: (N, P) of W windows of three side by side, P = W x 7 x 21 in this order;
    harmonics: (C, P), what a response leaves; variance: (P,) of white noise.
    """
    count = len(light)
    off = sine_taken_off(count)
    basis = np.linalg.qr(harmonics.T)[0]
    inner = light - (light @ basis) @ basis.T
    share = _shares(off * (inner @ inner.T), light)
    left = off @ (share[:, None] * light)
    left = left - (left @ basis) @ basis.T
    three = left.reshape(count, -1, WINDOW, 3, WINDOW)
    means = three.mean(axis=(2, 4))
    bent = means[..., 0] - 2 * means[..., 1] + means[..., 2]
    degrees = chi2.median(count - 3)
    due = variance.reshape(-1, WINDOW, 3, WINDOW).mean(axis=(1, 2, 3))
    windows = np.sum(bent**2, axis=0) * WINDOW**2 / OF_THREE / due
    pixels = np.sum(left**2, axis=0) / variance
    pixels = pixels.reshape(-1, 3 * WINDOW**2).mean(axis=1)
    turn = np.exp(-2j * np.pi * np.arange(count) / count)
    apart = (turn * share) @ light * np.conj(turn @ light)
    periods = np.sqrt(np.mean((np.angle(apart) / (2 * np.pi)) ** 2))
    return Scatter(
        float(np.median(windows) / degrees),
        float(np.median(pixels) / (count - 3)),
        1 / share - 1,
        float(periods),
    )


def _shares(form, light):
    """(N,) 1 / (1 + g_j) as the form has them, if it does; 1 where less than a period
    is seen, and the steps' own light is much like what a response leaves."""
    sizes, vectors = np.linalg.eigh(form)
    share = vectors[:, 0] / vectors[:, 0].mean()
    if sizes[1] < KNOWN * np.mean(light**2) * light.shape[1]:
        return np.ones(len(light))
    return share
