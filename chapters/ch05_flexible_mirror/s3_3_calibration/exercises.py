"""Expected answers of the exercises on the primary calibration."""

import numpy as np

from chapters.shared.mirror import PUBLISHED, STAGES_MM, mirror_rig

LENGTH_MM = 150.0


def slope_task():
    """The beam's slope at the load is 3/2 of the deflection over the length (5.1)."""
    return {
        "expected": turn_deg,
        "hint": "the slope at the load is 3 v / (2 m); a scene ray rotates by twice "
        "the mirror's angle.",
        "slips": {
            "That is the rotation of the mirror itself.": lambda: turn_deg() / 2,
            "That is the mean slope; at the load it is larger.": lambda: (
                turn_deg() / 1.5
            ),
        },
    }


def turn_deg():
    """Rotation (degrees) of the ray at the load at the last stage, twice the slope."""
    return float(2 * np.degrees(np.arctan(1.5 * STAGES_MM[-1] / LENGTH_MM)))


def fan_task():
    """At the clamp nothing rotates; at the load the ray rotates by twice the slope."""
    return {
        "expected": fan_deg,
        "hint": "one end of the fan stays fixed, the other rotates as in exercise 1. "
        "To which side does a convex mirror send it?",
        "slips": {"A convex mirror spreads the fan.": lambda: _flat_deg() - turn_deg()},
    }


def fan_deg():
    """The fan (degrees) of rig A at stage 3 by this rule."""
    return _flat_deg() + turn_deg()


def _flat_deg():
    """The fan of the flat mirror of rig A, the angle that the camera sees."""
    rig = mirror_rig("A")
    flat = rig.camera(0.0)
    x = np.array([0.0, flat.mirror.end])
    ends = flat.T_viewer_mirror[:3, 3] + x[:, None] * flat.T_viewer_mirror[:3, 0]
    unit = ends / np.linalg.norm(ends, axis=1, keepdims=True)
    return float(np.degrees(np.arccos(unit[0] @ unit[1])))


def unknowns_task():
    """Each pair of a viewing and a scene ray gives two equations (5.15, 5.16)."""
    along, across = PUBLISHED.shape
    return {
        "expected": lambda: int(np.ceil((along * across - 1) / 2)),
        "hint": "the directions do not determine the scale: one unknown less.",
        "slips": {
            "Each pair gives two equations.": lambda: along * across - 1,
            "That would fix the scale as well, which directions cannot.": lambda: int(
                np.ceil(along * across / 2)
            ),
        },
    }
