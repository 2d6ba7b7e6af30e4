"""Expected answers of the exercises on repeated deflections."""

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
            "That holds for equal errors.": lambda: STEPS * STEP_SD_MM,
            "That is the SD of their mean; here they add.": lambda: (
                STEP_SD_MM / np.sqrt(STEPS)
            ),
        },
    }


def turned_rays_task():
    """Rays rotated together miss a board in its true pose by distance times angle, and
    do not miss it in a pose that is fitted to them."""
    return {
        "expected": lambda: DISTANCE_MM * np.radians(TURN_DEG),
        "hint": "a small angle in radians is arc over radius",
        "slips": {
            "The angle has to be in radians.": lambda: DISTANCE_MM * TURN_DEG,
            "That holds for a pose fitted to the rays themselves, which absorbs the "
            "rotation.": lambda: 0.0,
        },
    }


def tip_task():
    """A rotation of the mirror rotates its rays by twice the angle."""
    angle = MOVED_MM / LEVER_MM
    return {
        "expected": lambda: float(np.degrees(2 * angle)),
        "hint": "first the rotation of the mirror, then that of the reflected ray",
        "slips": {
            "That is the mirror's rotation; the ray rotates more.": lambda: float(
                np.degrees(angle)
            ),
            "The exercise requires degrees.": lambda: 2 * angle,
        },
    }
