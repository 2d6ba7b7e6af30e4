"""The profiles of Appendix A: a sine with one further order."""

import numpy as np

from chapters.shared.grids import sum_of_orders

STEPS = (3, 4, 5, 6, 8)
PHASES = {"quick": 120, "full": 1440}
AMPLITUDES = (0.05, 0.1, 0.2, 0.3)
ODD_AMPLITUDES = (0.0, 0.005, 0.01, 0.02, 0.05)
# Up to this order, no two of the orders studied coincide in the error.
MAX_ORDER = 17
SMALL = 0.01


def one_order(order, kind, amplitude):
    """Return a sine with one further order of this share, sine or cosine."""
    if kind == "sine":
        return sum_of_orders({1: 1.0, order: amplitude})
    return sum_of_orders({1: 1.0}, {order: amplitude})


def phases(count):
    """Return phases (count,) over one period, rad."""
    return 2 * np.pi * (np.arange(count) + 0.5) / count


def error_orders(error):
    """Return the amplitude (n // 2 + 1,) per order of an error over a period, rad."""
    return 2 * np.abs(np.fft.rfft(error)) / len(error)
