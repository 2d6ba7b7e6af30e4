"""The exercises of an active grid's page: their right answers."""

import numpy as np

PERIOD_MM = 40.0
MODULATION = 60.0
BITS = (1, 1, 0)


def spread_task(noise):
    """Sine and cosine parts are sums over N steps with a variance of 2 noise^2 / N
    each; the angle of a vector of length B is off by that over B, and a whole turn
    is one period long."""
    return {
        "expected": lambda: spread(noise, 4),
        "hint": "noise of the phase in rad first; then what a rad is in mm",
        "slips": {
            "That is for a single picture, not for four.": lambda: spread(noise, 2),
            "A turn has 2 pi rad.": lambda: 2 * np.pi * spread(noise, 4),
        },
    }


def spread(noise, steps):
    """Standard deviation of a place in mm from one pixel's phase steps."""
    return PERIOD_MM / (2 * np.pi) * np.sqrt(2 / steps) * noise / MODULATION


def cell_task():
    """Each bit of the number is the sum of the code's bits so far, modulo two."""
    return {
        "expected": lambda: float(cell(BITS)),
        "hint": "the first bit stays; each further one is compared with the last",
        "slips": {
            "That reads the bits as a plain binary number.": lambda: float(
                int("".join(map(str, BITS)), 2)
            ),
            "The first bit is the most significant.": lambda: float(cell(BITS[::-1])),
        },
    }


def cell(bits):
    """The cell that a Gray code stands for, the most significant bit first."""
    number = value = 0
    for bit in bits:
        value ^= bit
        number = 2 * number + value
    return number
