"""What the exercises of section 2.5.1 compare an answer with."""

from __future__ import annotations

import numpy as np


def clean_residual(noise, grids):
    """Mean length of the error of a ray fitted to points on ``grids`` grids.

    Gaussian noise of SD ``noise`` on two axes, independent between the grids.
    """
    return noise * np.sqrt(np.pi / 2) / np.sqrt(grids)


def focal_of_equidistance(fov_deg, corner_radius_px):
    """Focal length (px) of r = f theta whose image corner sees half the FOV."""
    return corner_radius_px / (np.radians(fov_deg) / 2)


def stretch_at(angle_deg):
    """Radial stretch of a corrected view over an equidistance image."""
    return 1 / np.cos(np.radians(angle_deg)) ** 2
