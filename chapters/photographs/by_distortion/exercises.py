"""What the exercises of the page of all image sets compare an answer with."""

import numpy as np

from repro.judge.statistics import SIGNIFICANCE


def exercise_lens(sets):
    """A lens for the level: the widest angle of the least distorted set, or one."""
    known = [one for one in sets if one.comparable]
    angle = min(known[0].widest_deg, 80.0) if known else 40.0
    return {"widest_deg": round(float(angle), 1)}


def level_task(lens):
    """The level is 1 - r / r_pinhole = 1 - theta / tan(theta) at the widest angle."""
    angle = np.radians(lens["widest_deg"])
    return {
        "expected": lambda: 1 - angle / np.tan(angle),
        "hint": "r / r_pinhole falls as the angle grows; f cancels",
        "slips": {
            "The level has no sign.": lambda: angle / np.tan(angle) - 1,
            "That is r / r_pinhole; how far is it from 1?": lambda: (
                angle / np.tan(angle)
            ),
            "That is relative to r, not to r_pinhole.": lambda: (
                np.tan(angle) / angle - 1
            ),
        },
    }


def photographs_task():
    """All n signs agree by chance once in 2^n, and 2^-7 is the first below 0.01."""
    return {
        "expected": lambda: _fewest(SIGNIFICANCE),
        "hint": "all signs agree by chance once in 2^n",
        "slips": {
            "That is for a two-sided test.": lambda: _fewest(SIGNIFICANCE / 2),
            "That is for p < 0.05.": lambda: _fewest(0.05),
        },
    }


def _fewest(p):
    return int(np.floor(-np.log2(p))) + 1
