"""Answers to the exercises on what section 3.3.2's result depends on."""

from __future__ import annotations

import numpy as np

WHITE, BLACK = 0.9, 0.05


def veiled_contrast(light, haze):
    """White is 0.9 x 0.1 + 0.06 and black 0.05 x 0.1 + 0.06; the difference over the
    sum.
    """
    bright, dark = WHITE * light + haze, BLACK * light + haze
    return (bright - dark) / (bright + dark)


def smallest_over_merging(corners, ratio):
    """The last of nine steps is 0.85^8 of the first; the chord is the sum of all nine.

    ratio: of each step to the one before; s_i: chord over 1.9 times the corners.
    """
    steps = ratio ** np.arange(corners - 1)
    return float(steps.min() / (0.8 * steps.sum() / (1.9 * corners)))


def adaptive_loss(share):
    """Contrast to the fourth power may fall to 0.1, so light may fall to the fourth
    root of it; the rest may go.
    """
    return 1 - share**0.25
