"""Expected answers of the exercises of section 4.1.4."""

import numpy as np

GRIDS, RAYS = 4, 1000
RANGE_MM, TURN_DEG, OBLIQUE_DEG = 500.0, 0.05, 60.0


def unknowns_task():
    """Three numbers for the centre, six for each grid but the base, and two for every
    ray, whose direction has unit length."""
    return {
        "expected": lambda: 3 + 6 * (GRIDS - 1) + 2 * RAYS,
        "hint": "count the degrees of freedom of the centre, the poses and the rays",
        "slips": {
            "That is the number after the elimination of the rays.": lambda: (
                3 + 6 * (GRIDS - 1)
            ),
            "Those are the poses alone, as in scheme 2.": lambda: 6 * (GRIDS - 1),
            "Poses and rays are counted; what else is free here?": lambda: (
                6 * (GRIDS - 1) + 2 * RAYS
            ),
            "The base grid defines the frame and has no pose.": lambda: (
                3 + 6 * GRIDS + 2 * RAYS
            ),
            "A unit direction has two degrees of freedom.": lambda: (
                3 + 6 * (GRIDS - 1) + 3 * RAYS
            ),
        },
    }


def slant_task():
    """Across the ray the point moves by the distance times the angle, and in a plane
    that the ray meets obliquely by that over the cosine."""
    return {
        "expected": lambda: moved_mm(OBLIQUE_DEG),
        "hint": "how long is the step across the ray, and its projection on the grid?",
        "slips": {
            "That is across the ray.": lambda: moved_mm(0.0),
            "The angle is from the normal, not from the plane.": lambda: moved_mm(
                90.0 - OBLIQUE_DEG
            ),
            "The projection is longer than the step.": lambda: (
                moved_mm(0.0) * np.cos(np.radians(OBLIQUE_DEG))
            ),
        },
    }


def moved_mm(oblique_deg):
    """Step of a point along the slope of its grid when its ray turns."""
    across = RANGE_MM * np.radians(TURN_DEG)
    return float(across / np.cos(np.radians(oblique_deg)))
