"""What the exercises of section 5.3.2 compare an answer with."""

import numpy as np

SLOPE_MRAD, DEPTH_M = 1.5, 5.0
OFFSETS_MM = (1.0, 1.0, 1.0, 1.0, 1.2)
PUSH_MM, LOAD_MM, LENGTH_MM = 7.98, 150.0, 160.0


def aside_task():
    """A slope of the mirror turns the ray by twice as much, at any depth."""
    return {
        "expected": lambda: 2 * SLOPE_MRAD * DEPTH_M,
        "hint": "a mirror that turns by an angle turns its ray by another one; mrad "
        "times m are mm",
        "slips": {
            "So far the normal turns; the ray turns by more.": lambda: (
                SLOPE_MRAD * DEPTH_M
            )
        },
    }


def aligned_task():
    """What one shift cannot take away: offsets less their middle."""
    off = np.array(OFFSETS_MM)
    return {
        "expected": lambda: float(np.mean(np.abs(off - off.mean()))),
        "hint": "take the mean away first, and then the mean of the absolute rest",
        "slips": {
            "That is without any alignment.": lambda: float(np.mean(np.abs(off)))
        },
    }
