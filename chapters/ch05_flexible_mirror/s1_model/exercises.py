"""What the exercises of section 5.1 compare an answer with."""

import numpy as np

from chapters.ch05_flexible_mirror.s1_model.trials.plane import DEFECT_RAD, curve
from raxel.calibration.mirror.curves import reflected, viewing_rays

SHAPE = (9, 4)
DEPTH_MM = 3000.0


def pairs_task():
    """Each pair gives two equations, and the scale stays open: K - 1 are needed."""
    count = SHAPE[0] * SHAPE[1]
    return {
        "expected": lambda: -(-(count - 1) // 2),
        "hint": "two equations for each pair, and one unknown that no pair tells",
        "slips": {
            "The scale is open whatever the pairs, so that one equation less is "
            "needed; and a pair cannot be halved.": lambda: count / 2 + 1,
            "A pair gives two equations, one for each tangent.": lambda: count - 1,
        },
    }


def defect_task():
    """A mirror that is turned by an angle turns the scene ray by twice as much."""
    return {
        "expected": moved_mm,
        "hint": "how much does the scene ray turn when the mirror turns?",
        "slips": {
            "The scene ray turns twice as much as the mirror.": lambda: (
                DEPTH_MM * DEFECT_RAD
            )
        },
    }


def moved_mm():
    """Displacement at the depth, found by reflecting at the mirror and a turned one."""
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
        "hint": "only directions enter the equations: what do they know of lengths?",
        "slips": {
            "The rays are the same for both, so nothing but the size differs; all "
            "distances have the factor, the others too.": lambda: curve(16.7).distances(
                [0.0]
            )[0]
        },
    }
