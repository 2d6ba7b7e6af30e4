"""Expected answers of the exercises of section 2.5.3."""

import numpy as np

from chapters.shared.general import HALF_VIEW_DEG

WIDTH_PX = 1024
PITCH_DEG, IMAGED_AT = 14.0, 0.5
# Of the corrected images.
FOCAL_PX = (WIDTH_PX - 1) / 2 / np.tan(np.radians(HALF_VIEW_DEG))
# Verticals meet at the vanishing point (0, -1 / tan(pitch)) or (0, 1 / tan).
LEAN_DEG = np.degrees(np.arctan(IMAGED_AT * np.tan(np.radians(PITCH_DEG))))


def focal_task():
    """Half the width is f times the tangent of the angle to each side. The code counts
    from centre to centre of the outermost pixels; from edge to edge is 0.1 % more."""
    return {
        "expected": lambda: FOCAL_PX,
        "hint": "draw the triangle of projection centre, image centre and image edge",
        "slips": {
            "That is the whole width for half the angle.": lambda: 2 * FOCAL_PX,
            "That is an equidistance lens, not a pinhole.": lambda: (
                (WIDTH_PX - 1) / 2 / np.radians(HALF_VIEW_DEG)
            ),
        },
    }


def lean_task():
    """The line runs to the vanishing point, x to the side and 1 / tan(pitch) up or
    down: its lean has the tangent x tan(pitch)."""
    return {
        "expected": lambda: LEAN_DEG,
        "hint": "where do the images of all verticals meet?",
        "slips": {
            "That is in radians.": lambda: np.radians(LEAN_DEG),
            "That is off horizontal.": lambda: 90 - LEAN_DEG,
            "Half the tangent is not half the angle.": lambda: PITCH_DEG * IMAGED_AT,
        },
    }
