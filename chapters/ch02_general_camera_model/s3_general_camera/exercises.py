"""Expected answers of the exercises of section 2.3."""

import numpy as np

from raxel.calibration import rays_from_known_motion
from raxel.geometry import pluecker_matrix, pluecker_vector, pose

# A pixel sees these points on two parallel grids, 100 mm apart.
POINTS_MM = ((30.0, -20.0), (45.0, -30.0))
STEP_MM = 100.0
A_MM, B_MM = (1.0, 2.0, 3.0), (4.0, 6.0, 3.0)


BYTES_OF_TABLE = 3008 * 2000 * 16 * 8
# Plücker vector (6,) of the line through A and B (2.12).
VECTOR = pluecker_vector(pluecker_matrix([*A_MM, 1.0], [*B_MM, 1.0]))


def ray_of_pixel():
    """Return the unit direction (3,) of the ray through the two points."""
    T = np.stack([np.eye(4), pose(np.eye(3), [0.0, 0.0, STEP_MM])])
    return rays_from_known_motion(np.array(POINTS_MM)[:, None], T).directions[0]


def angle_per_shift(shift_mm, step_mm):
    """Return the angle (deg) of a ray along z for a lateral shift of grid 2."""
    return np.degrees(np.arctan(shift_mm / step_mm))


def line_task():
    """Direction B - A = (3, 4, 0); moment A x (B - A) = (-12, 9, -2), and (2.12)
    has it negated. Six numbers of a line have no scale."""
    return {
        "expected": lambda: VECTOR,
        "up_to_factor": True,
        "hint": "in which order does (2.12) put direction and moment?",
        "slips": {
            "The moment has the other sign in (2.12).": lambda: (
                VECTOR * [1, 1, 1, -1, -1, -1]
            ),
            "The direction comes first.": lambda: np.roll(VECTOR, 3),
        },
    }


def ray_task():
    """From (30, -20, 0) to (45, -30, 100): the difference (15, -10, 100), divided
    by its length."""
    return {
        "expected": ray_of_pixel,
        "hint": "what are the two points in one frame?",
        "slips": {
            "A direction points from the camera into the scene.": lambda: (
                -ray_of_pixel()
            ),
            "Its length is not 1.": lambda: np.array([15.0, -10.0, 100.0]),
        },
    }


def shift_task():
    """The ray rotates by the angle whose tangent is 1 / 250."""
    return {
        "expected": lambda: angle_per_shift(1, 250),
        "hint": "draw the triangle of the shift and the distance of the grids",
        "slips": {"That is in radians.": lambda: np.radians(angle_per_shift(1, 250))},
    }


def bytes_task():
    """A 4 x 4 matrix has 16 numbers of 8 bytes, for each of 3008 x 2000 pixels."""
    return {
        "expected": lambda: float(BYTES_OF_TABLE),
        "hint": "how many numbers does a full Plücker matrix have?",
        "slips": {
            "That is the vector, not the matrix.": lambda: BYTES_OF_TABLE * 6 / 16,
            "That is in megabytes.": lambda: BYTES_OF_TABLE / 1e6,
        },
    }
