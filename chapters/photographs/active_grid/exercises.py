"""Expected answers of the exercises of an active grid's page."""

import numpy as np

PERIOD_MM = 40.0
MODULATION = 60.0
BITS = (1, 1, 0)


def spread_task(noise):
    """Sine and cosine parts over N steps have a variance of 2 noise^2 / N each. The
    angle of a vector of length B has this standard deviation divided by B. One turn is
    one period."""
    return {
        "expected": lambda: spread(noise, 4),
        "hint": "compute the noise of the phase in rad, then convert rad to mm",
        "slips": {
            "That ignores the average over four phase steps.": lambda: spread(noise, 2),
            "A turn is 2 pi rad.": lambda: 2 * np.pi * spread(noise, 4),
        },
    }


def spread(noise, steps):
    """Return the standard deviation (mm) of a position from one pixel's phase steps."""
    return PERIOD_MM / (2 * np.pi) * np.sqrt(2 / steps) * noise / MODULATION


def cell_task():
    """Each bit of the number is the sum of the code's bits up to it, modulo two."""
    return {
        "expected": lambda: float(cell(BITS)),
        "hint": "the first bit stays; combine each further bit with the last result",
        "slips": {
            "That decodes the bits as plain binary.": lambda: float(
                int("".join(map(str, BITS)), 2)
            ),
            "The first bit is the most significant.": lambda: float(cell(BITS[::-1])),
        },
    }


def cell(bits):
    """Return the cell of a Gray code, the most significant bit first."""
    number = value = 0
    for bit in bits:
        value ^= bit
        number = 2 * number + value
    return number
