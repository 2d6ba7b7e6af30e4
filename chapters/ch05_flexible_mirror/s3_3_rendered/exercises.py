"""What the exercises of the page on rendered runs compare an answer with."""

import numpy as np

from chapters.shared.mirror_rigs import DYNAMIC_MM, mirror_rig

LOAD_MM, PUSH_MM, CORNER_PX = 150.0, 5.0, 0.2


def squares_task():
    """At the load a beam's slope is 3/2 of the deflection over the length to it, and a
    ray turns by twice the angle of the mirror; over the way to the board that is some
    mm, and a square has 18."""
    return {
        "expected": lambda: _squares(2.0, 1.5),
        "hint": "how far does a ray turn, and how far does it get to the side then?",
        "slips": {
            "The ray turns by twice the angle of the mirror.": lambda: _squares(
                1.0, 1.5
            ),
            "At the load the sheet is steeper than on the mean.": lambda: _squares(
                2.0, 1.0
            ),
        },
        "tolerance": 0.02,
    }


def _squares(turns, steeper):
    angle = turns * steeper * PUSH_MM / LOAD_MM
    return DYNAMIC_MM * angle / mirror_rig("A").board.pitch_mm


def turn_task():
    """A pixel is 1/f of a radian."""
    f = mirror_rig("A").viewer.K[0, 0]
    return {
        "expected": lambda: np.degrees(CORNER_PX / f),
        "hint": "what angle does a pixel see, at a focal length of f px?",
        "slips": {
            "That is in radians.": lambda: CORNER_PX / f,
            "That is the angle of a whole pixel.": lambda: np.degrees(1 / f),
        },
    }
