"""What the exercises of section 4.1.5 compare an answer with."""

import numpy as np

from chapters.shared.wide_angle import CENTRE_MM, FOV_DEG

GRIDS = 3


def parameters_task():
    """Six numbers for the pose of every grid but the base, whose frame is the frame of
    everything, and three for the centre, which the adjustment keeps."""
    return {
        "expected": lambda: 6 * (GRIDS - 1),
        "hint": "which grid has no pose to find, and does the centre move?",
        "slips": {
            "The base grid's pose is not sought.": lambda: 6 * GRIDS,
            "The centre stays where the linear stage put it.": lambda: (
                6 * (GRIDS - 1) + 3
            ),
        },
    }


def share_task():
    """The mean of three points with independent errors of one size has the error of one
    over the root of three, on each of the two axes across the ray."""
    return {
        "expected": lambda: 1 / np.sqrt(GRIDS),
        "hint": "how does a mean of independent errors shrink?",
        "slips": {
            "That is the share of the variance.": lambda: 1 / GRIDS,
            "That is what a point keeps of its own error, not the ray.": lambda: (
                np.sqrt(1 - 1 / GRIDS)
            ),
        },
    }


def extent_task():
    """A ray at half the field of view meets the base grid at the height times the
    tangent of that angle from the foot of the axis."""
    return {
        "expected": lambda: rim_mm(FOV_DEG / 2),
        "hint": "draw the axis, the rim's ray and the base grid: a right triangle",
        "slips": {
            "Half of the field of view lies on either side of the axis.": lambda: (
                rim_mm(FOV_DEG / 2) * 2
            ),
            "The angle is at the camera, so the tangent is what counts.": lambda: (
                CENTRE_MM[2] * np.sin(np.radians(FOV_DEG / 2))
            ),
        },
    }


def rim_mm(angle_deg):
    """Distance from the axis' foot at which a ray meets the base grid."""
    return float(CENTRE_MM[2] * np.tan(np.radians(angle_deg)))
