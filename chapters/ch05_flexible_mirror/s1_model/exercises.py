"""Expected answers of the exercises of section 5.1."""

import numpy as np

from chapters.ch05_flexible_mirror.s1_model.experiment import DEFECT_RAD, curve
from raxel.calibration import reflected, viewing_rays

SHAPE = (9, 4)
DEPTH_MM = 3000.0


def pairs_task():
    """Each pair gives two equations, without the scale: K - 1 are needed."""
    count = SHAPE[0] * SHAPE[1]
    return {
        "expected": lambda: -(-(count - 1) // 2),
        "hint": "two equations for each pair, and one unknown that no pair determines",
        "slips": {
            "No pair determines the scale, so one equation less is needed; and a "
            "pair cannot be halved.": lambda: count / 2 + 1,
            "A pair gives two equations, one for each tangent.": lambda: count - 1,
        },
    }


def defect_task():
    """A rotation of the mirror rotates the scene ray by twice the angle."""
    return {
        "expected": moved_mm,
        "hint": "by which angle does the scene ray rotate when the mirror rotates?",
        "slips": {
            "The scene ray rotates by twice the angle of the mirror.": lambda: (
                DEPTH_MM * DEFECT_RAD
            )
        },
    }


def moved_mm():
    """Displacement at the depth, from reflection at the mirror and a rotated one."""
    u = np.array([0.0])
    V, tangents = viewing_rays(u)[0], curve(0.0).tangents(u)
    c, s = np.cos(DEFECT_RAD), np.sin(DEFECT_RAD)
    rays = [
        reflected(V, tangents @ turn)[0]
        for turn in (np.eye(2), np.array([[c, s], [-s, c]]))
    ]
    return float(DEPTH_MM * np.linalg.norm(rays[1] - rays[0]))


def double_task():
    """Viewing and scene ray keep their directions when mirror and scene grow: the null
    vector of the equations is the mirror up to its size."""
    return {
        "expected": lambda: 2.0 * curve(16.7).distances([0.0])[0],
        "hint": "only directions enter the equations: do they determine lengths?",
        "slips": {
            "Both have the same rays, so only the scale differs; all distances have "
            "the same factor.": lambda: curve(16.7).distances([0.0])[0]
        },
    }
