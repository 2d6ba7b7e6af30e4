"""What the exercises of chapter 2 compare an answer with."""

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


def zoom_focal_px(focal_mm, converter=0.21, sensor_mm=7.18, width_px=1024):
    """Focal length (px) of a lens with a converter before it."""
    return focal_mm * converter * width_px / sensor_mm


def edge_angle_deg(radius_px, focal_px):
    """Angle (deg) at which r = f theta reaches a radius."""
    return np.degrees(radius_px / focal_px)


def rms_of(mean, sd):
    """Root mean square of values with this mean and SD."""
    return np.hypot(mean, sd)


def view_focal_px(half_view_deg, width_px=1024):
    """Focal length (px) of a pinhole view this wide to each side."""
    return (width_px - 1) / 2 / np.tan(np.radians(half_view_deg))


def convergence_deg(pitch_deg, x):
    """How far (deg) a vertical line's picture leans at (x, 0), f = 1.

    Verticals meet at the vanishing point (0, -1 / tan(pitch)) or (0, 1 / tan).
    """
    return np.degrees(np.arctan(x * np.tan(np.radians(pitch_deg))))
