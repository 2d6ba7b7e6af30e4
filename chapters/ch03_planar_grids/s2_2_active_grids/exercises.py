"""Answers to the exercises of section 3.2.2."""

import numpy as np

from chapters.shared.grids import phase_of

GRAY = (1, 1, 0)
STEPS_GREY = (60.0, 150.0, 140.0, 50.0)
CELL_MM = 30.0
NOISE_GREY = 2.0
WINDOW = 49


def cell_task():
    """Gray 110 is binary 100: a bit is the exclusive or of all Gray bits up to it."""
    return {
        "expected": lambda: gray_value(GRAY),
        "hint": "list the eight words of the code in order",
        "slips": {
            "That is 110 read as plain binary.": lambda: 6,
            "Cells count from 0.": lambda: gray_value(GRAY) + 1,
        },
    }


def place_task():
    """phi = atan2(-80, 100) is -38.7 degrees, or 321.3: (4 + 0.893) 30 = 146.8 mm."""
    return {
        "expected": place_mm,
        "hint": "add a full period to a negative phase",
        "slips": {
            "The phase must be between 0 and a full period.": lambda: (
                place_mm() - CELL_MM
            ),
            "The sine and cosine parts are exchanged.": lambda: (
                (gray_value(GRAY) + np.arctan2(100, -80) / (2 * np.pi)) * CELL_MM
            ),
            "That counts cells from 1.": lambda: place_mm() + CELL_MM,
        },
    }


def sigma_task():
    """B = 64.0; s / B sqrt(2 / 4) = 0.0221 rad, 0.105 mm, and a seventh of it."""
    return {
        "expected": sigma_mm,
        "hint": "first the SD of the phase, then its length in mm, then the window",
        "slips": {
            "The mean of 49 values has a seventh of the SD.": lambda: (
                sigma_mm() * np.sqrt(WINDOW) / WINDOW
            ),
            "That is a single pixel.": lambda: sigma_mm() * np.sqrt(WINDOW),
            "B is half the length of the two differences.": lambda: sigma_mm() / 2,
        },
    }


def gray_value(word):
    """The number of a Gray word, most significant bit first."""
    binary = np.cumsum(word) % 2
    return int("".join(map(str, binary)), 2)


def place_mm():
    """Location of the exercise's pixel, mm."""
    phase = phase_of(np.array(STEPS_GREY)) % (2 * np.pi)
    return (gray_value(GRAY) + phase / (2 * np.pi)) * CELL_MM


def sigma_mm():
    """Standard deviation of that location over a window, mm."""
    i1, i2, i3, i4 = STEPS_GREY
    swing = 0.5 * np.hypot(i1 - i3, i2 - i4)
    spread = NOISE_GREY / swing * np.sqrt(2 / 4)
    return spread / (2 * np.pi) * CELL_MM / np.sqrt(WINDOW)
