"""Which period is seen, by the phases of sines of several periods.

The sines that places are read from leave the number of their period open. For each
number that the monitor has, the phases of the others are known; that one is taken which
they fit best, by least squares over the place with the variances of all phases. How
much worse the next best fits says how likely it is the right one: a sum of squares
larger by d makes a number exp(d / 2) times less likely.
"""

from typing import NamedTuple

import numpy as np
from numba import njit
from scipy.stats import chi2

# With such a lead the next best number of a period has one chance in a million.
MIN_LEAD = 2 * np.log(1e6)
# Sums of squares of phases, in variances, that no place explains.
FAR = 25.0
# Standard deviations of a place, by which it may seem to lie beyond the monitor.
BEYOND_BORDER = np.float32(6)


class Phases(NamedTuple):
    """Of F sines, those of places first, at (h, w) pixels: turns and their variances
    (F, h, w) float32; lit (h, w): whether all are seen."""

    turns: np.ndarray
    variances: np.ndarray
    lit: np.ndarray


class PlaceFit(NamedTuple):
    """Of each pixel (h, w): place in periods of the first sines, the sum of squares
    that it leaves in variances, and by how much that of the next best is larger."""

    place: np.ndarray
    left: np.ndarray
    lead: np.ndarray

    def told(self, scatter):
        """(h, w) bool: where no other period is likely; scatter: as `scatter_of`."""
        return (self.lead > MIN_LEAD * scatter) & (self.left < FAR * scatter)


def share_told(turns, variances, periods):
    """Of P pixels, the share whose period is told; turns, variances: (F, P)."""
    lit = np.ones((1, turns.shape[1]), bool)
    phases = Phases(turns[:, None], variances[:, None], lit)
    fit = fitted_periods(phases, periods)
    return float(np.mean(fit.told(scatter_of([phases], periods))))


def usual_misfit(turns, variances, periods):
    """Of P pixels of F sines (F, P): by how many periods each is off the places of the
    first, in the mean (F,), and its periods over those of the first (F,)."""
    lit = np.ones((1, turns.shape[1]), bool)
    fit = fitted_periods(Phases(turns[:, None], variances[:, None], lit), periods)
    shares = periods / periods[0]
    off = fit.place[0] * shares[:, None] - turns
    return np.mean(off - np.round(off), axis=1), shares


def scatter_of(parts, periods):
    """By how much sums of squares of phases are larger than noise makes them, or 1."""
    left = np.concatenate(
        [fitted_periods(part, periods).left[part.lit] for part in parts]
    )
    usual = chi2.median(len(periods) - 1)
    return max(1.0, np.median(left) / usual) if len(left) else 1.0


def fitted_periods(phases, periods):
    """The PlaceFit of each pixel; periods: (F,) across the monitor."""
    shape = phases.lit.shape
    fit = PlaceFit(*(np.zeros(shape, np.float32) for _ in range(3)))
    turns, variances = (np.ascontiguousarray(array) for array in phases[:2])
    _fit_periods(turns, variances, phases.lit, periods, *fit)
    return fit


@njit(cache=True, nogil=True, error_model="numpy")
def _fit_periods(turns, variances, lit, periods, place, left, lead):
    """Fill the arrays of PlaceFit where `lit`, a pixel after the other."""
    weights = np.empty(len(periods), np.float32)
    count = np.int64(np.ceil(periods[0]))
    for y in range(lit.shape[0]):
        for x in range(lit.shape[1]):
            if not lit[y, x]:
                continue
            total = np.float32(0)
            for j in range(len(periods)):
                weights[j] = 1 / variances[j, y, x]
                total += weights[j] * periods[j] * periods[j]
            beyond = BEYOND_BORDER * np.sqrt(variances[0, y, x])
            best = second = np.float32(np.inf)
            for k in range(-1, count + 1):
                at = k + turns[0, y, x]
                if at < -beyond or at > periods[0] + beyond:
                    continue
                squares = along = np.float32(0)
                for j in range(1, len(periods)):
                    off = at * (periods[j] / periods[0]) - turns[j, y, x]
                    off -= np.round(off)
                    squares += weights[j] * off * off
                    along += weights[j] * periods[j] * off
                squares -= along * along / total
                if squares < best:
                    second, best = best, squares
                    place[y, x] = at
                elif squares < second:
                    second = squares
            left[y, x], lead[y, x] = best, second - best
