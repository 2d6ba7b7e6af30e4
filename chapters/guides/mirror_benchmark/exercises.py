"""What the exercise of the page of the mirror benchmark compares an answer with."""

import numpy as np

TILT_DEG, INCIDENCE_DEG = 0.05, 60.0


def tilt_task():
    """A mirror turns a ray by twice its own tilt."""
    return {
        "expected": ray_turned,
        "hint": "the angle from the normal changes on the way in and on the way out",
        "slips": {"That is the mirror, not the ray.": lambda: TILT_DEG},
    }


def ray_turned():
    """Degrees between the rays of two mirrors, one of them tilted."""
    arriving = _direction(INCIDENCE_DEG)
    first, second = (_reflected(arriving, _direction(t)) for t in (0, TILT_DEG))
    return float(np.degrees(np.arcsin(np.linalg.norm(np.cross(first, second)))))


def _direction(angle_deg):
    angle = np.radians(angle_deg)
    return np.array([np.sin(angle), 0.0, np.cos(angle)])


def _reflected(direction, normal):
    return direction - 2 * (direction @ normal) * normal
