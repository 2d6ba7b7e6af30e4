"""What the exercises of section 4.1.4 compare an answer with."""

import numpy as np

GRIDS, RAYS = 4, 1000
RANGE_MM, TURN_DEG, ASLANT_DEG = 500.0, 0.05, 60.0
FEW, MANY, ERROR_MM = 1000, 25_000, 0.8


def unknowns_task():
    """Three numbers for the centre, six for each grid but the base, and two for every
    ray, whose direction has unit length."""
    return {
        "expected": lambda: 3 + 6 * (GRIDS - 1) + 2 * RAYS,
        "hint": "count the centre, the poses and the rays, each with its freedom",
        "slips": {
            "That is what is left when the rays are eliminated.": lambda: (
                3 + 6 * (GRIDS - 1)
            ),
            "Those are the poses alone, as scheme 2 moves them.": lambda: (
                6 * (GRIDS - 1)
            ),
            "Poses and rays are there; what else is free here?": lambda: (
                6 * (GRIDS - 1) + 2 * RAYS
            ),
            "The base grid is the frame of everything.": lambda: (
                3 + 6 * GRIDS + 2 * RAYS
            ),
            "A unit direction has two freedoms.": lambda: (
                3 + 6 * (GRIDS - 1) + 3 * RAYS
            ),
        },
    }


def slant_task():
    """Across the ray the point moves by the distance times the angle, and in a plane
    that the ray meets aslant by that over the cosine."""
    return {
        "expected": lambda: moved_mm(ASLANT_DEG),
        "hint": "how long is the step across the ray, and its shadow on the grid?",
        "slips": {
            "That is across the ray.": lambda: moved_mm(0.0),
            "The angle is from the normal, not from the plane.": lambda: moved_mm(
                90.0 - ASLANT_DEG
            ),
            "The shadow is longer than the step.": lambda: (
                moved_mm(0.0) * np.cos(np.radians(ASLANT_DEG))
            ),
        },
    }


def moved_mm(aslant_deg):
    """Step of a point along the slope of its grid when its ray turns."""
    across = RANGE_MM * np.radians(TURN_DEG)
    return float(across / np.cos(np.radians(aslant_deg)))
