"""Expected answers of the exercises of section 4.3.1."""

import numpy as np

FOCAL_PX, SHIFT_PX = 367.4, 9.0
AXES_MM = (29.3, 15.3)


def shift_task():
    """Near the axis of an equidistance lens a px is 1 / f radians."""
    return {
        "expected": lambda: float(np.degrees(SHIFT_PX / FOCAL_PX)),
        "hint": "r = f theta, with r and f in px",
        "slips": {
            "The answer is in degrees, this is in radians.": lambda: (
                SHIFT_PX / FOCAL_PX
            ),
            "Divide the shift by the focal length, not vice versa.": lambda: float(
                np.degrees(FOCAL_PX / SHIFT_PX)
            ),
        },
    }


def foci_task():
    """The foci of z^2 / a^2 - r^2 / b^2 = 1 are sqrt(a^2 + b^2) from its centre."""
    return {
        "expected": lambda: 2 * float(np.hypot(*AXES_MM)),
        "hint": "for a hyperbola the squares of the half axes are added",
        "slips": {
            "That is from the centre to one focus.": lambda: float(np.hypot(*AXES_MM)),
            "For an ellipse they subtract; here they add.": lambda: float(
                2 * np.sqrt(AXES_MM[0] ** 2 - AXES_MM[1] ** 2)
            ),
        },
    }
