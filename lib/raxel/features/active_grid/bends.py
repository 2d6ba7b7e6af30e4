"""Where places bend within a few pixels: the bias of windows and blur at each pixel.

`bias` knows it for squares of the picture, before anything is decoded. A mirror that
curves strongly, or whose surface ripples, changes its bending within a square. Second
differences of the decoded places over some pixels tell it there; near the rim of what
is decoded, those of the nearest pixels that have them.
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
def _wider(off, known, by_noise, spread):
    """A sigma (minus: marked) with the bias `off` as far as it is more than is known
    (squared), and than noise makes of it."""
    own = spread * spread
    more = off * off - known - by_noise * own
    # Not so where one of the places is not known, which is NaN.
    clear = more / (BEYOND * by_noise * own) - _ONE
    clear = min(clear, _ONE) if clear > _ZERO else _ZERO
    wider = np.sqrt(own + (clear * more if clear > _ZERO else _ZERO))
    return -wider if spread < _ZERO else wider


@njit(cache=True, nogil=True, error_model="numpy")
def _nearest_bend(at, y, x, down, right):
    """Second difference over (down, right) px, or so far before or behind the pixel
    where it is not known there; 0 where it is not known at all."""
    height, width = at.shape
    for shift in (0, 1, -1):
        v, u = y + (shift - 1) * down, x + (shift - 1) * right
        if v < 0 or u < 0 or v + 2 * down >= height or u + 2 * right >= width:
            continue
        ends = at[v, u] + at[v + 2 * down, u + 2 * right]
        bend = ends - 2 * at[v + down, u + right]
        if not np.isnan(bend):
            return bend
    return _ZERO


@njit(cache=True, nogil=True, error_model="numpy")
def _widen_inside(at, y, gain, of_noise, known, spread):
    """A row of pixels, where places about each are decoded."""
    here, above, below = at[y], at[y - HALF], at[y + HALF]
    for x in range(HALF, len(here) - HALF):
        across = here[x - HALF] + here[x + HALF]
        off = gain * (across + above[x] + below[x] - 4 * here[x])
        spread[x] = _wider(off, known[x], of_noise, spread[x])


@njit(cache=True, nogil=True, error_model="numpy")
def _widen_at_rims(at, y, gain, of_noise, known, spread):
    """A row of pixels, where some place about them is not decoded."""
    height, width = at.shape
    inside = HALF <= y < height - HALF
    for x in range(width):
        if np.isnan(at[y, x]):
            continue
        if inside and HALF <= x < width - HALF:
            across = at[y, x - HALF] + at[y, x + HALF]
            if not np.isnan(across + at[y - HALF, x] + at[y + HALF, x]):
                continue
        bend = _nearest_bend(at, y, x, 0, HALF) + _nearest_bend(at, y, x, HALF, 0)
        spread[x] = _wider(gain * bend, known[x], of_noise, spread[x])


@njit(cache=True, nogil=True, error_model="numpy")
def widen_at_bends(location, sigma, bias, plan, share, start, stop):
    """Let sigma (A, H, W) hold the bias of windows and blur, rows start to stop.

    location: (A, H, W), NaN where not decoded; bias: `bias.squared_bias`, which sigma
    holds already; share: half the variance of what is averaged, px^2. sigma may be
    marked by a minus sign.
    """
    height = location.shape[1]
    gain = np.float32(share * OF_SIGMA / HALF**2)
    by_noise = gain * gain * OF_NOISE
    for axis in range(len(location)):
        if not plan.used[axis]:
            continue
        at, squared = location[axis], plan.length[axis] * plan.length[axis]
        for y in range(start, min(stop, height)):
            known, spread = squared * bias[axis, y // SQUARE], sigma[axis, y]
            if HALF <= y < height - HALF:
                _widen_inside(at, y, gain, by_noise, known, spread)
            _widen_at_rims(at, y, gain, by_noise, known, spread)


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
