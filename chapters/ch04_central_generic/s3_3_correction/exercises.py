"""What the exercises of this page compare an answer with."""

import numpy as np

AT_DEG = 40.0
PANORAMA_PX, PANORAMA_DEG = 720, 200.0


def stretch_task():
    """A plane at distance 1 is met at tan(angle); its derivative is 1 / cos^2."""
    return {
        "expected": lambda: 1 / np.cos(np.radians(AT_DEG)) ** 2,
        "hint": "how does the tangent grow with the angle?",
        "slips": {
            "That is the stretch across the radius.": lambda: (
                1 / np.cos(np.radians(AT_DEG))
            ),
            "The plane stretches, it does not shrink.": lambda: (
                np.cos(np.radians(AT_DEG)) ** 2
            ),
        },
    }


def radius_task():
    """The columns of a cylinder's picture are radius times angle."""
    return {
        "expected": lambda: PANORAMA_PX / np.radians(PANORAMA_DEG),
        "hint": "the arc that the picture shows is as long as it is wide",
        "slips": {
            "Angles in radians, not degrees.": lambda: PANORAMA_PX / PANORAMA_DEG,
            "It does not go all the way round.": lambda: PANORAMA_PX / (2 * np.pi),
        },
    }
