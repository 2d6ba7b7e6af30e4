"""What the exercises of section 2.5.2 compare an answer with."""

from __future__ import annotations

import numpy as np


def zoom_focal_px(focal_mm, converter=0.21, sensor_mm=7.18, width_px=1024):
    """Focal length (px) of a lens with a converter before it."""
    return focal_mm * converter * width_px / sensor_mm


def edge_angle_deg(radius_px, focal_px):
    """Angle (deg) at which r = f theta reaches a radius."""
    return np.degrees(radius_px / focal_px)


def rms_of(mean, sd):
    """Root mean square of values with this mean and SD."""
    return np.hypot(mean, sd)
