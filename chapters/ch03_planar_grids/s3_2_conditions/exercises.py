"""Answers to the exercises on what section 3.3.2's result depends on."""

from __future__ import annotations

import numpy as np

WHITE, BLACK = 0.9, 0.05


def veiled_contrast(light, haze):
    """Difference over sum of white and black squares in some light, under haze."""
    bright, dark = WHITE * light + haze, BLACK * light + haze
    return (bright - dark) / (bright + dark)


def smallest_over_merging(corners, ratio):
    """Smallest step of a straight side over its merging distance, 0.8 s_i.

    ratio: of each step to the one before; s_i: chord over 1.9 times the corners.
    """
    steps = ratio ** np.arange(corners - 1)
    return float(steps.min() / (0.8 * steps.sum() / (1.9 * corners)))


def adaptive_loss(share):
    """Share of light that may go until the response falls below `share` of it."""
    return 1 - share**0.25
