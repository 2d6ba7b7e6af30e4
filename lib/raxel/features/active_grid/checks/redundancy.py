"""Redundancy of phase steps: inconsistent steps, and the position errors they cause.

A sinusoid has three unknowns. N steps leave N - 3 residuals per pixel, for four steps
I0 - I1 + I2 - I3. A brighter or moved image leaves (N - 3) / N of its change in the
residuals and shifts the phase by 2 / N of it, divided by the modulation and in
quadrature. Harmonics of the response remain as well. They vary with the phase, with two
cycles or more, and are subtracted. Three steps leave no residual.
"""

from typing import NamedTuple

import cv2
import numpy as np
from scipy.special import chdtri

# Residuals of N >= 4 steps: correlated noise and drift of the light. The variance of
# the N - 3 residuals is that of grey values, for single pixels and for means over
# windows. Spatially correlated noise, as of the blocks of a JPEG file, averages out
# less than white noise, and windows measure how much. A drift of the light leaves
# residuals in proportion to the light. With the projection M and images I_j that are
# brighter by g_j, the sum of M_kj I_j / (1 + g_j) over j is only noise. Its square is a
# form of 1 / (1 + g_j), minimised by the eigenvector of the smallest eigenvalue.


WINDOW = 7
# For adjacent windows, left - 2 middle + right has six times the variance of one.
SECOND_DIFFERENCE_VARIANCE = 6
MIN_EIGENVALUE_SHARE = 0.02  # of the squared light; whole periods give five times more


class Scatter(NamedTuple):
    """Hold the scatter of steps.

    of_windows, of_one: variance of grey values, from means over windows and from single
    pixels, over that of white noise; drift: (N,) light of the steps over its mean,
    minus 1, 0 if unknown; periods: RMS position error by the drift.
    """

    of_windows: float
    of_one: float
    drift: np.ndarray
    periods: float

    def of(self, smooth):
        """Return the variance ratio of the values that give positions."""
        return self.of_windows if smooth else self.of_one


def sine_residuals(count):
    """Return (N, N): the projection that removes a sinusoid from the steps."""
    steps = 2 * np.pi / count * np.arange(count)
    return np.eye(count) - (1 + 2 * np.cos(steps[:, None] - steps)) / count


def step_scatter(light, harmonics, variance):
    """Return the Scatter of N steps of pixels.

    light: (N, P) of W groups of three adjacent windows, P = W x 7 x 21 in this order;
    harmonics: (C, P), residuals of a response; variance: (P,) of white noise.
    """
    count = len(light)
    residuals = sine_residuals(count)
    # By normal equations: many times faster than the decomposition of so many rows.
    harmonics = harmonics / np.linalg.norm(harmonics, axis=1, keepdims=True)
    fit = harmonics.T @ np.linalg.pinv(harmonics @ harmonics.T, 1e-10, hermitian=True)
    inner = light - (light @ fit) @ harmonics
    share = _shares(residuals * (inner @ inner.T), light)
    residual = residuals @ (share[:, None] * light)
    residual = residual - (residual @ fit) @ harmonics
    three = residual.reshape(count, -1, WINDOW, 3, WINDOW)
    means = three.mean(axis=(2, 4))
    bent = means[..., 0] - 2 * means[..., 1] + means[..., 2]
    degrees = chdtri(count - 3, 0.5)
    expected = variance.reshape(-1, WINDOW, 3, WINDOW).mean(axis=(1, 2, 3))
    windows = (
        np.sum(bent**2, axis=0) * WINDOW**2 / SECOND_DIFFERENCE_VARIANCE / expected
    )
    pixels = np.sum(residual**2, axis=0) / variance
    pixels = pixels.reshape(-1, 3 * WINDOW**2).mean(axis=1)
    turn = np.exp(-2j * np.pi * np.arange(count) / count)
    product = (turn * share) @ light * np.conj(turn @ light)
    periods = np.sqrt(np.mean((np.angle(product) / (2 * np.pi)) ** 2))
    return Scatter(
        float(np.median(windows) / degrees),
        float(np.median(pixels) / (count - 3)),
        1 / share - 1,
        float(periods),
    )


def _shares(form, light):
    """Return (N,) 1 / (1 + g_j) from the form; 1 if less than a period is visible.

    In that case the light of the steps resembles the residuals of a response.
    """
    sizes, vectors = np.linalg.eigh(form)
    share = vectors[:, 0] / vectors[:, 0].mean()
    if sizes[1] < MIN_EIGENVALUE_SHARE * np.mean(light**2) * light.shape[1]:
        return np.ones(len(light))
    return share


N_PIXELS, N_WINDOWS = 12_000, 800  # of the sample
MIN_N_PIXELS = 1000
MIN_NEIGHBOUR_COSINE = 0.5  # between neighbouring phases; below it there is a break
CLIP_SIGMAS = 4  # standard deviations; outliers are excluded from a second fit
MEDIAN_OF_SQUARE = 0.4549364  # the median of the square of a normal value
# Standard deviations of the fitted change: noise exceeds 8 with exp(-32). Unmodelled
# residuals of a response have a few.
MIN_SIGMAS = 8
TIE_RATIO = 0.98  # of the best explained variance: alternatives that are as likely
# Harmonics of powers; for means over windows also those of S-shaped curves.
PIXEL_ORDERS, WINDOW_ORDERS = (2,), (2, 3)
LIGHT, MOTION = "light", "motion"


class Mismatch(NamedTuple):
    """Hold the inconsistency of one image with the other steps of its axis.

    kind: LIGHT, MOTION, or "" if neither is certain; images: the image, or the
    candidates; size: relative light minus 1, or length of the shift in px; periods: RMS
    position error; scatter: of the residuals of all steps, None for small surfaces.
    """

    kind: str
    images: tuple[int, ...]
    size: float
    periods: float
    scatter: Scatter | None


class _Pixels(NamedTuple):
    """Hold P pixels of an axis' N steps.

    light: (N, P); mean: (P,); wave: (P,) complex; their slopes (2, P) along x and y;
    at: (2, P), image positions from -1 to 1.
    """

    light: np.ndarray
    mean: np.ndarray
    wave: np.ndarray
    of_mean: np.ndarray
    of_wave: np.ndarray
    at: np.ndarray

    @property
    def spare(self):
        """Return the variance of `residual` over that of a grey value."""
        return len(self.light) / (len(self.light) - 3)

    def residual(self, k):
        """Return the change (P,) of step k if the others are right, and derivatives.

        Derivatives (3, P): with respect to its light, and to shifts along x and y.
        """
        turn = np.exp(2j * np.pi * k / len(self.light))
        slopes = self.of_mean + (self.of_wave * turn).imag
        fitted = self.mean + (self.wave * turn).imag
        return (self.light[k] - fitted) * self.spare, np.stack([fitted, *slopes])

    def phase_shift(self, k, change):
        """Return the shift of the phase in periods by a change of step k."""
        count = len(self.light)
        own = self.wave * np.exp(2j * np.pi * k / count)
        return 2 / count * change * own.real / (np.abs(own) ** 2 + 1e-6) / (2 * np.pi)


class _Fit(NamedTuple):
    """Hold a change of step k.

    explained: variance that it explains; found: coefficients; certain: their distance
    from zero in standard deviations.
    """

    explained: float
    kind: str
    k: int
    found: np.ndarray
    certain: float


def mismatch(sample, axis, noise):
    """Return the Mismatch of the steps of an axis of a Sample, None below four steps.

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
    if len(found) < MIN_N_PIXELS:
        return None
    some = found[:: -(-len(found) // N_PIXELS)].T
    usual = float(np.median(np.abs(wave[tuple(some)])))
    pixels = _pixels(light, wave, mean, sample.x, some)
    harmonics = _harmonics(pixels, usual, PIXEL_ORDERS, pixels.at)
    variance = noise.at(pixels.mean).mean() * pixels.spare
    fits = [
        fit for k in range(len(steps)) for fit in _fits(pixels, k, harmonics, variance)
    ]
    best = max(fits, key=lambda fit: fit.explained)
    alike = [fit for fit in fits if fit.kind == best.kind]
    names = tuple(
        steps[fit.k] for fit in alike if fit.explained > TIE_RATIO * best.explained
    )
    if best.certain < MIN_SIGMAS:
        best = best._replace(kind="", found=0 * best.found)
    change = best.found @ pixels.residual(best.k)[1]
    periods = np.sqrt(np.mean(pixels.phase_shift(best.k, change) ** 2))
    scatter, windows = None, _windows(one_surface)
    if windows[0].size:
        windows = _pixels(light, wave, mean, sample.x, windows)
        x, y = windows.at
        every = _harmonics(windows, usual, WINDOW_ORDERS, [x, y, x * x, x * y, y * y])
        scatter = step_scatter(windows.light, every, noise.at(windows.mean))
    size = float(np.hypot(*best.found[1:]))
    if best.kind == LIGHT:
        # The fitted sinusoid contains its share of the change.
        size = float(best.found[0] / (1 - (1 - 1 / pixels.spare) * best.found[0]))
    return Mismatch(best.kind, names, size, float(periods), scatter)


def _windows(one_surface):
    """Return (band, row, column) of pixels of groups of three adjacent windows."""
    three = one_surface[..., : -2 * WINDOW] & one_surface[..., 2 * WINDOW :]
    three &= one_surface[..., WINDOW:-WINDOW]
    middle = np.argwhere(three) + [0, 0, WINDOW]
    n, v, u = middle[:: 1 + len(middle) // N_WINDOWS].T[..., None, None]
    down, across = (np.arange(m * WINDOW) - m * WINDOW // 2 for m in (1, 3))
    return [
        part.ravel() for part in np.broadcast_arrays(n, v + down[:, None], u + across)
    ]


def _on_one_surface(light, wave, lit):
    """Return lit pixels in a window without breaks, clipped values and borders."""
    unit = wave / np.maximum(np.abs(wave), 1e-6)
    good = lit & (light.max(axis=0) < light.max())
    right = (unit[..., 1:] * unit[..., :-1].conj()).real > MIN_NEIGHBOUR_COSINE
    down = (unit[:, 1:] * unit[:, :-1].conj()).real > MIN_NEIGHBOUR_COSINE
    good[..., 1:] &= right
    good[:, 1:] &= down
    size = np.ones((WINDOW + 2,) * 2, np.uint8)
    bands = [cv2.erode(band.astype(np.uint8), size, borderValue=0) for band in good]
    return np.array(bands).astype(bool)


def _pixels(light, wave, mean, columns, where):
    """Return _Pixels at (band, row, column) of bands."""
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
    y = 2 * (n * rows + v) / (len(wave) * rows) - 1
    steps = light[:, n, v, u], mean[n, v, u], wave[n, v, u]
    return _Pixels(*steps, *slopes, np.array([columns[n, u], y]))


def _harmonics(pixels, usual, large, across):
    """Return (C, P): the residuals that a smooth response leaves of N steps.

    The response's curve depends on modulation and mean, which scattered light and the
    viewing angle of a facet change independently. The monitor's own curve depends on
    the angle, and so on the image position. large: orders with all these dependencies;
    blur attenuates higher orders. across: dependence on the image position.
    """
    count = len(pixels.light)
    modulation = np.abs(pixels.wave)
    unit = pixels.wave / np.maximum(modulation, 1e-6)
    size, level = modulation / usual, pixels.mean / usual
    factors = [1.0, size, level, size**2, size * level, level**2, *across]
    columns = []
    # Other orders alias to the level or to the phase itself.
    orders = [n for n in range(2, count + 3) if 1 < n % count < count - 1]
    for order in orders:
        for factor in factors if order in large else factors[:2]:
            value = modulation * factor * unit**order
            columns += [value.real, value.imag]
    return np.array(columns)


def _fits(pixels, k, harmonics, variance):
    """Yield the change of light and the shift of step k with the least residual."""
    value, changes = pixels.residual(k)
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
    """Return residual variance, coefficients, and their covariance at unit variance.

    Outliers are excluded from a second fit.
    """

    kept = np.ones(len(value), bool)
    for _ in range(2):
        scale = np.sqrt(np.mean(columns**2, axis=1)) + 1e-9
        basis = columns[:, kept] / scale[:, None]
        normal = basis @ basis.T + 1e-9 * len(value) * np.eye(len(scale))
        inverse = np.linalg.inv(normal)
        found = inverse @ (basis @ value[kept]) / scale
        residuals = value - found @ columns
        usual = np.median(residuals**2) / MEDIAN_OF_SQUARE
        kept = residuals**2 < CLIP_SIGMAS**2 * usual
    return usual, found, inverse / np.outer(scale, scale)
