"""What the exercises of the page on the look-up table compare an answer with."""

import numpy as np

FREE_EDGE_PX, RANGE_MM, POINTS, NOISE_PX = 180.0, 15.0, 33, 0.5
SPACING_MM, BOW_UM = 5.0, 20.0


def noise_task():
    """The edge's place is the mean of so many points, and mm are px over px per mm."""
    per_mm = FREE_EDGE_PX / RANGE_MM
    return {
        "expected": lambda: 1000 * NOISE_PX / np.sqrt(POINTS) / per_mm,
        "hint": "what error has the mean of independent points?",
        "slips": {
            "So far off one single point would be.": lambda: 1000 * NOISE_PX / per_mm,
            "The exercise asks for micrometres.": lambda: (
                NOISE_PX / np.sqrt(POINTS) / per_mm
            ),
        },
    }


def spacing_task():
    """A chord misses a smooth curve by the square of its length: a tenth of the error
    takes entries nearer by the root of ten."""
    return {
        "expected": lambda: SPACING_MM / np.sqrt(10),
        "hint": "how does the sag of an arc go with the length of its chord?",
        "slips": {"That would be so if the error grew in proportion.": lambda: 0.5},
    }
