"""What the exercises of the page on distortion correction compare an answer with."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_4_distortion.trials.target import RADIUS_MM
from chapters.shared.mirror_rigs import BACK_PROJECTION_MM

TURN_DEG, RELIEF_MM, ASIDE_DEG = 0.2, 20.0, 10.0


def shifted_task():
    """All rays turned by the same angle move a circle; its radius stays."""
    return {
        "expected": lambda: BACK_PROJECTION_MM * np.tan(np.radians(TURN_DEG)),
        "hint": "an angle in radians times the way from mirror to board",
        "slips": {
            "Degrees have to be turned into radians.": lambda: (
                BACK_PROJECTION_MM * TURN_DEG
            ),
            "Rays turn about the mirror, not about the circle's middle.": (
                lambda: RADIUS_MM * np.tan(np.radians(TURN_DEG))
            ),
        },
    }


def relief_task():
    """A point before the assumed plane lands beside its place."""
    return {
        "expected": lambda: RELIEF_MM * np.tan(np.radians(ASIDE_DEG)),
        "hint": "how far the two rays are apart when they have gone on by the relief",
        "slips": {
            "The angle is between the rays, not half of it.": lambda: (
                RELIEF_MM * np.tan(np.radians(ASIDE_DEG / 2))
            ),
            "Only the height above the plane counts, not the whole depth.": lambda: (
                BACK_PROJECTION_MM * np.tan(np.radians(ASIDE_DEG))
            ),
        },
    }
