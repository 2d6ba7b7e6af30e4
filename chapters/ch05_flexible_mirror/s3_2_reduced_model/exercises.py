"""Answers to the exercises of section 5.3.2."""

import numpy as np

SLOPE_MRAD, DEPTH_M = 1.5, 5.0
OFFSETS_MM = (1.0, 1.0, 1.0, 1.0, 1.2)
PUSH_MM, LOAD_MM, LENGTH_MM = 7.98, 150.0, 160.0


def aside_task():
    """A slope of the mirror rotates the ray by twice as much, at any depth."""
    return {
        "expected": lambda: 2 * SLOPE_MRAD * DEPTH_M,
        "hint": "a rotation of the mirror rotates its ray by another angle; mrad "
        "times m are mm",
        "slips": {
            "That is the rotation of the normal. The ray rotates by more.": lambda: (
                SLOPE_MRAD * DEPTH_M
            )
        },
    }


def aligned_task():
    """What one shift cannot remove: offsets minus their mean."""
    off = np.array(OFFSETS_MM)
    return {
        "expected": lambda: float(np.mean(np.abs(off - off.mean()))),
        "hint": "subtract the mean first, then take the mean of the absolute values",
        "slips": {
            "That is without any alignment.": lambda: float(np.mean(np.abs(off)))
        },
    }
