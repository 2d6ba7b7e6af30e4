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
        "hint": "under which angle is the upper half of the grid seen?",
        "slips": {
            "That takes the whole grid for its half.": lambda: (
                SENSOR_MM / 2 * DISTANCE_MM / SIDE_MM
            ),
            "That is an equidistance lens.": lambda: (
                SENSOR_MM / 2 / math.atan(SIDE_MM / 2 / DISTANCE_MM)
            ),
        },
    }


def noise_task():
    """Of four steps the phase has sqrt(2/4) s / B; a period is 2 pi, and the mean of
    7 x 7 pixels divides by 7."""
    return {
        "expected": point_noise,
        "hint": "noise of the phase first, then a period in mm, then the filter",
        "slips": {
            "The filter averages 49 pixels.": lambda: point_noise() * WINDOW,
            "A mean of 49 values divides by their root.": lambda: (
                point_noise() / WINDOW
            ),
            "A period of the phase is 2 pi.": lambda: point_noise() * 2 * math.pi,
        },
    }


def floor_task():
    """Independent errors add by their squares."""
    return {
        "expected": seen_residual,
        "hint": "do the two errors know of each other?",
        "slips": {
            "Independent errors add by their squares.": lambda: OWN_MM + SECOND_MM,
            "The second grid's error comes on top.": lambda: OWN_MM,
        },
    }


def longest_lens():
    """Focal length in mm with which the grid just fills the sensor's height."""
    return SENSOR_MM / 2 / (SIDE_MM / 2 / DISTANCE_MM)


def point_noise():
    """SD in mm of a decoded coordinate."""
    phase = math.sqrt(2 / 4) * NOISE_GREY / SWING_GREY
    return CELL_MM * phase / (2 * math.pi) / WINDOW


def seen_residual():
    """Residual in mm that the second grid reports."""
    return math.hypot(OWN_MM, SECOND_MM)
