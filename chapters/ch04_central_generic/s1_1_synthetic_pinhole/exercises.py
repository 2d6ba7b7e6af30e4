"""Expected answers of the exercises of section 4.1.1."""

import numpy as np

from raxel.calibration import circle_of
from raxel.geometry import pose, rotation_from_vector

# A camera 500 mm above the origin of the base grid, and one tilted grid.
CENTRE_MM = np.array([0.0, 0.0, 500.0])
TILT_DEG = 30.0
HIT_MM = np.array([120.0, -80.0, -250.0])


def image_task():
    """The ray from (120, -80, -250) to the centre crosses z = 0 after a third of the
    path, 250 of 750 mm. So x is two thirds of its value."""
    return {
        "expected": image_x,
        "hint": "which part of the path to the centre is below the base grid?",
        "slips": {
            "That is the x of the point itself.": lambda: HIT_MM[0],
            "That is the change of x along the ray.": lambda: HIT_MM[0] - image_x(),
        },
    }


def focal_task():
    """The focal length of the synthetic camera is the distance of its centre from
    the image plane, and in this frame it is signed: -C_z."""
    return {
        "expected": focal_mm,
        "hint": "which entry of C is the distance from the image plane? Look "
        "at the sign in the matrix K.",
        "slips": {"Look at the sign.": lambda: -focal_mm()},
    }


def radius_task():
    """A grid tilted by 30 degrees about the x axis sends the horizon to a line; the
    centre is h / sin(tilt) from the middle of the circle."""
    return {
        "expected": circle_radius,
        "hint": "a plane through the centre, parallel to the grid, cuts the "
        "base plane in the vanishing line; how far is that from the centre?",
        "slips": {
            "That is the distance to the foot of the centre.": lambda: (
                CENTRE_MM[2] / np.tan(np.radians(TILT_DEG))
            ),
            "That is the height of the centre.": lambda: CENTRE_MM[2],
        },
    }


def image_x():
    """x (mm) on the base grid of the point HIT_MM."""
    share = -HIT_MM[2] / (CENTRE_MM[2] - HIT_MM[2])
    return float(HIT_MM[0] + share * (CENTRE_MM[0] - HIT_MM[0]))


def focal_mm():
    """Focal length of the synthetic camera, signed as in (4.5)."""
    return float(-CENTRE_MM[2])


def circle_radius():
    """Radius (mm) of the circle on which a grid puts the centre."""
    T = pose(rotation_from_vector([np.radians(TILT_DEG), 0.0, 0.0]), [0.0, 0.0, -100.0])
    x, y, z = CENTRE_MM
    M = np.array([[-z, 0.0, x], [0.0, -z, y], [0.0, 0.0, 1.0]])
    columns = T[:3, [0, 1, 3]] - np.outer(CENTRE_MM, [0.0, 0.0, 1.0])
    return float(circle_of(M @ columns)[2])
