"""What the exercises of this page compare an answer with."""

import numpy as np

from chapters.ch05_flexible_mirror.ext_trust.trials.lesson import (
    beam_widening,
    field_of_view,
)
from chapters.shared.mirror_rigs import mirror_rig


def widening_task():
    """The slope of a beam where its load acts is 3/2 of the deflection over the length
    to it, and a ray turns by twice the angle by which its mirror turns."""
    return {
        "expected": lambda: beam_widening(150.0, 5.0),
        "hint": "how far does the mirror turn at the load, and a ray with it?",
        "slips": {
            "The ray turns by twice the angle of the mirror.": lambda: (
                beam_widening(150.0, 5.0) / 2
            ),
            "At the load the sheet is steeper than on the mean.": lambda: (
                beam_widening(150.0, 5.0) / 1.5
            ),
        },
    }


def check_task():
    """The free edge moves as well, so the camera looks at it in another direction, and
    the angle between the two viewing rays counts against the turn of the mirror."""
    return {
        "expected": lambda: _field("A", 5.0) - _field("A", 0.0),
        "hint": "field_of_view(rig.camera(5.0), rig.camera(5.0)), and the same at 0",
        "slips": {
            "That is the prediction; take the field of the rig at 5 mm and at 0.": (
                lambda: beam_widening(150.0, 5.0)
            ),
            "That is the field at 5 mm; take off the field at 0.": (
                lambda: _field("A", 5.0)
            ),
        },
    }


def _field(geometry, deflection):
    camera = mirror_rig(geometry).camera(deflection)
    return field_of_view(camera, camera)


def handed_on_task():
    """Independent errors add as squares: three of one size make the root of three."""
    return {
        "expected": lambda: np.sqrt(3),
        "hint": "how do independent errors add?",
        "slips": {
            "That would be errors that all push the same way.": lambda: 3.0,
            "That is the mean of three measurements of one thing.": lambda: (
                1 / np.sqrt(3)
            ),
        },
    }
