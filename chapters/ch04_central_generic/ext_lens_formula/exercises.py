"""What the exercises of this page compare an answer with."""

import numpy as np


def pupil_task():
    """z0 = a1 theta^2 + a2 theta^4, in mm, with theta in radians."""
    theta = np.radians(80.0)
    return {
        "expected": lambda: 4.0 * theta**2 + theta**4,
        "hint": "angles in the formula are radians",
        "slips": {
            "Degrees went in where radians belong.": lambda: 4.0 * 80.0**2 + 80.0**4,
            "That is the second term alone.": lambda: theta**4,
        },
    }


def near_task():
    """Seen from the axis, a shift z0 across the line of sight is z0 sin(theta); at the
    distance d that is an angle z0 sin(theta) / d, and f px for each radian."""
    theta = np.radians(60.0)
    turn = 5.0 * np.sin(theta) * (1 / 300.0 - 1 / 3000.0)
    return {
        "expected": lambda: 290.0 * turn,
        "hint": "a central camera can be right at one distance; what is left is "
        "the difference of two angles",
        "slips": {
            "The shift along the axis is not all across the ray.": lambda: (
                290.0 * 5.0 * (1 / 300.0 - 1 / 3000.0)
            ),
            "A central camera that is right far away is meant.": lambda: (
                290.0 * 5.0 * np.sin(theta) / 300.0
            ),
        },
        "tolerance": 0.03,
    }
