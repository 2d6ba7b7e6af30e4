"""Expected answers of the exercises of section 4.1.5."""

import numpy as np

from chapters.shared.central import CENTRE_MM, FOV_DEG

GRIDS = 3


def parameters_task():
    """Six numbers for the pose of every grid except the base grid, which defines the
    frame. The centre is fixed."""
    return {
        "expected": lambda: 6 * (GRIDS - 1),
        "hint": "which grid has no pose to estimate, and does the centre move?",
        "slips": {
            "The pose of the base grid is not estimated.": lambda: 6 * GRIDS,
            "The centre stays fixed in this adjustment.": lambda: 6 * (GRIDS - 1) + 3,
        },
    }


def share_task():
    """The mean of three points with independent errors of one size has the error of one
    over the root of three, on each of the two axes across the ray."""
    return {
        "expected": lambda: 1 / np.sqrt(GRIDS),
        "hint": "how does averaging reduce independent errors?",
        "slips": {
            "That is the share of the variance.": lambda: 1 / GRIDS,
            "That is the share of its error that a point keeps, not the ray.": lambda: (
                np.sqrt(1 - 1 / GRIDS)
            ),
        },
    }


def extent_task():
    """A ray at half the field of view meets the base grid at the height times the
    tangent of that angle from the foot of the axis."""
    return {
        "expected": lambda: edge_mm(FOV_DEG / 2),
        "hint": "draw the axis, the outermost ray and the base grid: a right triangle",
        "slips": {
            "Half of the field of view is on either side of the axis.": lambda: (
                edge_mm(FOV_DEG / 2) * 2
            ),
            "The angle is at the camera, so use the tangent.": lambda: (
                CENTRE_MM[2] * np.sin(np.radians(FOV_DEG / 2))
            ),
        },
    }


def edge_mm(angle_deg):
    """Distance from the axis' foot at which a ray meets the base grid."""
    return float(CENTRE_MM[2] * np.tan(np.radians(angle_deg)))
