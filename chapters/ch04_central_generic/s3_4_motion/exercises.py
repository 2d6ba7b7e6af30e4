"""Expected answers of the exercises on motion."""

import numpy as np

SHIFT_MM, AWAY_MM = 20.0, 300.0


def freedom_task():
    """Three parameters of the rotation, and two of the direction of t: rays do not
    determine its length."""
    return {
        "expected": lambda: 5,
        "hint": "do the rays determine the length of t?",
        "slips": {
            "Rays do not determine the length of t.": lambda: 6,
            "That is the number of entries of E up to scale.": lambda: 8,
        },
    }


def parallax_task():
    """The motion is perpendicular to the line of sight: the tangent is 20 / 300."""
    return {
        "expected": lambda: np.degrees(np.arctan(SHIFT_MM / AWAY_MM)),
        "hint": "draw the triangle of the camera and both positions of the point",
        "slips": {"That is in radians.": lambda: np.arctan(SHIFT_MM / AWAY_MM)},
    }
