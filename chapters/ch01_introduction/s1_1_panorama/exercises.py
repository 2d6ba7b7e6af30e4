"""Expected answers of the exercises of section 1.1.2."""

import numpy as np

from chapters.ch01_introduction.s1_1_panorama.experiment import simulator, viewer_angle

EYE_HIGH_DEG = 30.0


def rows_task():
    """A full turn is 2 pi f long, with f the cylinder's radius. So f is 1280 / (2 pi)
    px. The tangent of 45 degrees is 1."""
    return {
        "expected": lambda: rows_above_horizon(1280, 45),
        "hint": "compute the radius of the cylinder in pixels first",
        "slips": {
            "Rows are not angles: vertically the cylinder is flat.": lambda: 1280 / 8
        },
    }


def lamp_task():
    """The light is 120 degrees from straight down. The formula of the page gives the
    angle at the camera. The focal length times its tangent is the radius."""
    return {
        "expected": radius_in_image,
        "hint": "psi and the elevation are measured from different directions",
        "slips": {
            "Psi is measured from straight down, the elevation from the horizon.": (
                lambda: radius_in_image(EYE_HIGH_DEG)
            ),
            "Psi is measured from straight down, not from straight up.": (
                lambda: radius_in_image(90 - EYE_HIGH_DEG)
            ),
        },
    }


def rows_above_horizon(width, elevation_deg):
    """Return the rows between the horizon and an elevation, for a width in px."""
    return width / (2 * np.pi) * np.tan(np.radians(elevation_deg))


def given():
    """Return the mirror's half axes (mm) and the camera's focal length (px)."""
    camera = simulator(1.0).camera
    return *camera.axes, camera.viewer.K[0, 0]


def radius_in_image(psi_deg=90 + EYE_HIGH_DEG):
    """Return the distance (px) from the middle of Fig. 1.1(a) at an angle psi."""
    camera = simulator(1.0).camera
    angle = viewer_angle(camera.mirror.eccentricity, np.radians(psi_deg))
    return float(camera.viewer.K[0, 0] * np.tan(angle))
