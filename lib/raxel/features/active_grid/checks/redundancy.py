"""What the steps of a sine say against each other, and how wrong places are by it.

A sine has three unknowns; of N steps, N - 3 numbers a pixel are left, for four steps
I0 - I1 + I2 - I3. A picture that is brighter than the others, moved or spoilt leaves
(N - 3) / N of what was done to it there, and turns the phase by 2 / N of that, over the
modulation and in quadrature. Harmonics of the response are left as well: they follow
the phase, two turns or more for one, and are taken off.

Of three steps nothing is left. But they add up to three times what half the sum of a
picture of the Gray code and its inverse is, and what is done to one of them is missing
there, up to an even share of it.
"""

from typing import NamedTuple

import cv2
import numpy as np

from raxel.features.active_grid.checks.scatter import WINDOW, Scatter, scatter_of_steps

PIXELS, WINDOWS = 12_000, 800  # looked at
MIN_PIXELS = 1000
SMOOTH_TURN = 0.5  # of the cosine: neighbours further apart lie across a break
CLEAR = 0.75  # of the contrast: far from the edges of a code, where sums are plain
CLIPPED = 4  # deviations: what is further off is left out of a second fit
OF_MEDIAN = 0.4549364  # the median of the square of a normal value
# Standard deviations of what was fitted: noise reaches a shift of 8 by exp(-32). What a
# response leaves and no column describes is a few.
SURE = 8
AS_WELL = 0.98  # of what the best one explains: it may be that one
# Of the variance of windows: 3.6 times the deviation of a median of WINDOWS squares,
# which noise passes twice in 10 000.
MORE_THAN_NOISE = 0.3
# Harmonics of powers; those of curves like an S as well, for means over windows.
LARGEST, LARGE = (2,), (2, 3)
LIGHT, MOTION = "light", "motion"


class Mismatch(NamedTuple):
    """One picture against the other steps of its axis, as far as that can be told.

    kind: LIGHT, MOTION, or "" where neither is certain; pictures: which one, or those
    of which it is one; size: light over that of the others less 1, or length of the
    shift in px, and `spread`, its standard deviation. periods: RMS of the error of
    places by it, and by what neither of the two explains; by_one: by it alone. scatter:
    a Scatter of four steps and more, else None.
    """

    kind: str
    pictures: tuple[int, ...]
    size: float
    spread: float
    periods: float
    by_one: float
    scatter: Scatter | None


class _Pixels(NamedTuple):
    """P pixels of an axis' N steps: light (N, P), mean (P,), wave (P,) complex, their
    slopes (2, P) along x and y; at: (2, P), from -1 to 1; harmonics (C, P); plain:
    (P,), the light without a pattern where there are three steps, else None; spare:
    variance of `left`."""

    light: np.ndarray
    mean: np.ndarray
    wave: np.ndarray
    of_mean: np.ndarray
    of_wave: np.ndarray
    at: np.ndarray
    harmonics: np.ndarray
    plain: np.ndarray | None
    spare: float

    def left(self, k):
        """Of step k, what was done to it if nothing was to the others; and what a
        change of its light by 1, and shifts by 1 px along x and y would be: (P,),
        (3, P)."""
        count = len(self.light)
        turn = np.exp(2j * np.pi * k / count)
        slopes = self.of_mean + (self.of_wave * turn).imag
        if self.plain is None:
            fitted = self.mean + (self.wave * turn).imag
            value = (self.light[k] - fitted) * self.spare
        else:
            value = self.light.sum(axis=0) - count * self.plain
            # Less what of its noise is in that.
            fitted = self.light[k] - value / self.spare
        return value, np.stack([fitted, *slopes])

    def turned(self, k, change):
        """Periods by which a change of step k turns the phase."""
        count = len(self.light)
        own = self.wave * np.exp(2j * np.pi * k / count)
        return 2 / count * change * own.real / (np.abs(own) ** 2 + 1e-6) / (2 * np.pi)


class _Fit(NamedTuple):
    """A kind of change of step k: what it explains of the variance, coefficients with
    their SD, how many SD all of them are from none, and harmonics with them."""

    explained: float
    kind: str
    k: int
    found: np.ndarray
    sd: np.ndarray
    certain: float
    harmonics: np.ndarray

    def change(self, pixels):
        """(P,) grey levels."""
        return self.found @ pixels.left(self.k)[1]


def mismatch(sample, axis, noise):
    """The Mismatch of the steps of an axis of a Sample, or None where nothing is known.

    That is of three steps without a Gray code with its inverse. noise: a Noise.
    """
    steps = sample.codes[axis].steps
    count = len(steps)
    if count < 3:
        return None
    wave, mean = sample.wave(axis)
    wave = wave * np.exp(2j * np.pi * sample.codes[axis].sines.offset)  # of step 0
    light = sample.pictures[list(steps)]
    lit, plain, spare = sample.lit, None, count / max(count - 3, 1)
    if count == 3:
        plain, sums = _plain_light(sample)
        lit = lit & (sums > 0)
        spare = 3 + 9 / (2 * max(np.median(sums[sample.lit]), 1))
    one_surface = _on_one_surface(light, wave, lit)
    some, usual = _some(one_surface, wave)
    if some is None:
        return None
    pixels = _pixels(light, wave, mean, some, usual, (plain, spare))
    variance = noise.at(pixels.mean).mean() * spare
    fits = [fit for k in range(count) for fit in _fits(pixels, k, variance)]
    best = max(fits, key=lambda fit: fit.explained)
    alike = [fit for fit in fits if fit.kind == best.kind]
    names = tuple(
        steps[fit.k] for fit in alike if fit.explained > AS_WELL * best.explained
    )
    if best.certain < SURE:
        best = best._replace(kind="", found=0 * best.found)
    by_one = np.sqrt(np.mean(pixels.turned(best.k, best.change(pixels)) ** 2))
    windows, error, scatter = _windows(one_surface), by_one, None
    if windows[0].size:
        windows = _pixels(light, wave, mean, windows, usual, (plain, spare))
        error = np.hypot(error, _unexplained(best, windows, variance))
        if count > 3:
            white = noise.at(windows.mean)
            x, y = windows.at
            every = _harmonics(windows, usual, LARGE, [x, y, x * x, x * y, y * y])
            scatter = scatter_of_steps(windows.light, every, white)
    found = best.kind, names, *_size(best, spare)
    return Mismatch(*found, float(error), float(by_one), scatter)


def axis_pixels(sample, axis, every, reach):
    """Pixels of an axis of a Sample with four steps or more, each `every`-th that
    `mismatch` takes, with slopes from `reach` px before them to as many behind; None of
    too few."""
    steps = sample.codes[axis].steps
    wave, mean = sample.wave(axis)
    wave = wave * np.exp(2j * np.pi * sample.codes[axis].sines.offset)
    light = sample.pictures[list(steps)]
    some, usual = _some(_on_one_surface(light, wave, sample.lit), wave)
    if some is None:
        return None
    spare = len(steps) / (len(steps) - 3)
    some = some[:, ::every]
    return _pixels(light, wave, mean, some, usual, (None, spare), reach)


def _some(good, wave):
    """An index of PIXELS pixels that count, or of all, and their usual modulation;
    None of too few."""
    found = np.argwhere(good)
    if len(found) < MIN_PIXELS:
        return None, None
    usual = float(np.median(np.abs(wave[tuple(found.T)])))
    return found[:: -(-len(found) // PIXELS)].T, usual


def _size(fit, spare):
    """Of a change, as in Mismatch, and its standard deviation."""
    if fit.kind == LIGHT:
        # The fitted step has its share of the change.
        return float(fit.found[0] / (1 - (1 - 1 / spare) * fit.found[0])), float(
            fit.sd[0]
        )
    shift = fit.found[1:]
    return float(np.hypot(*shift)), float(fit.sd[1 + np.argmax(np.abs(shift))])


def _plain_light(sample):
    """The light of each pixel without a pattern, and of how many sums it is a mean."""
    total, count = np.zeros_like(sample.high), np.zeros_like(sample.high)
    for axis, code in enumerate(sample.codes):
        for bit, (light, dark) in enumerate(code.bits):
            if dark is not None:
                clear = np.abs(sample.apart(axis, bit)) > CLEAR
                both = sample.pictures[light] + sample.pictures[dark]
                total += clear * both / 2
                count += clear
    return total / np.maximum(count, 1), count


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


def _pixels(light, wave, mean, where, usual, beside, reach=1):
    """_Pixels at (band, row, column) of bands; usual: a modulation, as a unit."""
    n, v, u = where
    rows, width = wave.shape[1:]
    right, down = np.minimum(u + reach, width - 1), np.minimum(v + reach, rows - 1)
    slopes = [
        [
            (array[n, v, right] - array[n, v, u - reach]) / (2 * reach),
            (array[n, down, u] - array[n, v - reach, u]) / (2 * reach),
        ]
        for array in (mean, wave)
    ]
    own, (plain, spare) = wave[n, v, u], beside
    x, y = 2 * u / width - 1, 2 * (n * rows + v) / (len(wave) * rows) - 1
    slopes = map(np.array, slopes)
    steps = light[:, n, v, u], mean[n, v, u], own, *slopes, np.array([x, y])
    if plain is None:
        pixels = _Pixels(*steps, own[:0], None, spare)
        own = _harmonics(pixels, usual, LARGEST, pixels.at)
        return pixels._replace(harmonics=own)
    plain = plain[n, v, u]
    harmonics = _of_three(own, x, y, plain, usual)
    return _Pixels(*steps, harmonics, plain, spare)


def _harmonics(pixels, usual, large, across):
    """(C, P): what even a smooth response leaves of N steps.

    The response's curve follows from modulation and mean, which scattered light and the
    angle at which a facet shows the monitor change one by one; the monitor's own curve
    changes with the angle, and so with the place in the picture. large: the orders of
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


def _of_three(wave, x, y, plain, usual):
    """(C, P): what a smooth response leaves of the sum of three steps.

    A changed step changes modulation and mean of the three, but not the plain light.
    """
    third = wave**3 / np.maximum(np.abs(wave), 1e-6) ** 2
    shares = [1.0, plain / usual, x, y, x * x, x * y, y * y]
    return np.array([*(plain * share for share in shares), third.real, third.imag])


def _fits(pixels, k, variance):
    """The change of light and the shift of step k that leave least."""
    value, changes = pixels.left(k)
    without, _, _ = clipped_fit(value, pixels.harmonics)
    for kind, used in (LIGHT, [0]), (MOTION, [1, 2]):
        columns = np.concatenate([changes[used], pixels.harmonics])
        usual, found, inverse = clipped_fit(value, columns)
        own, rest = found[: len(used)], found[len(used) :]
        covariance = inverse[: len(used), : len(used)] * max(usual, variance)
        certain = np.sqrt(own @ np.linalg.solve(covariance, own))
        both = np.zeros((2, 3))
        both[:, used] = own, np.sqrt(np.diag(covariance))
        yield _Fit(without - usual, kind, k, *both, certain, rest)


def clipped_fit(value, columns):
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


def _unexplained(fit, pixels, variance):
    """The error of places, in periods, by what windows hold beyond fit and noise.

    pixels: of three windows side by side. Their second difference is blind to what
    harmonics leave over many pixels.
    """
    value, changes = pixels.left(fit.k)
    rest = value - fit.found @ changes - fit.harmonics @ pixels.harmonics
    left, middle, right = rest.reshape(-1, WINDOW, 3, WINDOW).mean(axis=(1, 3)).T
    of_one = np.median((left - 2 * middle + right) ** 2) / OF_MEDIAN / 6
    due = variance / WINDOW**2
    if of_one - due < MORE_THAN_NOISE * due:
        return 0.0
    return np.sqrt((of_one - due) * np.median(pixels.turned(fit.k, 1.0) ** 2))
