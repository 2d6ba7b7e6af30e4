"""Where places bend within a few pixels: the bias of windows and blur at each pixel.

`bias` knows it for squares of the picture, before anything is decoded. A mirror that
curves strongly, or whose surface ripples, changes its bending within a square. Second
differences of the decoded places over some pixels tell it there.
"""

import numpy as np
from numba import njit

from raxel.features.active_grid.bias import OF_SIGMA
from raxel.features.active_grid.layout import SQUARE

HALF = 8  # px, beyond a window, so that what noise does to each place is its own
# Of a place's variance, that of the sum of both second differences.
OF_NOISE = np.float32(4 + 4**2)
# Times that, two to three deviations: less is what noise makes of flat surfaces, and
# would widen sigma where errors are large.
BEYOND = np.float32(4)
_ZERO, _ONE = np.float32(0), np.float32(1)


@njit(cache=True, nogil=True, error_model="numpy")
def widen_at_bends(location, sigma, bias, plan, share, start, stop):
    """Let sigma (A, H, W) hold the bias of windows and blur, rows start to stop.

    location: (A, H, W), NaN where not decoded; bias: `bias.squared_bias`, which sigma
    holds already; share: half the variance of what is averaged, px^2. sigma may be
    marked by a minus sign.
    """
    height, width = location.shape[1:]
    gain = np.float32(share * OF_SIGMA / HALF**2)
    by_noise = gain * gain * OF_NOISE
    for axis in range(len(location)):
        if not plan.used[axis]:
            continue
        at, squared = location[axis], plan.length[axis] * plan.length[axis]
        for y in range(max(start, HALF), min(stop, height - HALF)):
            here, above, below = at[y], at[y - HALF], at[y + HALF]
            spread, known = sigma[axis, y], bias[axis, y // SQUARE]
            for x in range(HALF, width - HALF):
                across = here[x - HALF] + here[x + HALF]
                off = gain * (across + above[x] + below[x] - 4 * here[x])
                own = spread[x] * spread[x]
                more = off * off - squared * known[x] - by_noise * own
                # Not so where one of the places is not known, which is NaN.
                clear = more / (BEYOND * by_noise * own) - _ONE
                clear = min(clear, _ONE) if clear > _ZERO else _ZERO
                wider = np.sqrt(own + (clear * more if clear > _ZERO else _ZERO))
                spread[x] = -wider if spread[x] < _ZERO else wider


@njit(cache=True, nogil=True, error_model="numpy")
def share_noise(sigma, bias, length, shared):
    """Multiply what noise has in sigma (A, H, W) by shared (A,), but not the bias.

    bias: `bias.squared_bias`; length: (A,) of a period. sigma may be marked by a minus
    sign.
    """
    for axis in range(len(sigma)):
        more = shared[axis] * shared[axis] - 1
        squared = more * length[axis] * length[axis]
        for y in range(sigma.shape[1]):
            spread, known = sigma[axis, y], bias[axis, y // SQUARE]
            for x in range(len(spread)):
                own = spread[x] * spread[x]
                wider = np.sqrt(own + more * own - squared * known[x])
                spread[x] = -wider if spread[x] < _ZERO else wider
