"""What the exercises of this page compare an answer with."""

import numpy as np


def rays_task():
    """An error that comes from independent noise shrinks as one over the root of the
    number of rays."""
    return {
        "expected": lambda: np.sqrt(100 / 3000),
        "hint": "how does a mean of independent errors shrink?",
        "slips": {
            "That is how the variance shrinks.": lambda: 100 / 3000,
            "The error gets smaller with more rays.": lambda: np.sqrt(3000 / 100),
        },
    }


def coefficients_task():
    """A homography has nine entries up to one common factor; V and W found apart have
    six each up to a factor each."""
    return {
        "expected": lambda: 2 * (6 - 1) - (9 - 1),
        "hint": "count the free numbers on both sides, without common factors",
        "slips": {
            "Each vector is known up to a factor of its own.": lambda: 12 - 9,
            "The homography, too, is known up to a factor.": lambda: 10 - 9,
        },
    }
