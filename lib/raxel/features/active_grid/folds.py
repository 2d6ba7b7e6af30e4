"""Where a surface is folded: places go on without a jump, but by another step.

Facets of a mirror that meet edge to edge show it, and so do caustics, where places turn
round. A window and a blur of variance s^2 together put a fold, where the step changes
by d per px, off by s d / sqrt(2 pi). On one surface, however bent, the second
difference of places over some pixels lies between those beside it, or nearly so. At a
fold it does not, and says how large d is.
"""

import numpy as np
from numba import njit

from raxel.features.active_grid.bias import OF_SIGMA

HALF = 8  # px; of a second difference, which lies 2 HALF from those beside it
# Variance, in that of a place, of such a difference less the mean of those beside it.
OF_PLACES = 7.0
# Three standard deviations of it; sigma that noise has widened does no harm.
OF_NOISE = np.float32(3 * np.sqrt(OF_PLACES))
BENT = np.float32(0.5)  # of those beside: a smooth surface may depart so much
# Differences that scatter more than noise lets them, by noise that neighbours share or
# by ripples, do so far from folds as well, where they are least: a quarter of those of
# a normal law are within 0.3186. Rows that are looked at for it.
ROWS, MANY, PART, OF_PART = 64, 100, 0.25, 0.3186
_ZERO, _HALF = np.float32(0), np.float32(0.5)


def scatter_of_places(location, sigma, used):
    """(A,) float32: standard deviations of places over stated ones, 1 at least.

    location, sigma: (A, H, W), NaN where not decoded; used: (A,), 0 without phases.
    """
    height, width = location.shape[1:]
    scatter = np.ones(len(used), np.float32)
    rows, last = slice(None, None, -(-height // ROWS)), max(width - 6 * HALF, 0)
    for axis in np.flatnonzero(used):
        p = [location[axis, rows, k : k + last] for k in range(0, 7 * HALF, HALF)]
        apart = 2 * p[3] - (p[2] + p[4]) / 2 - p[1] - p[5] + (p[0] + p[6]) / 2
        apart = np.abs(apart / sigma[axis, rows, 3 * HALF : 3 * HALF + last])
        known = apart[np.isfinite(apart)]
        if len(known) > MANY:
            usual = np.quantile(known, PART) / OF_PART / np.sqrt(OF_PLACES)
            scatter[axis] = max(1.0, usual)
    return scatter


@njit(cache=True, nogil=True, error_model="numpy")
def _fold_beyond(a, b, c, d, e, f, g, out):
    """Raise out (n,) to by how much the second difference of (n,) places c, d, e is
    beyond those of a, b, c and e, f, g and what it may be; NaN counts as nothing."""
    for x in range(len(out)):
        left, right = a[x] - 2 * b[x] + c[x], e[x] - 2 * f[x] + g[x]
        own = c[x] - 2 * d[x] + e[x]
        low = left if left < right else right
        high = right if left < right else left
        above, under = own - high, low - own
        off = above if above > under else under
        off -= BENT * _HALF * (abs(left) + abs(right))
        out[x] = off if off > out[x] else out[x]


@njit(cache=True, nogil=True, error_model="numpy")
def _widen(spread, off, limit, gain):
    """Widen spread (n,), which may be marked by a minus sign, where off is too far."""
    for x in range(len(off)):
        far = off[x] if off[x] > limit * abs(spread[x]) else _ZERO
        wider = np.sqrt(spread[x] * spread[x] + gain * far * far)
        spread[x] = -wider if spread[x] < _ZERO else wider


@njit(cache=True, nogil=True, error_model="numpy")
def widen_at_folds(location, sigma, scatter, used, share, start, stop):
    """Let sigma (A, H, W) hold what windows and blur do to folds, rows start to stop.

    scatter: as `scatter_of_places`; share: by how much a place is off at a fold, of
    what its second difference is. sigma may be marked by a minus sign.
    """
    height, width = location.shape[1:]
    reach, gain = 3 * HALF, np.float32((share * OF_SIGMA) ** 2)
    off, n = np.empty(width, np.float32), width - 6 * HALF
    for axis in range(len(location)):
        if not used[axis]:
            continue
        p, limit = location[axis], OF_NOISE * scatter[axis]
        for y in range(start, min(stop, height)):
            off[:] = _ZERO
            if n > 0:
                r = p[y]
                left, right = (
                    (r[:n], r[HALF:], r[2 * HALF :]),
                    (r[4 * HALF :], r[5 * HALF :], r[6 * HALF :]),
                )
                _fold_beyond(*left, r[reach:], *right, off[reach : reach + n])
            if reach <= y < height - reach:
                above = p[y - reach], p[y - 2 * HALF], p[y - HALF]
                below = p[y + HALF], p[y + 2 * HALF], p[y + reach]
                _fold_beyond(*above, p[y], *below, off)
            _widen(sigma[axis, y], off, limit, gain)


def share_at_folds(variance):
    """By how much a place is off at a fold, of what its second difference is.

    variance: of windows and blur together, px^2. The difference itself is less by twice
    that; blur of more than it spans is none that is decoded.
    """
    off = np.sqrt(variance / (2 * np.pi))
    return float(off / max(HALF - 2 * off, HALF / 4))
