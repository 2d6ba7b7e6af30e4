"""Answers to the exercises of the page on cells and steps."""

import math

MONITOR_PX = 800.0
BLUR_PX = 3.0


def best_task():
    """P exp(2 pi^2 s^2 / P^2) is least at P = 2 pi s: here 18.8 px, 42 cells."""
    return {
        "expected": lambda: best_count(MONITOR_PX, BLUR_PX),
        "hint": "where is the derivative of ln P + 2π²s²/P² zero?",
        "slips": {
            "That is the width of a cell.": lambda: 2 * math.pi * BLUR_PX,
            "The exponent has P² below it: mind its derivative.": lambda: (
                MONITOR_PX / (math.sqrt(2) * math.pi * BLUR_PX)
            ),
        },
    }


def swing_task():
    """At P = 2 pi s the exponent is 1/2."""
    return {
        "expected": lambda: math.exp(-0.5),
        "hint": "put the best width into the formula of the swing",
        "slips": {
            "That is its square.": lambda: math.exp(-1),
            "That is what is lost.": lambda: 1 - math.exp(-0.5),
        },
    }


def pictures_task():
    """Twice the steps cost 8 pictures more and gain sqrt(2); two times the cells
    cost 4 and gain 2."""
    return {
        "expected": lambda: 2 / math.sqrt(2),
        "hint": "the error goes with P, and with the root of 1/N",
        "slips": {
            "That is what finer cells gain alone.": lambda: 2.0,
            "The other way round.": lambda: 1 / math.sqrt(2),
        },
    }


def best_count(monitor_px, blur_px):
    """Cells across a monitor that is so wide in the picture, for a blur SD."""
    return monitor_px / (2 * math.pi * blur_px)
