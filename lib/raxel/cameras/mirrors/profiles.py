"""Profiles z(x) of a thin sheet with loads, clamped at x = 0 in position and slope.

x runs from the clamp towards the free edge and z away from the light, in mm, as in the
frame of the mirror: a positive deflection bends the sheet away from the light and makes
the mirror convex. Loads act along z. So the bending moment at x is linear in x between
loads, and with q = P / (E I) the function
    m(x) = sum over loads of q (X t - t^2 / 2),   t = min(x, X),
is the slope of the small-deflection beam (5.1), and of a sheet that keeps its length
the *sine* of its slope angle (elastica: the curvature dm/dx is the moment over E I).
Beyond the last load the sheet is straight.
Source: thesis 5.1.1; Gere, Timoshenko 1991, Mechanics of Materials; for large
deflections Bisshopp, Drucker 1945, doi:10.1090/qam/13360.
"""

from __future__ import annotations

import numba
import numpy as np
from numpy.polynomial import chebyshev
from numpy.typing import ArrayLike, NDArray

from raxel.cameras.core.base import checked_array, checked_positive
from raxel.errors import InputError

# A function given by its derivative on pieces, fast and exact to rounding.


# Smooth derivatives of a bent sheet need about twenty terms on a piece.
N_TERMS = 48
COEFFICIENT_TOL = 1e-17


class RunningIntegral:
    """Values of the integral of `rate` from breaks[0], linear outside the breaks.

    breaks: (n + 1,) rising, mm; rate(x (m,)) -> (m,), smooth between breaks and
    continuous. Each piece is the integral of a Chebyshev series of degree N_TERMS - 1.
    """

    def __init__(self, breaks, rate):
        self.breaks = np.asarray(breaks, float)
        half = np.diff(self.breaks) / 2
        nodes = np.cos(np.pi * (np.arange(N_TERMS) + 0.5) / N_TERMS)
        series = np.linalg.inv(chebyshev.chebvander(nodes, N_TERMS - 1))
        x = self.breaks[:-1] + half * (1 + nodes[:, None])
        slopes = series @ np.reshape(rate(x.ravel()), x.shape)
        pieces = chebyshev.chebint(slopes, lbnd=-1, axis=0) * half
        gains = pieces.sum(axis=0)
        pieces[0] += np.concatenate([[0.0], np.cumsum(gains[:-1])])
        large = np.abs(pieces).max(axis=1) > COEFFICIENT_TOL * np.abs(pieces).max()
        self._pieces = pieces[: max(2, np.flatnonzero(large).max(initial=0) + 1)]
        self._end_slopes = rate(self.breaks[[0, -1]])

    def __call__(self, x):
        """Values at x (N,)."""
        return _running(x, self.breaks, self._pieces, self._end_slopes)


@numba.njit(cache=True, error_model="numpy")
def _running(x, breaks, pieces, end_slopes):
    """Values (N,) of a `RunningIntegral` at x (N,); series by Clenshaw's recurrence."""
    values = np.empty(len(x))
    for n in range(len(x)):
        inside = max(breaks[0], min(breaks[-1], x[n]))
        piece = 0
        while piece < len(breaks) - 2 and inside > breaks[piece + 1]:
            piece += 1
        place = 2 * (inside - breaks[piece]) / (breaks[piece + 1] - breaks[piece]) - 1
        above, value = 0.0, 0.0
        for term in range(len(pieces) - 1, 0, -1):
            above, value = value, pieces[term, piece] + 2 * place * value - above
        beyond = end_slopes[int(x[n] > inside)] * (x[n] - inside)
        values[n] = pieces[0, piece] + place * value - above + beyond
    return values


# Gauss-Legendre nodes between two loads, Newton steps, and their tolerance.
N_NODES, MAX_N_STEPS, STEP_TOL = 48, 60, 1e-14
# A sheet perpendicular to its clamp has no height function.
MAX_SINE, MAX_START_SINE = 0.98, 0.8


class BeamProfile:
    """Small deflections (5.1): the slopes of several loads add up.

    Parameters
    ----------
    loads : array_like, shape (k,)
        Positions of the loads, mm from the clamp, rising.
    forces : array_like, shape (k,)
        P / (E I) of each, mm^-2, positive away from the light.

    Raises
    ------
    InputError
        A field has values that no such camera can have; the message names it.

    References
    ----------
    Thesis (5.1).
    """

    law = "beam"

    def __init__(self, loads: ArrayLike, forces: ArrayLike) -> None:
        self.loads = checked_loads(loads)
        self.forces = checked_at_loads("forces", forces, self.loads)
        self.places = self.loads
        self._set_up()

    @classmethod
    def deflected(cls, loads: ArrayLike, deflections: ArrayLike) -> BeamProfile:
        """Return the profile with deflections (k,), mm, at `loads` (k,), mm."""
        loads, deflections = _checked_deflections(loads, deflections)
        return cls(loads, _beam_forces(loads, deflections))

    def _set_up(self):
        breaks = np.concatenate([[0.0], self.places])
        self._height = RunningIntegral(breaks, lambda x: self._slopes(x)[0])

    @property
    def breaks(self) -> NDArray[np.float64]:
        """x of the clamp and of each load (k + 1,), mm: the pieces are smooth."""
        return self._height.breaks

    def at(
        self, x: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
        """Return height (mm), slope and second derivative (mm^-1) at x.

        In front of the clamp all are zero; the second derivative jumps there.

        Parameters
        ----------
        x : ndarray, shape (N,)
            Positions, mm.

        Returns
        -------
        tuple of three ndarray, shape (N,)
            Height, slope and second derivative.
        """
        ahead = x >= 0
        slope, bend = self._slopes(np.where(ahead, x, 0.0))
        height = np.where(x > 0, self._height(x), 0.0)
        return height, slope, np.where(ahead, bend, 0.0)

    def _slopes(self, x):
        return _moments(x, self.places, self.forces)


class ElasticaProfile(BeamProfile):
    """Deflections of any size of a sheet that keeps its length.

    The attribute `places` (k,) holds the x of the loads, found to rounding.

    Parameters
    ----------
    loads : array_like, shape (k,)
        Positions of the loads, mm along the sheet from the clamp, rising.
    forces : array_like, shape (k,)
        As in `BeamProfile`.

    Raises
    ------
    InputError
        A field is not valid, or the forces bend the sheet up to a right angle.
    """

    law = "elastica"

    def __init__(self, loads: ArrayLike, forces: ArrayLike) -> None:
        self.loads = checked_loads(loads)
        self.forces = checked_at_loads("forces", forces, self.loads)
        self.places, _ = _balanced(self.loads, self.forces, None)
        self._set_up()

    @classmethod
    def deflected(cls, loads: ArrayLike, deflections: ArrayLike) -> ElasticaProfile:
        """Return the profile with deflections (k,), mm, at `loads` (k,), mm."""
        loads, deflections = _checked_deflections(loads, deflections)
        start = _beam_forces(loads, deflections)
        profile = cls.__new__(cls)
        profile.loads = loads
        profile.places, profile.forces = _balanced(loads, start, deflections)
        profile._set_up()
        return profile

    def _slopes(self, x):
        sine, bend = _moments(x, self.places, self.forces)
        cosine = np.sqrt(1 - sine**2)
        return sine / cosine, bend / cosine**3


PROFILES = {profile.law: profile for profile in (BeamProfile, ElasticaProfile)}


def checked_loads(loads):
    """Loads (k,), mm, or InputError unless they are positive and increasing."""
    loads = checked_array("loads", [loads] if np.isscalar(loads) else loads, (None,))
    checked_positive("loads", loads, loads.shape)
    if not (len(loads) and np.all(np.diff(loads) > 0)):
        raise InputError(
            f"field 'loads': found {loads.tolist()}; give at least one, in order of "
            "distance from the clamp"
        )
    return loads


def checked_at_loads(name, values, loads):
    """Values (k,), one for each of the loads (k,); a single number for a single load.

    Raises InputError naming the field.
    """
    values = [values] if np.isscalar(values) else values
    return checked_array(name, values, (len(loads),))


def _checked_deflections(loads, deflections):
    loads = checked_loads(loads)
    return loads, checked_at_loads("deflections", deflections, loads)


def _moments(x, places, forces):
    """m and its derivative (N,) at x (N,), see above."""
    directions = np.clip(x[:, None], 0, places)
    return (directions * (places - directions / 2)) @ forces, (
        places - directions
    ) @ forces


def _beam_forces(loads, deflections):
    """Forces of the small-deflection beam that passes through the deflections.

    Height at a load by the unit force of another: (5.1), and straight beyond.
    """
    lever = np.minimum(loads[:, None], loads)
    height = lever**2 * (3 * loads - lever) / 6
    height += (loads[:, None] - lever) * loads**2 / 2
    return np.linalg.solve(height, deflections)


def _balanced(loads, forces, deflections):
    """(places, forces) with loads at their positions along an elastica.

    deflections: (k,) mm, to be reached by other forces than those given, or None.
    Newton on the length and the height up to each load.
    """
    places, forces = np.array(loads), np.array(forces)
    wanted = None if deflections is None else np.concatenate([loads, deflections])
    too_steep = _too_steep(forces, deflections)
    count = len(loads)
    if wanted is not None:
        # The beam is softer than the sheet: large deflections start from less.
        forces /= max(1, _steepest(places, forces) / MAX_START_SINE)
    if not _upright(places, forces):
        raise too_steep
    for _ in range(MAX_N_STEPS):
        reached, slopes = _reached(places, forces)
        if wanted is None:
            gap, slopes = loads - reached[:count], slopes[:count, :count]
        else:
            gap = wanted - reached
        step = np.linalg.solve(slopes, gap)
        change = np.concatenate([step, np.zeros(2 * count - len(step))])
        while not _upright(places + change[:count], forces + change[count:]):
            change = change / 2
            if np.abs(change[:count]).max() < STEP_TOL:
                raise too_steep
        places, forces = places + change[:count], forces + change[count:]
        largest = np.abs(forces).max()
        if np.all(np.abs(change[:count]) <= STEP_TOL * loads) and np.all(
            np.abs(change[count:]) <= STEP_TOL * largest
        ):
            break
    else:
        # Steps at rounding level continue; anything larger is no solution.
        if np.abs(gap).max() > 1e-12 * loads[-1]:
            raise too_steep
    return places, forces


def _upright(places, forces):
    """Whether the loads are in order and the sheet is far from a right angle."""
    if places[0] <= 0 or np.any(np.diff(places) <= 0):
        return False
    return _steepest(places, forces) < MAX_SINE


def _steepest(places, forces):
    x, _ = _nodes(places)
    return np.abs(_moments(x.ravel(), places, forces)[0]).max()


def _too_steep(forces, deflections):
    if deflections is None:
        found = f"field 'forces': found {forces.tolist()} per mm^2"
    else:
        found = f"field 'deflections': found {deflections.tolist()} mm"
    return InputError(
        f"{found}, which bend the sheet to a right angle or beyond; give smaller values"
    )


def _nodes(places):
    """x and weights (k, N_NODES) of the quadrature from each position to the next."""
    node, weight = np.polynomial.legendre.leggauss(N_NODES)
    first = np.concatenate([[0.0], places[:-1]])
    half = (places - first)[:, None] / 2
    return first[:, None] + half * (1 + node), half * weight


def _reached(places, forces):
    """Lengths and heights (2 k,) up to the positions, and their derivatives (2 k, 2 k)
    by positions and forces."""
    x, weight = _nodes(places)
    directions = np.minimum(x[..., None], places)
    by_force = directions * (places - directions / 2)
    by_place = directions * forces
    sine = by_force @ forces
    cosine = np.sqrt(1 - sine**2)
    rates = np.stack([1 / cosine, sine / cosine])
    by_sine = np.stack([sine / cosine**3, 1 / cosine**3])
    values = np.cumsum(np.sum(weight * rates, axis=2), axis=1)
    both = np.concatenate([by_place, by_force], axis=-1)
    turned = np.einsum("kn,rkn,knj->rkj", weight, by_sine, both)
    slopes = np.cumsum(turned, axis=1)
    at_ends = _moments(places, places, forces)[0]
    cosine = np.sqrt(1 - at_ends**2)
    count = len(places)
    slopes[0, range(count), range(count)] += 1 / cosine
    slopes[1, range(count), range(count)] += at_ends / cosine
    return values.ravel(), slopes.reshape(2 * count, 2 * count)
