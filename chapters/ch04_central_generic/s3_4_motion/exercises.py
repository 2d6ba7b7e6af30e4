"""What the exercises of the page on motion compare an answer with."""

import numpy as np

SHIFT_MM, AWAY_MM = 20.0, 300.0
STEPS, STEP_ERROR_DEG = 11, 0.1


def freedom_task():
    """Three numbers of the rotation, and two of the direction of t: its length does
    not show."""
    return {
        "expected": lambda: 5,
        "hint": "how long is t, as far as the rays tell?",
        "slips": {
            "The length of t does not show in rays.": lambda: 6,
            "That is the number of entries but for their scale.": lambda: 8,
        },
    }


def parallax_task():
    """The shift is across the line of sight: its tangent is 20 over 300."""
    return {
        "expected": lambda: np.degrees(np.arctan(SHIFT_MM / AWAY_MM)),
        "hint": "draw the triangle of camera and both places of the point",
        "slips": {"That is in radians.": lambda: np.arctan(SHIFT_MM / AWAY_MM)},
    }
