"""Answers to the exercises of the page on the tin."""

import numpy as np

# Two rays of a point meet at MEET_DEG, DISTANCE_MM from the mirror; one is rotated.
FACE_MM, ROTATED_DEG, DISTANCE_MM, MEET_DEG = 70.0, 0.05, 280.0, 11.4


def depth_task():
    """Depth error: angle times distance, over the sine of the angle between rays."""
    aside = DISTANCE_MM * np.radians(ROTATED_DEG)
    return {
        "expected": lambda: aside / np.sin(np.radians(MEET_DEG)),
        "hint": "how far is the rotated ray displaced at the point, and where does it "
        "then cross the other one?",
        "slips": {
            "Convert the angle of rotation to radians.": lambda: (
                DISTANCE_MM * ROTATED_DEG / np.sin(np.radians(MEET_DEG))
            ),
            "That is its displacement: where does it cross the other ray?": lambda: (
                aside
            ),
        },
        "tolerance": 0.02,
    }


def tilt_task():
    """A depth error that changes over a face tilts it."""
    return {
        "expected": lambda: np.degrees(np.arctan(1.0 / FACE_MM)),
        "hint": "what is the slope of a line that rises by 1 mm over the face?",
        "slips": {"That is in radians.": lambda: np.arctan(1.0 / FACE_MM)},
        "tolerance": 0.02,
    }
