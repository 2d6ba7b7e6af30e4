"""Grey levels as a camera stores them, and the light that they stand for."""

import numpy as np

START, SLOPE = 0.04045, 12.92
OFFSET, POWER = 0.055, 2.4


def undo_srgb(image):
    """An image (height, width) uint8 as it was before the tone curve of sRGB, uint8.

    0 and 255 stay what they are. The curve is that of IEC 61966-2-1: straight for dark
    levels, a power above them; eight bits leave few levels for the dark ones.
    """
    grey = np.arange(256) / 255
    light = np.where(
        grey <= START, grey / SLOPE, ((grey + OFFSET) / (1 + OFFSET)) ** POWER
    )
    return np.rint(255 * light).astype(np.uint8)[image]
