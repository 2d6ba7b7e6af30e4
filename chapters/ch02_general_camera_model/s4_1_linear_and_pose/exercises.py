"""Expected answers of the exercises of sections 2.4.1 and 2.4.2."""

import numpy as np

from chapters.ch02_general_camera_model.s4_1_linear_and_pose.experiment import (
    UNKNOWNS_U,
    matrix_a,
    scaled_coefficients,
    scene_points,
)
from raxel.calibration import three_point_depths
from repro.run import trial_rng

# An equilateral triangle, viewed from above.
SIDE_MM = 100.0
HEIGHT_MM = 300.0
# Depth of each corner in the upright solution.
DEPTH_MM = np.hypot(HEIGHT_MM, SIDE_MM / np.sqrt(3))


def freedom_task():
    """A has 14 unknowns and 12 independent rows, of which one is missing."""
    return {
        "expected": freedom_of_a,
        "hint": "what is the rank of the remaining rows?",
        "slips": {"That is the rank.": lambda: UNKNOWNS_U - freedom_of_a()},
    }


def depth_task():
    """A corner is 100 / sqrt(3) mm from the centre, and 300 mm below the camera;
    the depth is the hypotenuse."""
    return {
        "expected": lambda: DEPTH_MM,
        "hint": "how far is a corner from the centre of the triangle?",
        "slips": {
            "That is the height, not the depth along the ray.": lambda: HEIGHT_MM
        },
    }


def solutions_task():
    """The upright one, three in which one corner is nearer, and the mirror image
    of each behind the camera."""
    return {
        "expected": lambda: len(solutions_of_triangle()),
        "hint": "can one corner be nearer than the others? Which one?",
        "slips": {
            "Count those behind the camera too.": lambda: (
                len(solutions_of_triangle()) // 2
            )
        },
    }


def nearer_task():
    """Two corners keep the depth of the upright solution. The third ray meets the
    circle of 100 mm about them twice; the nearer point is the answer."""
    return {
        "expected": lambda: np.nanmin(np.abs(solutions_of_triangle())),
        "hint": "keep two corners; where else can the third be on its ray?",
        "slips": {"That is the depth of the other two.": lambda: DEPTH_MM},
    }


def freedom_of_a():
    """Return the dimension of the solutions of A u = x (2.19) without its last row."""
    points, _, _ = scene_points(trial_rng("sec_2_4_1_exercise", {}, 0))
    A, _ = matrix_a(scaled_coefficients(points))
    return int(UNKNOWNS_U - np.linalg.matrix_rank(A[:-1]))


def triangle():
    """Return unit directions (3, 3) and points (3, 2) of the triangle.

    The camera is above the centre of the triangle, with its axis
    perpendicular to it.
    """
    angle = 2 * np.pi * np.arange(3) / 3
    radius = SIDE_MM / np.sqrt(3)
    points = radius * np.column_stack([np.cos(angle), np.sin(angle)])
    corners = np.column_stack([points, np.full(3, HEIGHT_MM)])
    return corners / np.linalg.norm(corners, axis=1, keepdims=True), points


def solutions_of_triangle():
    """Return the real solutions (K, 3) of (2.26) for the triangle, mm."""
    directions, points = triangle()
    depths = three_point_depths(directions[None], points[None])[0]
    return depths[np.isfinite(depths).all(axis=1)]
