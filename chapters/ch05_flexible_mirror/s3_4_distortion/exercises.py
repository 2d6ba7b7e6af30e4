"""Answers to the exercises of the page on distortion correction."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_4_distortion.experiment import RADIUS_MM
from chapters.shared.mirror import BACK_PROJECTION_MM

ROTATION_DEG, RELIEF_MM, BETWEEN_DEG = 0.2, 20.0, 10.0


def shifted_task():
    """Rotating all rays by one angle moves a circle and keeps its radius."""
    return {
        "expected": lambda: BACK_PROJECTION_MM * np.tan(np.radians(ROTATION_DEG)),
        "hint": "an angle in radians times the distance from mirror to board",
        "slips": {
            "Convert degrees to radians.": lambda: BACK_PROJECTION_MM * ROTATION_DEG,
            "Rays rotate about the mirror, not about the circle's centre.": (
                lambda: RADIUS_MM * np.tan(np.radians(ROTATION_DEG))
            ),
        },
    }


def relief_task():
    """A point in front of the assumed plane is displaced on it."""
    return {
        "expected": lambda: RELIEF_MM * np.tan(np.radians(BETWEEN_DEG)),
        "hint": "distance between the two rays after they pass through the relief",
        "slips": {
            "The angle is between the rays, not half of it.": lambda: (
                RELIEF_MM * np.tan(np.radians(BETWEEN_DEG / 2))
            ),
            "Only the height above the plane counts, not the whole depth.": lambda: (
                BACK_PROJECTION_MM * np.tan(np.radians(BETWEEN_DEG))
            ),
        },
    }
