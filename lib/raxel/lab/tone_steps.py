"""Tone curve and rounding in one: the shares from which on a file has the next number.

Whole numbers of a curve that never falls are told by the shares at which they change.
Those are found once, to the last digit; then a picture is counted off, pixel by pixel.
"""

from typing import NamedTuple

import numba
import numpy as np

# Cells of the table that says near which step a share lies; a power of two is exact.
CELLS = 1 << 12
# Shares so far outside 0 to 1 have the first number, or the last.
FAR = 1e6


class ToneSteps(NamedTuple):
    """steps (n,) float32: the least share that has the number 1, 2, ... n; below: how
    many of them lie below a share less than 0, then below the start of each cell.
    """

    steps: np.ndarray
    below: np.ndarray


def tone_steps(number_of, top):
    """The ToneSteps of a function (N,) -> (N,) that never falls, up to number `top`.

    number_of: whole numbers of float32 shares. A number that is never reached has an
    infinite step.
    """
    wanted = np.arange(1, top + 1)
    low, high = (np.full(top, _rank(np.float32(far))) for far in (-FAR, FAR))
    always = number_of(_share(low)) >= wanted
    never = number_of(_share(high)) < wanted
    while np.any(high - low > 1):
        middle = (low + high) // 2
        reached = number_of(_share(middle)) >= wanted
        low, high = np.where(reached, low, middle), np.where(reached, middle, high)
    steps = np.where(always, -np.inf, np.where(never, np.inf, _share(high)))
    starts = np.arange(CELLS + 1) / CELLS
    below = np.searchsorted(steps, starts, side="right")
    return ToneSteps(steps.astype(np.float32), np.append(0, below))


def counted(share, steps, kind):
    """Numbers of an integer `kind`, shaped as the float32 shares, by ToneSteps."""
    picture = np.empty(share.shape, kind)
    _count_into(picture.reshape(-1), share.reshape(-1), *steps)
    return picture


def _rank(share):
    """Whole numbers that rise with float32 numbers, one for each."""
    bits = np.asarray(share, np.float32).view(np.int32).astype(np.int64)
    return np.where(bits < 0, -(bits & 0x7FFFFFFF), bits)


def _share(rank):
    """The float32 number of a rank."""
    bits = np.where(rank < 0, -rank | 0x80000000, rank)
    return bits.astype(np.uint32).view(np.float32)


@numba.njit(cache=True, error_model="numpy")
def _count_into(picture, share, steps, below):
    for n in range(len(share)):
        x = share[n]
        # What is not a number has the first one.
        number = below[int(min(x, np.float32(1)) * CELLS) + 1] if x >= 0 else 0
        while number < len(steps) and steps[number] <= x:
            number += 1
        picture[n] = number
