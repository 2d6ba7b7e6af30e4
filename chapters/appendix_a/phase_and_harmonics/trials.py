"""The profiles of Appendix A, and how far each of them sends a phase astray."""

import numpy as np

from chapters.shared.phase_steps import (
    clipped_power_law,
    decoder_error,
    formula_error,
    largest,
    orders,
    power_law,
    predicted_error,
    srgb_profile,
    sum_of_orders,
)

STEPS = (3, 4, 5, 6, 8)
GAMMAS = {
    "quick": [1.0, 1.5, 1.8, 2.2, 2.6],
    "full": [round(1.0 + 0.1 * k, 1) for k in range(17)],
}
# The contrast is set too high, about the middle: both ends are cut off.
GAIN = 1.15
PHASES = {"quick": 120, "full": 1440}
AMPLITUDES = (0.05, 0.1, 0.2, 0.3)
ODD_AMPLITUDES = (0.0, 0.005, 0.01, 0.02, 0.05)
# Up to this order no two of them that are looked at fall together in the error.
MOST_ORDER = 17
SMALL = 0.01
# Orders of a response that are kept for the prediction: the rest of a clipped
# profile is below 1e-4 of the first.
KEPT_ORDERS = 401


def one_order(order, kind, amplitude):
    """A sine with one further order of this share, sine or cosine."""
    if kind == "sine":
        return sum_of_orders({1: 1.0, order: amplitude})
    return sum_of_orders({1: 1.0}, {order: amplitude})


def profile_of(response):
    """The profile of a condition: {"law": power, clipped or sRGB, "gamma": ...}."""
    if response["law"] == "sRGB":
        return srgb_profile
    if response["law"] == "clipped":
        return clipped_power_law(response["gamma"], GAIN)
    return power_law(response["gamma"])


def phases(count):
    """Phases (count,) over one period, rad."""
    return 2 * np.pi * (np.arange(count) + 0.5) / count


def error_orders(error):
    """Amplitude of each order (n // 2 + 1,) of an error over one period, rad."""
    return 2 * np.abs(np.fft.rfft(error)) / len(error)


def response_trial(condition, rng):
    """Phase error of one response with N steps: decoder, formula and prediction."""
    profile = profile_of(condition)
    count, samples = condition["steps"], condition["phases"]
    phase, decoded = decoder_error(profile, count, samples)
    a, b = orders(profile, KEPT_ORDERS, 8192)
    predicted = predicted_error(a, b, count, phase)
    share = np.hypot(a, b) / np.hypot(a[1], b[1])
    return {
        "decoder_rad": largest(decoded),
        "formula_rad": largest(formula_error(profile, count, phase)),
        "predicted_rad": largest(predicted),
        "apart_rad": largest(decoded - predicted),
        "orders": {f"{n}": float(share[n]) for n in range(2, 8)},
        "error": decoded.astype(np.float32),
    }
