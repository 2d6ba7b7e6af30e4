"""Expected answers of the exercises of section 5.2."""

import numpy as np

from raxel.calibration import platter_plane, reflected_pose, reflection
from raxel.geometry import pose, rotation_from_vector

DISTANCE_MM, THICKNESS_MM, DEPTH_MM = 250.0, 0.4, 600.0
ANGLE, MIRROR_MM, SCENE_MM = np.radians(30), 380.0, 260.0


def shift_task():
    """The image moves by twice the shift of the plane, which the thickness shifts along
    its normal."""
    return {
        "expected": moved_mm,
        "hint": "how far does a mirror image move when its mirror moves by 1 mm?",
        "slips": {
            "A mirror image moves twice as far as its mirror.": lambda: THICKNESS_MM
        },
    }


def moved_mm():
    """Distance between the monitors found with and without the platter's thickness."""
    board = pose(rotation_from_vector(np.array([0, ANGLE, 0])), [0, 0, DISTANCE_MM])
    image = pose(np.eye(3), [0, 0, DEPTH_MM])
    found = [
        reflected_pose(image, platter_plane(board, thickness))[:3, 3]
        for thickness in (0.0, THICKNESS_MM)
    ]
    return float(np.linalg.norm(found[1] - found[0]))


def determinant_task():
    """A reflection changes handedness: the eigenvalues of I - 2 n n^T are -1, 1, 1."""
    n = np.array([0.6, 0.0, -0.8])
    return {
        "expected": lambda: float(np.linalg.det(reflection([*n, 100.0])[:3, :3])),
        "hint": "what does I - 2 n n^T do with n, and with vectors at right angles to "
        "it?",
        "slips": {
            "That is for a rotation. Here the sign changes along n, and only there.": (
                lambda: 1.0
            )
        },
    }


def start_task():
    """Z / (Z + D): the linear estimate keeps the scene ray and sees the rotation of the
    viewing ray only."""
    return {
        "expected": lambda: 5.0 * SCENE_MM / (SCENE_MM + MIRROR_MM),
        "hint": "5.3.1: linear over true deflection is Z / (Z + D)",
        "slips": {
            "That is the missing part.": lambda: (
                5.0 * MIRROR_MM / (SCENE_MM + MIRROR_MM)
            )
        },
    }
