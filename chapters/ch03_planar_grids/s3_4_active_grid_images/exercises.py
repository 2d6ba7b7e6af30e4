"""Answers to the exercises of section 3.3.4."""

import numpy as np

PITCH_DEG, DISTANCE_MM = 10.0, 110.0
FACET_MM, TO_CAMERA_MM, TO_MONITOR_MM = 19.0, 560.0, 140.0
PHASE_RAD, CELL_MM = 0.007, 37.7


def vertical_task():
    """The vertical through the lens leaves the perpendicular to the grid at 90 deg less
    the pitch, so it meets the plane d / tan(pitch) from the perpendicular's foot."""
    pitch = np.radians(PITCH_DEG)
    return {
        "expected": lambda: DISTANCE_MM / np.tan(pitch),
        "hint": "where does the vertical through the lens meet the grid's plane?",
        "slips": {
            "That distance would grow with the pitch; it must shrink.": lambda: (
                DISTANCE_MM * np.tan(pitch)
            ),
            "That is the distance along the vertical, not in the plane.": lambda: (
                DISTANCE_MM / np.sin(pitch)
            ),
        },
    }


def facet_task():
    """A flat mirror shows what a camera behind it would see, so lines of sight through
    its ends continue to diverge: s (c + m) / c."""
    return {
        "expected": lambda: FACET_MM * (TO_CAMERA_MM + TO_MONITOR_MM) / TO_CAMERA_MM,
        "hint": "a flat mirror deflects rays and keeps the angle between them",
        "slips": {
            "That omits the distance to the mirror.": lambda: (
                FACET_MM * TO_MONITOR_MM / TO_CAMERA_MM
            ),
            "Rays through both ends are not parallel.": lambda: FACET_MM,
        },
    }


def phase_task():
    """A period of the sine, 2 pi, is as wide as a cell: w phi / (2 pi)."""
    return {
        "expected": lambda: CELL_MM * PHASE_RAD / (2 * np.pi),
        "hint": "how much phase does a whole cell have?",
        "slips": {
            "A period has 2 pi, not 1.": lambda: CELL_MM * PHASE_RAD,
            "That is half of it: a cell holds a whole period.": lambda: (
                CELL_MM * PHASE_RAD / (4 * np.pi)
            ),
        },
    }
