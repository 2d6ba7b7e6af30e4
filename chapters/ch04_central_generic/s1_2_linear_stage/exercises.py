"""Expected answers of the exercises of section 4.1.2."""

import numpy as np

from raxel.calibration import conic_system
from raxel.geometry import rotation_from_vector

OMEGA = np.array([2.0, -80.0, 60.0, 722_500.0])
CENTRE_MM = np.array([30.0, -20.0, 500.0])
TILT_DEG, TURN_DEG = 25.0, 40.0


def height_task():
    """Divide by w_11 first: p = (40, -30), and 361 250 - 1600 - 900 = 358 750 is
    the square of C_z."""
    return {
        "expected": height_mm,
        "hint": "the vector has a factor; divide by its first entry first.",
        "slips": {
            "Divide by w_11 before anything else.": lambda: np.sqrt(
                OMEGA[3] - OMEGA[1] ** 2 - OMEGA[2] ** 2
            ),
            "That is its square.": lambda: height_mm() ** 2,
        },
    }


def rows_task():
    """Each grid but the base gives two equations; one of the unknowns is the factor."""
    return {
        "expected": lambda: 2 * (5 - 1) - 3,
        "hint": "how many equations does a homography give? The four entries "
        "of omega have a common factor.",
        "slips": {
            "That is the number of equations.": lambda: 8,
            "The base grid has no homography.": lambda: 7,
            "The factor of omega is not an unknown.": lambda: 4,
        },
    }


def rotation_task():
    """The second pair of rows is the first, rotated by twice the angle: both span the
    same plane."""
    return {
        "expected": rank_of_rotated_grid,
        "hint": "does a rotation in its own plane move the vanishing line?",
        "slips": {"Two homographies, but are they different?": lambda: 4},
    }


def height_mm():
    """|C_z| of the conic OMEGA, by (4.10)."""
    w_11, w_13, w_23, w_33 = OMEGA
    return float(np.sqrt(w_33 / w_11 - (w_13**2 + w_23**2) / w_11**2))


def rank_of_rotated_grid():
    """Rank of (4.8), (4.9) for a grid and the same grid, rotated in its own plane."""
    R = rotation_from_vector([np.radians(TILT_DEG), 0.0, 0.0])
    turned = R @ rotation_from_vector([0.0, 0.0, np.radians(TURN_DEG)])
    x, y, z = CENTRE_MM / 500.0
    M = np.array([[-z, 0.0, x], [0.0, -z, y], [0.0, 0.0, 1.0]])
    shift = np.array([0.1, 0.2, -0.3])
    columns = [np.column_stack([r[:, :2], shift - [x, y, z]]) for r in (R, turned)]
    return int(np.linalg.matrix_rank(conic_system(M @ np.stack(columns))))
