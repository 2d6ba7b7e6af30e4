"""What the exercises of the page on the tin compare an answer with."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_tin.trials.tin import DISTANCE_MM, SHIFT_MM

FACE_MM, RAY_DEG, WAY_MM = 70.0, 0.05, 630.0


def depth_task():
    """Two rays that are turned towards each other by an angle meet nearer: by the
    angle times the distance squared over the baseline."""
    return {
        "expected": lambda: _depth(np.radians(RAY_DEG), WAY_MM),
        "hint": "the depth is Z = B / angle between the rays; differentiate it",
        "slips": {
            "The angle has to be in radians.": lambda: _depth(RAY_DEG, WAY_MM),
            "The way to the camera counts too.": lambda: _depth(
                np.radians(RAY_DEG), DISTANCE_MM
            ),
        },
        "tolerance": 0.02,
    }


def _depth(angle, way):
    return way**2 / SHIFT_MM * angle


def tilt_task():
    """A depth that is wrong by some mm over a face tilts it."""
    return {
        "expected": lambda: np.degrees(np.arctan(1.0 / FACE_MM)),
        "hint": "what is the slope of a line that rises by 1 mm over the face?",
        "slips": {"That is in radians.": lambda: np.arctan(1.0 / FACE_MM)},
        "tolerance": 0.02,
    }
