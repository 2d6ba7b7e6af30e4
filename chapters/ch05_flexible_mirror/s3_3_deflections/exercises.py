"""Expected answers of the exercises on three deflections."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_deflections.report import (
    STEP_MM,
    by_formula,
    camera_mm,
)
from chapters.shared.mirror import BACK_PROJECTION_MM, DYNAMIC_MM

ANGLE_DEG = 0.2


def linear_task():
    """The linear stage finds Z / (Z + D) of 5 mm, with the distances of rig A."""
    return {
        "expected": lambda: STEP_MM * by_formula(),
        "hint": "Z is the board's distance from the mirror, D the camera's",
        "slips": {
            "That is the part that the linear stage misses.": lambda: (
                STEP_MM * (1 - by_formula())
            ),
            "The denominator is the sum of both distances.": lambda: (
                STEP_MM * DYNAMIC_MM / camera_mm()
            ),
        },
        "tolerance": 0.03,
    }


def ray_task():
    """A rotated ray misses by its length times the angle."""
    return {
        "expected": lambda: BACK_PROJECTION_MM * np.tan(np.radians(ANGLE_DEG)),
        "hint": "the angle in radians times the distance from mirror to board",
        "slips": {
            "Convert degrees to radians.": lambda: BACK_PROJECTION_MM * ANGLE_DEG,
            "Half of that angle is the mirror's error; the ray has all of it.": (
                lambda: BACK_PROJECTION_MM * np.tan(np.radians(ANGLE_DEG / 2))
            ),
        },
    }
