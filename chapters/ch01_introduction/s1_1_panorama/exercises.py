"""What the exercises of section 1.1 compare an answer with."""

from __future__ import annotations

import numpy as np

from chapters.ch01_introduction.s1_1_panorama.trials import (
    laboratory,
    viewer_angle,
)

EYE_HIGH_DEG = 30.0


def rows_above_horizon(width, elevation_deg):
    """Rows between horizon and an elevation, in a panorama `width` px."""
    return width / (2 * np.pi) * np.tan(np.radians(elevation_deg))


def given():
    """Half axes (mm) of the mirror and focal length (px) of its viewer."""
    camera = laboratory(1.0).camera
    return *camera.axes, camera.viewer.K[0, 0]


def radius_in_picture():
    """Distance (px) from the middle of Fig. 1.1(a) of 30 degrees up."""
    camera = laboratory(1.0).camera
    e = camera.mirror.eccentricity
    angle = viewer_angle(e, np.radians(90 + EYE_HIGH_DEG))
    return float(camera.viewer.K[0, 0] * np.tan(angle))
