"""Answers to the exercises of the page on motion."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_motion.experiment import RADIUS_MM, STEP_MM

DISTANCE_MM, DEEPER_MM = 700.0, 36.0
FOUND_MM, FOUND_RADIUS_MM = 31.34, 73.90


def alike_task():
    """A translation across the line of sight looks like a rotation."""
    return {
        "expected": lambda: _seen(DISTANCE_MM),
        "hint": "a small angle: translation over distance",
        "slips": {
            "That is in radians.": lambda: STEP_MM / DISTANCE_MM,
            "Invert the ratio.": lambda: np.degrees(DISTANCE_MM / STEP_MM),
        },
        "tolerance": 0.02,
    }


def parallax_task():
    """Parallax: a rotation moves all marks alike, a translation far marks less."""
    return {
        "expected": lambda: _seen(DISTANCE_MM) - _seen(DISTANCE_MM + DEEPER_MM),
        "hint": "the answer to 1 for the farther marks, then the difference",
        "slips": {
            "That is the angle of the farther mark. Take the difference.": lambda: (
                _seen(DISTANCE_MM + DEEPER_MM)
            ),
            "That is in radians.": lambda: np.radians(
                _seen(DISTANCE_MM) - _seen(DISTANCE_MM + DEEPER_MM)
            ),
        },
        "tolerance": 0.02,
    }


def scale_task():
    """One known length scales all others: radius and steps have one scale."""
    return {
        "expected": lambda: FOUND_RADIUS_MM * STEP_MM / FOUND_MM,
        "hint": "all estimated lengths are too large by the same factor",
        "slips": {
            "Invert the factor.": lambda: FOUND_RADIUS_MM * FOUND_MM / STEP_MM,
            "That is the true radius. Compute the radius of this motion.": lambda: (
                RADIUS_MM
            ),
        },
        "tolerance": 0.02,
    }


def _seen(way):
    return np.degrees(STEP_MM / way)
