"""Where a blurred break of the camera or of what it sees goes through decoded pixels.

Two facets of a mirror, or two surfaces, show places far apart side by side, and a lens
spreads the jump over several pixels: no two of them need be far apart, and what they
show is a mixture of the two. On one surface, however bent, the step over some pixels
lies between the steps before and behind it. A jump does not.
"""

import numpy as np
from numba import njit

from raxel.features.active_grid.layout import BREAK, DECODED

# px; half of a step, which holds most of a jump that is no farther away.
HALF = 4
# Every other row is enough: what is marked is wider.
EVERY = 2
# Five standard deviations of the difference of two steps that share an end.
BEYOND = np.float32(5 * np.sqrt(6))
# Of a step; so little does a smooth surface depart where its bending turns round.
BENT = np.float32(0.1)
# Of a period; what four steps and more leave of a gamma is smaller, what three leave is
# taken off before (`response`), and where there is no noise, rounding to whole grey
# levels is none that a mean takes away.
MIN_SD = np.float32(0.02)
_HALF = np.float32(0.5)


@njit(cache=True, nogil=True, error_model="numpy")
def _beyond(first, middle, last):
    """By how much a step is beyond both others; below 0 where it lies between them."""
    low = first if first < last else last
    high = last if first < last else first
    above, under = middle - high, low - middle
    return above if above > under else under


@njit(cache=True, nogil=True, error_model="numpy")
def _may_jump(places, least):
    """Whether any of the middle steps is beyond both others by more than `least`.

    That takes a third of the time of `_mark_steps`, and few rows hold a jump.
    """
    a, b, c, d = places
    found = False
    for x in range(len(a)):
        found |= _beyond(b[x] - a[x], c[x] - b[x], d[x] - c[x]) > least
    return found


@njit(cache=True, nogil=True, error_model="numpy")
def _mark_steps(places, spreads, least, found):
    """Set where the middle step of (4, n) places, evenly apart, is beyond both others.

    spreads: (4, n), their standard deviations, which may be marked by a minus sign.
    Nothing is set where one of them is NaN.
    """
    a, b, c, d = places
    sa, sb, sc, sd = spreads
    for x in range(len(found)):
        first, last = b[x] - a[x], d[x] - c[x]
        outer = max(abs(sa[x]), abs(sd[x]))
        spread = max(outer, max(abs(sb[x]), abs(sc[x])))
        limit = least + BEYOND * spread + BENT * abs(_HALF * (first + last))
        # Where one of the others holds the jump, bending alone is no reason.
        limit += _HALF * abs(last - first)
        found[x] |= _beyond(first, c[x] - b[x], last) > limit


@njit(cache=True, nogil=True, error_model="numpy")
def find_breaks(location, sigma, used, length, start, stop, found):
    """Set found[y // EVERY, x], for rows from start to before stop, within a jump.

    location, sigma: (A, H, W) float32, NaN where not decoded; used: (A,), 0 where there
    are no phases, so that places are in steps as they should be; length: (A,), of a
    period; start: a multiple of EVERY. A jump nearer than 3 HALF px to what is not
    decoded is not seen across it.
    """
    height, width = location.shape[1:]
    reach = 3 * HALF
    for y in range(start, stop, EVERY):
        row = found[y // EVERY]
        row[:] = 0
        for axis in range(len(location)):
            if not used[axis]:
                continue
            at, sd, least = location[axis], sigma[axis], MIN_SD * length[axis]
            n = width - 2 * reach
            if n > 0:
                i, j, k = 2 * HALF, 4 * HALF, 6 * HALF
                p, s = at[y], sd[y]
                places = p[:n], p[i : i + n], p[j : j + n], p[k:]
                if _may_jump(places, least):
                    spreads = s[:n], s[i : i + n], s[j : j + n], s[k:]
                    _mark_steps(places, spreads, least, row[reach : reach + n])
            if reach <= y < height - reach:
                i, j, k, m = y - reach, y - HALF, y + HALF, y + reach
                places = at[i], at[j], at[k], at[m]
                if _may_jump(places, least):
                    _mark_steps(places, (sd[i], sd[j], sd[k], sd[m]), least, row)


@njit(cache=True, nogil=True, error_model="numpy")
def mark_breaks(near, location, sigma, status):
    """Take away the locations (A, H, W) of decoded pixels where `near` is not 0."""
    for y in range(len(status)):
        for x in range(len(status[y])):
            if near[y, x] and status[y, x] == DECODED:
                status[y, x] = BREAK
                location[:, y, x] = np.nan
                sigma[:, y, x] = np.nan
