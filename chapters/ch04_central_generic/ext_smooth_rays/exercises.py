"""What the exercises of this page compare an answer with."""

import numpy as np


def controls_task():
    """A cubic spline on n cells has n + 3 control values each way, for two
    coordinates."""
    return {
        "expected": lambda: 2 * (8 + 3) ** 2,
        "hint": "how many cubic pieces have a share in one cell, each way?",
        "slips": {
            "The field has two coordinates.": lambda: (8 + 3) ** 2,
            "Cells at the rim have shares in values beyond it.": lambda: 2 * 8**2,
        },
    }


def averaging_task():
    """Independent errors of rays average out: the variance of a fit is the noise's,
    times the number of parameters over the number of measured values."""
    return {
        "expected": lambda: 0.29 * np.sqrt(49 / 999),
        "hint": "how much of the noise's variance do 49 parameters keep of 999 values?",
        "slips": {
            "That is the share of the variance.": lambda: 0.29 * 49 / 999,
            "The more values, the less noise is left.": lambda: (
                0.29 * np.sqrt(999 / 49)
            ),
        },
    }
