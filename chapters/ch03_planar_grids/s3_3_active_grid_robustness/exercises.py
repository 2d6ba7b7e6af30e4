"""Answers to the exercises of section 3.3.3."""

import math

SIDE_MM, DISTANCE_MM, SENSOR_MM = 301.5, 200.0, 15.8
CELL_MM, SWING_GREY, NOISE_GREY, WINDOW = 37.7, 80.0, 4.0, 7
OWN_MM, SECOND_MM = 0.010, 0.050


def lens_task():
    """Half the grid over the distance is the tangent of half the angle; half the sensor
    over that tangent is the focal length."""
    return {
        "expected": longest_lens,
        "hint": "which angle does the upper half of the grid subtend?",
        "slips": {
            "That uses the whole grid instead of its half.": lambda: (
                SENSOR_MM / 2 * DISTANCE_MM / SIDE_MM
            ),
            "That is an equidistant lens.": lambda: (
                SENSOR_MM / 2 / math.atan(SIDE_MM / 2 / DISTANCE_MM)
            ),
        },
    }


def noise_task():
    """Four steps give a phase SD of sqrt(2/4) s / B; a period is 2 pi, and the mean of
    7 x 7 pixels divides by 7."""
    return {
        "expected": point_noise,
        "hint": "noise of the phase first, then a period in mm, then the filter",
        "slips": {
            "The filter averages 49 pixels.": lambda: point_noise() * WINDOW,
            "A mean of 49 values divides by the square root of 49.": lambda: (
                point_noise() / WINDOW
            ),
            "A period of the phase is 2 pi.": lambda: point_noise() * 2 * math.pi,
        },
    }


def floor_task():
    """Independent errors add by their squares."""
    return {
        "expected": combined_residual,
        "hint": "are the two errors correlated?",
        "slips": {
            "Independent errors add by their squares.": lambda: OWN_MM + SECOND_MM,
            "The second grid's error is added.": lambda: OWN_MM,
        },
    }


def longest_lens():
    """Return the focal length (mm) with which the grid fills the sensor's height."""
    return SENSOR_MM / 2 / (SIDE_MM / 2 / DISTANCE_MM)


def point_noise():
    """Return the SD (mm) of a decoded coordinate."""
    phase = math.sqrt(2 / 4) * NOISE_GREY / SWING_GREY
    return CELL_MM * phase / (2 * math.pi) / WINDOW


def combined_residual():
    """Return the residual (mm) that the second grid gives."""
    return math.hypot(OWN_MM, SECOND_MM)
