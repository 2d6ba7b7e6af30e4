"""What the steps of a sine say against each other, and how wrong places are by it.

A sine has three unknowns; of N steps, N - 3 numbers a pixel are left, for four steps
I0 - I1 + I2 - I3. An image that is brighter than the others or moved leaves
(N - 3) / N of what was done to it there, and turns the phase by 2 / N of that, over the
modulation and in quadrature. Harmonics of the response are left as well: they follow
the phase, two turns or more for one, and are taken off. Of three steps nothing is left.
"""

from typing import NamedTuple

import cv2
import numpy as np
from scipy.stats import chi2

# What N >= 4 steps of a sine leave besides it: noise that is not white, and drift. Of
# N steps, N - 3 numbers a pixel are left when a sine has been taken off. Their
# variance is that of grey values, of one pixel and of a mean over a window alike:
# noise that neighbours share, as the blocks of a JPEG file make it, is less averaged
# away than white noise, and a window says by how much. Light that changes from step
# to step leaves them in proportion to the light: with M what takes off a sine, and
# images I_j that are brighter by g_j, the sum of M_kj I_j / (1 + g_j) over j is
# nothing but noise. Its square is a form of 1 / (1 + g_j), which the vector of its
# least eigenvalue makes least.


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


PIXELS, WINDOWS = 12_000, 800  # looked at
MIN_PIXELS = 1000
SMOOTH_TURN = 0.5  # of the cosine: neighbours further apart lie across a break
CLIPPED = 4  # deviations: what is further off is left out of a second fit
OF_MEDIAN = 0.4549364  # the median of the square of a normal value
# Standard deviations of what was fitted: noise reaches a shift of 8 by exp(-32). What a
# response leaves and no column describes is a few.
SURE = 8
AS_WELL = 0.98  # of what the best one explains: it may be that one
# Harmonics of powers; those of curves like an S as well, for means over windows.
LARGEST, LARGE = (2,), (2, 3)
LIGHT, MOTION = "light", "motion"


class Mismatch(NamedTuple):
    """One image against the other steps of its axis.

    kind: LIGHT, MOTION, or "" where neither is certain; images: which one, or those
    of which it is one; size: light over that of the others less 1, or length of the
    shift in px. periods: RMS of the error of places by it. scatter: what is left of all
    steps, None of too small a surface.
    """

    kind: str
    images: tuple[int, ...]
    size: float
    periods: float
    scatter: Scatter | None


class _Pixels(NamedTuple):
    """P pixels of an axis' N steps: light (N, P), mean (P,), wave (P,) complex, their
    slopes (2, P) along x and y; at: (2, P), from -1 to 1."""

    light: np.ndarray
    mean: np.ndarray
    wave: np.ndarray
    of_mean: np.ndarray
    of_wave: np.ndarray
    at: np.ndarray

    @property
    def spare(self):
        """Variance of `left`, in that of a grey value."""
        return len(self.light) / (len(self.light) - 3)

    def left(self, k):
        """Of step k, what was done to it if nothing was to the others; and what a
        change of its light by 1, and shifts by 1 px along x and y would be: (P,),
        (3, P)."""
        turn = np.exp(2j * np.pi * k / len(self.light))
        slopes = self.of_mean + (self.of_wave * turn).imag
        fitted = self.mean + (self.wave * turn).imag
        return (self.light[k] - fitted) * self.spare, np.stack([fitted, *slopes])

    def turned(self, k, change):
        """Periods by which a change of step k turns the phase."""
        count = len(self.light)
        own = self.wave * np.exp(2j * np.pi * k / count)
        return 2 / count * change * own.real / (np.abs(own) ** 2 + 1e-6) / (2 * np.pi)


class _Fit(NamedTuple):
    """A kind of change of step k: what it explains of the variance, coefficients, and
    how many standard deviations all of them are from none."""

    explained: float
    kind: str
    k: int
    found: np.ndarray
    certain: float


def mismatch(sample, axis, noise):
    """The Mismatch of four steps or more of an axis of a Sample, else None.

    noise: a Noise.
    """
    steps = sample.codes[axis].steps
    if len(steps) < 4:
        return None
    wave, mean = sample.wave(axis)
    wave = wave * np.exp(2j * np.pi * sample.codes[axis].sines.offset)  # of step 0
    light = sample.images[list(steps)]
    one_surface = _on_one_surface(light, wave, sample.lit)
    found = np.argwhere(one_surface)
    if len(found) < MIN_PIXELS:
        return None
    some = found[:: -(-len(found) // PIXELS)].T
    usual = float(np.median(np.abs(wave[tuple(some)])))
    pixels = _pixels(light, wave, mean, some)
    harmonics = _harmonics(pixels, usual, LARGEST, pixels.at)
    variance = noise.at(pixels.mean).mean() * pixels.spare
    fits = [
        fit for k in range(len(steps)) for fit in _fits(pixels, k, harmonics, variance)
    ]
    best = max(fits, key=lambda fit: fit.explained)
    alike = [fit for fit in fits if fit.kind == best.kind]
    names = tuple(
        steps[fit.k] for fit in alike if fit.explained > AS_WELL * best.explained
    )
    if best.certain < SURE:
        best = best._replace(kind="", found=0 * best.found)
    change = best.found @ pixels.left(best.k)[1]
    periods = np.sqrt(np.mean(pixels.turned(best.k, change) ** 2))
    scatter, windows = None, _windows(one_surface)
    if windows[0].size:
        windows = _pixels(light, wave, mean, windows)
        x, y = windows.at
        every = _harmonics(windows, usual, LARGE, [x, y, x * x, x * y, y * y])
        scatter = scatter_of_steps(windows.light, every, noise.at(windows.mean))
    size = float(np.hypot(*best.found[1:]))
    if best.kind == LIGHT:
        # The fitted step has its share of the change.
        size = float(best.found[0] / (1 - (1 - 1 / pixels.spare) * best.found[0]))
    return Mismatch(best.kind, names, size, float(periods), scatter)


def _windows(one_surface):
    """(band, row, column) of pixels of some windows, three side by side each time."""
    three = one_surface[..., : -2 * WINDOW] & one_surface[..., 2 * WINDOW :]
    three &= one_surface[..., WINDOW:-WINDOW]
    middle = np.argwhere(three) + [0, 0, WINDOW]
    n, v, u = middle[:: 1 + len(middle) // WINDOWS].T[..., None, None]
    down, across = (np.arange(m * WINDOW) - m * WINDOW // 2 for m in (1, 3))
    return [
        part.ravel() for part in np.broadcast_arrays(n, v + down[:, None], u + across)
    ]


def _on_one_surface(light, wave, lit):
    """Lit pixels amid a window without a break, a clipped value or a band's border."""
    unit = wave / np.maximum(np.abs(wave), 1e-6)
    good = lit & (light.max(axis=0) < light.max())
    right = (unit[..., 1:] * unit[..., :-1].conj()).real > SMOOTH_TURN
    down = (unit[:, 1:] * unit[:, :-1].conj()).real > SMOOTH_TURN
    good[..., 1:] &= right
    good[:, 1:] &= down
    size = np.ones((WINDOW + 2,) * 2, np.uint8)
    bands = [cv2.erode(band.astype(np.uint8), size, borderValue=0) for band in good]
    return np.array(bands).astype(bool)


def _pixels(light, wave, mean, where):
    """_Pixels at (band, row, column) of bands."""
    n, v, u = where
    rows, width = wave.shape[1:]
    right, down = np.minimum(u + 1, width - 1), np.minimum(v + 1, rows - 1)
    slopes = [
        np.array(
            [
                (array[n, v, right] - array[n, v, u - 1]) / 2,
                (array[n, down, u] - array[n, v - 1, u]) / 2,
            ]
        )
        for array in (mean, wave)
    ]
    x, y = 2 * u / width - 1, 2 * (n * rows + v) / (len(wave) * rows) - 1
    steps = light[:, n, v, u], mean[n, v, u], wave[n, v, u]
    return _Pixels(*steps, *slopes, np.array([x, y]))


def _harmonics(pixels, usual, large, across):
    """(C, P): what even a smooth response leaves of N steps.

    The response's curve follows from modulation and mean, which scattered light and the
    angle at which a facet shows the monitor change one by one; the monitor's own curve
    changes with the angle, and so with the place in the image. large: the orders of
    which all that is looked for; blur leaves less of them the finer they are seen.
    across: how they may change with the place.
    """
    count = len(pixels.light)
    modulation = np.abs(pixels.wave)
    unit = pixels.wave / np.maximum(modulation, 1e-6)
    size, level = modulation / usual, pixels.mean / usual
    places = [1.0, size, level, size**2, size * level, level**2, *across]
    columns = []
    # Others are taken for the level or the phase itself.
    orders = [n for n in range(2, count + 3) if 1 < n % count < count - 1]
    for order in orders:
        for place in places if order in large else places[:2]:
            value = modulation * place * unit**order
            columns += [value.real, value.imag]
    return np.array(columns)


def _fits(pixels, k, harmonics, variance):
    """The change of light and the shift of step k that leave least."""
    value, changes = pixels.left(k)
    without, _, _ = _clipped_fit(value, harmonics)
    for kind, used in (LIGHT, [0]), (MOTION, [1, 2]):
        columns = np.concatenate([changes[used], harmonics])
        usual, found, inverse = _clipped_fit(value, columns)
        own = found[: len(used)]
        covariance = inverse[: len(used), : len(used)] * max(usual, variance)
        certain = np.sqrt(own @ np.linalg.solve(covariance, own))
        change = np.zeros(3)
        change[used] = own
        yield _Fit(without - usual, kind, k, change, certain)


def _clipped_fit(value, columns):
    """The variance that least squares leave, coefficients, and their covariance for
    values of variance 1; values that are far off do not count in a second fit."""
    kept = np.ones(len(value), bool)
    for _ in range(2):
        scale = np.sqrt(np.mean(columns**2, axis=1)) + 1e-9
        basis = columns[:, kept] / scale[:, None]
        normal = basis @ basis.T + 1e-9 * len(value) * np.eye(len(scale))
        inverse = np.linalg.inv(normal)
        found = inverse @ (basis @ value[kept]) / scale
        off = value - found @ columns
        usual = np.median(off**2) / OF_MEDIAN
        kept = off**2 < CLIPPED**2 * usual
    return usual, found, inverse / np.outer(scale, scale)
