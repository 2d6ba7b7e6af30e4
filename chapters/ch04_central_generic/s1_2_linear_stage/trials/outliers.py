"""Gross outliers among the points, with RANSAC and without."""

import numpy as np

from chapters.shared.wide_angle import CENTRE_MM, SIDE
from raxel.calibration import linear_cgsp
from raxel.errors import CalibrationError

SHARE = 0.05


def spoil(points, share, rng):
    """Points with a share on each grid anywhere in its box; which they are."""
    wrong = rng.random(points.shape[:2]) < share
    low, high = points.min(axis=1), points.max(axis=1)
    anywhere = rng.uniform(low[:, None], high[:, None], points.shape)
    return np.where(wrong[..., None], anywhere, points), wrong


def centre_off(points, **options):
    """Distance (mm) of the centre found from the true one, and the solution."""
    try:
        found = linear_cgsp(points, side=SIDE, **options)
    except CalibrationError:
        return None, None
    return float(np.linalg.norm(found.centre - CENTRE_MM)), found
