"""Expected answers of the exercises on ray-point errors."""

import numpy as np

NEAR_MM, STEP_MM, SD_MM = 40.0, 20.0, 0.04


def lever_task():
    """A line through three points is extrapolated to the centre: its variance there is
    that of the mean, plus that of the slope times the squared distance."""
    distances = NEAR_MM + STEP_MM * np.arange(3)
    middle = distances.mean()
    spread = np.sum((distances - middle) ** 2)
    return {
        "expected": lambda: SD_MM * np.sqrt(1 / 3 + middle**2 / spread),
        "hint": "what is the variance of a fitted line far from its points?",
        "slips": {
            "That is the error of the mean, at the points.": lambda: SD_MM / np.sqrt(3),
            "The mean has an error too.": lambda: SD_MM * middle / np.sqrt(spread),
        },
    }


def kurtosis_task():
    """Mardia's kurtosis of a d-dimensional Gaussian is d (d + 2)."""
    return {
        "expected": lambda: 3 * 5,
        "hint": "the fourth moment of the length of a standard Gaussian vector",
        "slips": {
            "That is the value in two dimensions.": lambda: 2 * 4,
            "That is the value in one dimension.": lambda: 3,
        },
    }
