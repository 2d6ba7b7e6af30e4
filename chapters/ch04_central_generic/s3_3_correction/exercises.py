"""Expected answers of the exercises on distortion correction."""

import numpy as np

AT_DEG = 40.0
PANORAMA_PX, PANORAMA_DEG = 720, 200.0


def stretch_task():
    """A ray meets a plane at distance 1 at tan(angle); the derivative is 1 / cos^2."""
    return {
        "expected": lambda: 1 / np.cos(np.radians(AT_DEG)) ** 2,
        "hint": "how does the tangent grow with the angle?",
        "slips": {
            "That is the tangential stretch.": lambda: 1 / np.cos(np.radians(AT_DEG)),
            "The plane stretches, it does not shrink.": lambda: (
                np.cos(np.radians(AT_DEG)) ** 2
            ),
        },
    }


def radius_task():
    """The width of an unwrapped image is radius times angle."""
    return {
        "expected": lambda: PANORAMA_PX / np.radians(PANORAMA_DEG),
        "hint": "the visible arc is as long as the image is wide",
        "slips": {
            "Angles in radians, not degrees.": lambda: PANORAMA_PX / PANORAMA_DEG,
            "The image does not show the full circle.": lambda: (
                PANORAMA_PX / (2 * np.pi)
            ),
        },
    }
