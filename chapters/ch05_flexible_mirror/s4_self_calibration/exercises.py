"""Answers to the exercises of the page on self-calibration."""

CAMERA_MM, PUSH_MM, DEPTH_MM = 400.0, 5.0, 4000.0
PIXEL_DEG = 0.008  # of a scene ray, for a pixel


def bias_task():
    """Deflection found: Z / (Z + D) of a push."""
    return {
        "expected": lambda: PUSH_MM * DEPTH_MM / (DEPTH_MM + CAMERA_MM),
        "hint": "the linear stage finds Z / (Z + D) of it",
        "slips": {
            "That is the part that is not found.": lambda: (
                PUSH_MM * CAMERA_MM / (DEPTH_MM + CAMERA_MM)
            )
        },
        "tolerance": 0.02,
    }


def depth_task():
    """Depth error: dZ = Z^2 / b times the angle."""
    return {
        "expected": lambda: DEPTH_MM**2 / PUSH_MM * 3.14159265 / 180 * PIXEL_DEG,
        "hint": "the angle between the two rays is b / Z; by how much does Z change?",
        "slips": {
            "The depth enters squared.": lambda: (
                DEPTH_MM / PUSH_MM * 3.14159265 / 180 * PIXEL_DEG
            ),
            "Convert degrees to radians.": lambda: DEPTH_MM**2 / PUSH_MM * PIXEL_DEG,
        },
        "tolerance": 0.03,
    }
