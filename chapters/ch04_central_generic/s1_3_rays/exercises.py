"""Expected answers of the exercises of section 4.1.3."""

import numpy as np

NEAR_MM, FAR_MM = 300.0, 600.0
SIGMA_MM, POSE_MM = 0.5, 1.0


def image_noise_task():
    """The variance of a point grows with the square of its distance, so that length
    over variance falls as one over the distance."""
    return {
        "expected": lambda: FAR_MM / NEAR_MM,
        "hint": "how do length and variance grow with the distance?",
        "slips": {
            "That is the ratio of the variances.": lambda: (FAR_MM / NEAR_MM) ** 2,
            "The near point counts more.": lambda: NEAR_MM / FAR_MM,
        },
    }


def pose_task():
    """The variances of noise and pose add up; the weight is one over their sum."""
    return {
        "expected": lambda: 1 + (POSE_MM / SIGMA_MM) ** 2,
        "hint": "which variances does a point on the second grid have?",
        "slips": {
            "Add the noise of the point itself.": lambda: (POSE_MM / SIGMA_MM) ** 2,
            "Use variances, not standard deviations.": lambda: float(
                np.hypot(1, POSE_MM / SIGMA_MM)
            ),
        },
    }
