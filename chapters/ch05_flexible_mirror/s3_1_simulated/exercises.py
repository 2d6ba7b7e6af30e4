"""Expected answers of the exercises of section 5.3.1."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_1_simulated.experiment import LENGTH_MM
from raxel.calibration import reflected

DISTANCE_MM, DEPTH_MM = 500.0, 1500.0
TIP_MM = 20.0
TURN_DEG = 2.0


def turned_ray_task():
    """A rotation of the mirror rotates the reflected ray by twice the angle."""
    return {
        "expected": ray_turn_deg,
        "hint": "the normal rotates with the mirror, and bisects the rays",
        "slips": {
            "That is the rotation of the normal; the viewing ray stays, so the scene "
            "ray has all of the change.": lambda: TURN_DEG,
            "It rotates more, not less.": lambda: TURN_DEG / 2,
        },
    }


def ray_turn_deg():
    """Rotation of the scene ray, by reflection at both mirrors."""
    V = np.array([[0.0, 1.0]])
    angles = []
    for turn in (0.0, np.radians(TURN_DEG)):
        tangent = np.array([[np.sin(1.0 + turn), np.cos(1.0 + turn)]])
        x, z = reflected(V, tangent)[0]
        angles.append(np.arctan2(x, z))
    return float(np.degrees(angles[1] - angles[0]))


def underestimate_task():
    """The linear stage finds Z / (Z + D) of the deflection."""
    share = DEPTH_MM / (DEPTH_MM + DISTANCE_MM)
    return {
        "expected": lambda: TIP_MM * share,
        "hint": "the farther the grid, the better the assumption; the camera's own "
        "distance sets the scale",
        "slips": {
            "That is the part that it misses.": lambda: TIP_MM * (1 - share),
            "The missing share is D / (Z + D), not D / Z.": lambda: (
                TIP_MM * (1 - DISTANCE_MM / DEPTH_MM)
            ),
        },
    }


def slope_task():
    """The beam (5.1) is steepest at its tip, where the slope is 3/2 tip / length."""
    steepest = 1.5 * TIP_MM / LENGTH_MM
    return {
        "expected": lambda: steepest**2,
        "hint": "differentiate (5.1) by x, and put the force at the free edge, m = x",
        "slips": {
            "The text's number is the square of the slope.": lambda: steepest,
            "That is the mean slope, squared.": lambda: (TIP_MM / LENGTH_MM) ** 2,
        },
    }
