"""What the exercises of section 1.1 compare an answer with."""

import numpy as np

from chapters.ch01_introduction.s1_1_panorama.trials import laboratory, viewer_angle

EYE_HIGH_DEG = 30.0


def rows_task():
    """A full turn is as long as 2 pi times the cylinder's radius f, so f is
    1280 / (2 pi) px; the tangent of 45 degrees is 1."""
    return {
        "expected": lambda: rows_above_horizon(1280, 45),
        "hint": "how many pixels is the radius of the cylinder?",
        "slips": {
            "Rows are no angles here: upwards the cylinder is flat.": lambda: 1280 / 8
        },
    }


def lamp_task():
    """The lamp is 120 degrees from straight down; the formula of the page gives
    the angle at the camera, and the focal length times its tangent is the radius."""
    return {
        "expected": radius_in_picture,
        "hint": "from where does psi count, and from where elevation?",
        "slips": {
            "Psi counts from straight down, elevation from the horizon.": (
                lambda: radius_in_picture(EYE_HIGH_DEG)
            ),
            "Psi counts from straight down, not from straight up.": (
                lambda: radius_in_picture(90 - EYE_HIGH_DEG)
            ),
        },
    }


def rows_above_horizon(width, elevation_deg):
    """Rows between horizon and an elevation, in a panorama `width` px."""
    return width / (2 * np.pi) * np.tan(np.radians(elevation_deg))


def given():
    """Half axes (mm) of the mirror and focal length (px) of its viewer."""
    camera = laboratory(1.0).camera
    return *camera.axes, camera.viewer.K[0, 0]


def radius_in_picture(psi_deg=90 + EYE_HIGH_DEG):
    """Distance (px) from the middle of Fig. 1.1(a) at an angle from straight down."""
    camera = laboratory(1.0).camera
    e = camera.mirror.eccentricity
    angle = viewer_angle(e, np.radians(psi_deg))
    return float(camera.viewer.K[0, 0] * np.tan(angle))
