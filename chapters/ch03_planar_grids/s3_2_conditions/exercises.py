"""Answers to the exercises on the conditions of section 3.3.2."""

import numpy as np

WHITE, BLACK = 0.9, 0.05
LIGHT, HAZE = 0.1, 0.06
CORNERS, RATIO = 10, 0.85
KEPT_RESPONSE = 0.1


def contrast_task():
    """White is 0.9 x 0.1 + 0.06 and black 0.05 x 0.1 + 0.06; divide the difference by
    the sum."""
    return {
        "expected": lambda: veiled_contrast(LIGHT, HAZE),
        "hint": "how bright is each of the two squares?",
        "slips": {
            "That is without the haze.": lambda: veiled_contrast(LIGHT, 0.0),
            "That is in full light.": lambda: veiled_contrast(1.0, HAZE),
            "That is the difference over white.": lambda: (
                1 - (BLACK * LIGHT + HAZE) / (WHITE * LIGHT + HAZE)
            ),
        },
    }


def step_task():
    """The last of nine steps is 0.85^8 of the first; the chord is the sum of all
    nine."""
    return {
        "expected": lambda: smallest_over_merging(CORNERS - 1),
        "hint": "how long is the chord in units of the first step?",
        "slips": {
            "Ten corners have fewer steps between them.": lambda: smallest_over_merging(
                CORNERS
            ),
            "That is without the 0.8.": lambda: (
                0.8 * smallest_over_merging(CORNERS - 1)
            ),
            "That is in units of the first step.": lambda: RATIO ** (CORNERS - 2),
        },
    }


def shadow_task():
    """Contrast to the fourth power may fall to 0.1, so light to its fourth root;
    the shadow may take the rest."""
    return {
        "expected": lambda: 1 - KEPT_RESPONSE**0.25,
        "hint": "how far may the response fall, and the contrast with it?",
        "slips": {
            "That is the share that must remain.": lambda: KEPT_RESPONSE**0.25,
            "The response falls faster than the light.": lambda: 1 - KEPT_RESPONSE,
            "That is for the square of contrast.": lambda: 1 - KEPT_RESPONSE**0.5,
        },
    }


def veiled_contrast(light, haze):
    """Return difference over sum of white and black squares in this light and haze."""
    bright, dark = WHITE * light + haze, BLACK * light + haze
    return (bright - dark) / (bright + dark)


def smallest_over_merging(count):
    """Return the smallest of ``count`` steps over the merging distance.

    It is 0.8 times the chord over 1.9 times the number of corners.
    """
    steps = RATIO ** np.arange(count)
    return float(steps.min() / (0.8 * steps.sum() / (1.9 * CORNERS)))
