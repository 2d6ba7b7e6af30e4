"""Expected answers of the exercises of section 4.2."""

import numpy as np

from raxel.calibration import synthetic_plane_normal

ANGLES_DEG = (10.0, 20.0, 60.0)  # three rays in one plane, from the z axis
OUTLIERS = 0.1  # share of wrong pairs
SAMPLES = (3, 4)


def normal_task():
    """(4.24) maximises the sum of cos^2 of the angles to the rays: the axis of the
    doubled angles' mean, not the mean of the angles."""
    return {
        "expected": angle_of_normal,
        "hint": "the sum of r r^T is 2 x 2 here: what is the direction of its "
        "leading eigenvector?",
        "slips": {
            "That is the mean of the angles. (4.24) weighs squared sines.": (
                lambda: np.mean(ANGLES_DEG)
            ),
            "That is the direction of the summed rays.": angle_of_sum,
        },
    }


def sample_task():
    """All four pairs of a sample are inliers with probability 0.9^4."""
    return {
        "expected": lambda: 100 * (1 - OUTLIERS) ** SAMPLES[1],
        "hint": "all pairs of a sample must be inliers",
        "slips": {
            "That is for a sample of three.": lambda: (
                100 * (1 - OUTLIERS) ** SAMPLES[0]
            ),
            "That is the share of samples with an outlier.": lambda: (
                100 * (1 - (1 - OUTLIERS) ** SAMPLES[1])
            ),
        },
    }


def angle_of_normal():
    """Return the angle (deg) of the best normal to the z axis, for the three rays."""
    angles = np.radians(ANGLES_DEG)
    rays = np.column_stack([np.sin(angles), np.zeros(3), np.cos(angles)])
    normal = synthetic_plane_normal(rays)
    return float(np.degrees(np.arctan2(normal[0], normal[2])))


def angle_of_sum():
    """Return the angle (deg) of the sum of the three rays to the z axis."""
    angles = np.radians(ANGLES_DEG)
    return float(np.degrees(np.arctan2(np.sin(angles).sum(), np.cos(angles).sum())))
