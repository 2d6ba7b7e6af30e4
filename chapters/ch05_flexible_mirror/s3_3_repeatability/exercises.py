"""What the exercises of the page on repeated deflections compare an answer with."""

import numpy as np

STEPS, STEP_SD_MM = 6, 0.1
TURN_DEG, DISTANCE_MM = 0.4, 400.0
MOVED_MM, LEVER_MM = 0.2, 150.0


def drift_task():
    """Independent errors of six steps add in squares."""
    return {
        "expected": lambda: STEP_SD_MM * np.sqrt(STEPS),
        "hint": "variances of independent errors add",
        "slips": {
            "That would be errors that are all alike.": lambda: STEPS * STEP_SD_MM,
            "Their mean would be that; here they add.": lambda: (
                STEP_SD_MM / np.sqrt(STEPS)
            ),
        },
    }


def turned_rays_task():
    """All rays turned together miss a board in its true place by distance times angle,
    and one in a pose that is fitted to them by nothing of that."""
    return {
        "expected": lambda: DISTANCE_MM * np.radians(TURN_DEG),
        "hint": "a small angle in radians is arc over radius",
        "slips": {
            "The angle has to be in radians.": lambda: DISTANCE_MM * TURN_DEG,
            "That is how far off a pose found from the rays themselves would be seen "
            "to be: it takes the turn along.": lambda: 0.0,
        },
    }


def tip_task():
    """A mirror that turns by an angle turns its rays by twice as much."""
    angle = MOVED_MM / LEVER_MM
    return {
        "expected": lambda: float(np.degrees(2 * angle)),
        "hint": "first the turn of the mirror, then what a reflected ray makes of it",
        "slips": {
            "So far the mirror turns; the ray turns more.": lambda: float(
                np.degrees(angle)
            ),
            "The exercise asks for degrees.": lambda: 2 * angle,
        },
    }
