"""What the exercises of section 4.2 compare an answer with."""

import numpy as np

from raxel.calibration.pose.grid_pose import synthetic_plane_normal

LEAN_DEG = (10.0, 20.0, 60.0)  # three rays in one plane, from the z axis
SHARE, MANY = 0.003, 0.1  # of wrong pairs
SAMPLES = (3, 4)
PAIRS = 20_000


def normal_task():
    """(4.24) maximises the sum of cos^2 of the angles to the rays: the axis of the
    doubled angles' mean, not the mean of the angles."""
    return {
        "expected": lean_of_normal,
        "hint": "the sum of r r^T is 2 x 2 here; where does its larger "
        "eigenvector lie?",
        "slips": {
            "That is the mean of the angles. (4.24) weighs squared sines.": (
                lambda: np.mean(LEAN_DEG)
            ),
            "That is the direction of the summed rays.": lean_of_sum,
        },
    }


def sample_task():
    """All four pairs of a sample are right with 0.9^4."""
    return {
        "expected": lambda: 100 * (1 - MANY) ** SAMPLES[1],
        "hint": "all of the pairs of a sample have to be right",
        "slips": {
            "That is for a sample of three.": lambda: 100 * (1 - MANY) ** SAMPLES[0],
            "That is the share of samples with a wrong pair.": lambda: (
                100 * (1 - (1 - MANY) ** SAMPLES[1])
            ),
        },
    }


def lean_of_normal():
    """Angle (deg) of the best normal to the z axis, for the three rays."""
    lean = np.radians(LEAN_DEG)
    rays = np.column_stack([np.sin(lean), np.zeros(3), np.cos(lean)])
    normal = synthetic_plane_normal(rays)
    return float(np.degrees(np.arctan2(normal[0], normal[2])))


def lean_of_sum():
    """Angle (deg) of the sum of the three rays to the z axis."""
    lean = np.radians(LEAN_DEG)
    return float(np.degrees(np.arctan2(np.sin(lean).sum(), np.cos(lean).sum())))
