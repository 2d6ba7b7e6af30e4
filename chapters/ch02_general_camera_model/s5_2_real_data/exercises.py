"""What the exercises of section 2.5.2 compare an answer with."""

from __future__ import annotations

import numpy as np


def zoom_focal_px(focal_mm, converter=0.21, sensor_mm=7.18, width_px=1024):
    """The focal length in mm, shortened by the converter, divided by the width of a
    pixel: the sensor's width over the number of pixels across.
    """
    return focal_mm * converter * width_px / sensor_mm


def edge_angle_deg(radius_px, focal_px):
    """theta = r / f, in radians first."""
    return np.degrees(radius_px / focal_px)


def rms_of(mean, sd):
    """The mean square is the squared mean plus the squared SD."""
    return np.hypot(mean, sd)
