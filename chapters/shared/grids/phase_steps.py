"""Profiles of a monitor's sines: stepped, decoded, and taken apart into Fourier orders.

A profile is a function of the phase phi (radians, any shape) that returns grey values.
Step k of N shows profile(phi + 2 pi k / N), as (A.3) to (A.6) have it for four.
"""

import math

import numpy as np

from raxel.features.active_grid import decode, phase_weights
from raxel.sets import ActiveGrid, PatternPlan, patterns_of

# Images of 16 bits, so that rounding is far below the errors sought.
TOP = 65535
RANGE = (0.1, 0.9)
STRIP_ROWS = 8


def stepped(profile, count, phase):
    """The grey values (count, ...) of all steps at phases (...), rad."""
    shift = 2 * np.pi * np.arange(count) / count
    return np.array([profile(phase + s) for s in shift])


def phase_of(steps):
    """Phase (...) in rad by (3.23), four quadrants, of steps (N, ...).

    The weights are the decoder's own; here they act on float64, without rounding.
    """
    sine, cosine, _ = phase_weights(len(steps))
    return np.arctan2(np.tensordot(sine, steps, 1), np.tensordot(cosine, steps, 1))


def wrapped(angle):
    """The same angle from -pi to pi, rad."""
    return np.angle(np.exp(1j * np.asarray(angle)))


def formula_error(profile, count, phase):
    """Decoded less true phase, rad, by (3.23) in float64."""
    return wrapped(phase_of(stepped(profile, count, phase)) - phase)


def decoder_error(profile, count, samples):
    """Phases (samples,) and decoded less true phase, rad, by `active_grid.decode`.

    The images contain one period; the profile is scaled to fit their 16 bits, which
    changes no phase. A pixel without a location is nan.
    """
    monitor = ActiveGrid((samples, STRIP_ROWS))
    patterns = patterns_of(PatternPlan(phase_steps=count, phase_periods=(1.0, 0.0)))
    phase = 2 * np.pi * (np.arange(samples) + 0.5) / samples
    steps = stepped(profile, count, phase)
    low, high = steps.min(), steps.max()
    share = RANGE[0] + (RANGE[1] - RANGE[0]) * (steps - low) / (high - low)
    lines = np.rint(TOP * share).astype(np.uint16)
    images = np.repeat(lines[:, None], STRIP_ROWS, axis=1)
    found = decode(
        images, patterns, monitor,
        smooth=False, margin_px=0, noise=1.0, linear=True, threads=1,
    )  # fmt: skip
    place = found.location[STRIP_ROWS // 2, :, 0].astype(float)
    return phase, wrapped(2 * np.pi * place / samples - phase)


def orders(profile, most, samples=4096):
    """Fourier terms a_n (cosine), b_n (sine) of (A.1), n = 0 to most."""
    values = profile(2 * np.pi * np.arange(samples) / samples)
    terms = 2 * np.fft.rfft(values)[: most + 1] / samples
    return terms.real, -terms.imag


def sum_of_orders(sines, cosines=None, mean=0.0):
    """The profile with these amplitudes, {order: amplitude}, about `mean`."""
    cosines = cosines or {}

    def profile(phase):
        value = mean + np.zeros_like(phase)
        for n, b in sines.items():
            value = value + b * np.sin(n * phase)
        for n, a in cosines.items():
            value = value + a * np.cos(n * phase)
        return value

    return profile


def power_law(gamma):
    """A sine, 0 to 1, as shown by a monitor with this gamma."""
    return lambda phase: (0.5 + 0.5 * np.sin(phase)) ** gamma


def srgb(value):
    """Light, 0 to 1, of a value of the sRGB standard (IEC 61966-2-1)."""
    value = np.asarray(value, float)
    upper = ((np.maximum(value, 0) + 0.055) / 1.055) ** 2.4
    return np.where(value <= 0.04045, value / 12.92, upper)


def power_law_orders(gamma, most):
    """Amplitude of orders 1 to most of `power_law`, as shares of the first.

    Order n is a sine or a cosine of n phi, of either sign, so that all are largest
    where the light is. In closed form A_(n+1) / A_n = (gamma - n) / (gamma + n + 1).
    """
    ratios = [(gamma - n) / (gamma + n + 1) for n in range(1, most)]
    return np.cumprod([1.0, *ratios])


def largest(error):
    """The largest magnitude, ignoring pixels without a location; nan if none has."""
    error = np.asarray(error)
    good = np.isfinite(error)
    return float(np.abs(error[good]).max()) if good.any() else math.nan
