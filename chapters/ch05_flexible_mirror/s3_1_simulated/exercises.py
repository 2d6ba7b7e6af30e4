"""What the exercises of section 5.3.1 compare an answer with."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_1_simulated.trials.scene import LENGTH_MM
from raxel.calibration.mirror.curves import reflected

DISTANCE_MM, DEPTH_MM = 500.0, 1500.0
TIP_MM = 20.0
TURN_DEG = 2.0


def turned_ray_task():
    """A mirror that turns by an angle turns the reflected ray by twice as much."""
    return {
        "expected": ray_turn_deg,
        "hint": "the normal turns with the mirror, and lies halfway between the rays",
        "slips": {
            "So far the normal turns; the viewing ray stays, so all of the change is "
            "the scene ray's.": lambda: TURN_DEG,
            "It turns more, not less.": lambda: TURN_DEG / 2,
        },
    }


def ray_turn_deg():
    """Turn of the scene ray, found by reflecting at both mirrors."""
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
            "That is what it leaves out.": lambda: TIP_MM * (1 - share),
            "The camera's distance over the sum is the share that is missing, of a "
            "ratio of the two: D / Z is not it.": lambda: (
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
