"""What the exercises of the film's page compare an answer with."""

import numpy as np

PITCH_PX, LOAD_MM, ARM_MM, FOCAL_PX, DEPTH_MM = 54.0, 150.0, 260.0, 1900.0, 630.0
STEPS, PEAK_MM = 16, 15.0


def moves_task():
    """1 mm at m from the clamp turns the sheet there by 3 / 2 m, and its rays by twice
    that: the point that is seen moves by the arm times the angle, and in the picture by
    the focal length over the whole way times that."""
    turned = 1.5 / LOAD_MM
    return {
        "expected": lambda: FOCAL_PX / DEPTH_MM * ARM_MM * 2 * turned,
        "hint": "the slope of (5.1) at the load, then what a mirror makes of it",
        "slips": {
            "So much it is if the ray turned as the mirror does.": lambda: (
                FOCAL_PX / DEPTH_MM * ARM_MM * turned
            ),
            "That is mm on the board; the exercise asks for pixels.": lambda: (
                ARM_MM * 2 * turned
            ),
        },
    }


def neighbour_task():
    """Half a square, over what a corner moves for each mm."""
    px_per_mm = moves_task()["expected"]()
    return {
        "expected": lambda: PITCH_PX / 2 / px_per_mm,
        "hint": "how far does a corner move for each mm?",
        "slips": {"That is a whole square.": lambda: PITCH_PX / px_per_mm},
    }


def fastest_task():
    """The slope of P sin^2 (pi t / 2), at most P pi / 2, over the steps for t = 1."""
    return {
        "expected": lambda: PEAK_MM * np.pi / 2 / STEPS,
        "hint": "differentiate, and ask where it is steepest",
        "slips": {"That is the mean over the way out.": lambda: PEAK_MM / STEPS},
    }
