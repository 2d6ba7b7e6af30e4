"""What the exercises of the page on motion compare an answer with."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_motion.trials.scene import RADIUS_MM, STEP_MM

WAY_MM, DEEPER_MM = 700.0, 36.0
FOUND_MM, FOUND_RADIUS_MM = 31.34, 73.90


def alike_task():
    """A shift across the line of sight is seen as a turn by shift over distance."""
    return {
        "expected": lambda: _seen(WAY_MM),
        "hint": "it is seen under a small angle: what lies across over how far away",
        "slips": {
            "That is in radians.": lambda: STEP_MM / WAY_MM,
            "The other way round.": lambda: np.degrees(WAY_MM / STEP_MM),
        },
        "tolerance": 0.02,
    }


def parallax_task():
    """A turn moves all marks alike, a shift those that are farther away less: only
    the difference tells one from the other."""
    return {
        "expected": lambda: _seen(WAY_MM) - _seen(WAY_MM + DEEPER_MM),
        "hint": "the answer to 1 again, for what is farther away; then the difference",
        "slips": {
            "That is what the farther mark moves by; take the difference.": lambda: (
                _seen(WAY_MM + DEEPER_MM)
            ),
            "That is in radians.": lambda: np.radians(
                _seen(WAY_MM) - _seen(WAY_MM + DEEPER_MM)
            ),
        },
        "tolerance": 0.02,
    }


def scale_task():
    """One length that is known scales all others: radius and steps have one scale."""
    return {
        "expected": lambda: FOUND_RADIUS_MM * STEP_MM / FOUND_MM,
        "hint": "everything that was found is too large by the same factor",
        "slips": {
            "The factor is the other way round.": lambda: (
                FOUND_RADIUS_MM * FOUND_MM / STEP_MM
            ),
            "That is the true radius; what does this motion say?": lambda: RADIUS_MM,
        },
        "tolerance": 0.02,
    }


def _seen(way):
    return np.degrees(STEP_MM / way)
