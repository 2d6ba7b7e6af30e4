"""Expected answers of the exercises on lens models."""

import numpy as np


def pupil_task():
    """z0 = a1 theta^2 + a2 theta^4, in mm, with theta in radians."""
    theta = np.radians(80.0)
    return {
        "expected": lambda: 4.0 * theta**2 + theta**4,
        "hint": "angles in the formula are radians",
        "slips": {
            "Use radians instead of degrees.": lambda: 4.0 * 80.0**2 + 80.0**4,
            "That is the second term alone.": lambda: theta**4,
        },
    }
