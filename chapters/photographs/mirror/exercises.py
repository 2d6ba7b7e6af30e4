"""The exercise of a mirror set's page."""

import numpy as np

END_MM, LENGTH_MM, DEFLECTED_MM = 120.0, 150.0, 5.0


def end_task():
    """Beam (5.1): moved by v x^2 (3 m - x) / (2 m^3) at x from the clamp."""
    share = END_MM / LENGTH_MM
    return {
        "expected": lambda: DEFLECTED_MM * share**2 * (3 - share) / 2,
        "hint": "what (5.1) makes of x, with the deflection v at the length m",
        "slips": {
            "A sheet that only turned would move so.": lambda: DEFLECTED_MM * share,
            "That is at the load itself.": lambda: np.float64(DEFLECTED_MM),
        },
    }
