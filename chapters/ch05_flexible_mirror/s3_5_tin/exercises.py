"""What the exercises of the page on the tin compare an answer with."""

import numpy as np

# Two rays of a point meet at MEET_DEG, WAY_MM from the mirror; one of them is turned.
FACE_MM, TURNED_DEG, WAY_MM, MEET_DEG = 70.0, 0.05, 280.0, 11.4


def depth_task():
    """At the point the turned ray is aside by angle times way, at right angles to it;
    along the other ray that is as much over the sine of the angle between them."""
    aside = WAY_MM * np.radians(TURNED_DEG)
    return {
        "expected": lambda: aside / np.sin(np.radians(MEET_DEG)),
        "hint": "how far aside is the turned ray at the point, and where does it cross "
        "the other one then?",
        "slips": {
            "The angle by which it is turned has to be in radians.": lambda: (
                WAY_MM * TURNED_DEG / np.sin(np.radians(MEET_DEG))
            ),
            "That is how far aside it is: where does it cross the other?": lambda: (
                aside
            ),
        },
        "tolerance": 0.02,
    }


def tilt_task():
    """A depth that is wrong by some mm over a face tilts it."""
    return {
        "expected": lambda: np.degrees(np.arctan(1.0 / FACE_MM)),
        "hint": "what is the slope of a line that rises by 1 mm over the face?",
        "slips": {"That is in radians.": lambda: np.arctan(1.0 / FACE_MM)},
        "tolerance": 0.02,
    }
