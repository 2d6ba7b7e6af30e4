"""Central cameras made of a radial law, a warp of the plane, and an affine map."""

from __future__ import annotations

import abc
import math

import numpy as np
from numpy.typing import ArrayLike

from raxel.cameras.core.base import Camera, Projection, Rays, as_rows, checked_array
from raxel.cameras.core.storage import NamedFields
from raxel.errors import InputError

# Rounding tolerance, so that a ray at the edge of the field of view is inside.
ANGLE_TOL_RAD = 1e-12


class AzimuthalCamera(NamedFields, Camera):
    """p = r(theta) (cos phi, sin phi) (2.5), then a warp of p, then an affine map.

    theta is the angle between the ray and that of the image centre, phi its azimuth.
    Classes define the law by `_radius` and `_angle` and pass its limits to `_set_up`.

    max_angle: rad; limit of the model. By default it is the law's own limit (its first
    turning point, 90 degrees for a model of the image plane, 180 at most).
    """

    central = True
    _warp = None
    # -1 where the image centre looks along -z.
    _look = 1.0

    @abc.abstractmethod
    def _radius(self, angle):
        """r(theta) for angles (N,) in [0, the law's limit]."""

    @abc.abstractmethod
    def _angle(self, radius):
        """theta for radii (N,) in [0, the radius of the limit]."""

    def _set_up(self, affine, centre, max_angle, own_angle, own_radius, warp=None):
        """Fix the affine map and the limits.

        affine: (2, 2), centre: (2,), pixels = affine p + centre. own_angle, own_radius:
        where the law ends (one may be inf). warp: radius -> PlaneMap on that disc.
        """
        self._affine, self._centre = np.array(affine, float), np.array(centre, float)
        reach, radius = min(float(own_angle), math.pi), float(own_radius)
        if own_angle > math.pi:
            radius = self._at(self._radius, math.pi)
        if max_angle is not None:
            self._check_angle(max_angle, reach)
            if max_angle < reach:
                reach = float(max_angle)
                radius = self._at(self._radius, reach)
        if warp is not None:
            self._warp = warp(radius)
            if self._warp.limit < radius:
                radius = self._warp.limit
                reach = min(reach, self._at(self._angle, radius))
                self._check_angle(max_angle, reach)
        if not (reach > 0 and radius > 0):
            raise InputError(
                f"{self.kind} camera: the image folds at its centre; give smaller "
                "distortion coefficients"
            )
        self.max_angle, self.max_radius = reach, radius
        self._asked_angle = max_angle

    def _check_angle(self, max_angle, reach):
        if max_angle is None:
            return
        checked_array("max_angle", max_angle, ())
        if not 0 < max_angle <= reach + 1e-9:
            raise InputError(
                f"field 'max_angle': found {max_angle:.6g} rad "
                f"({math.degrees(max_angle):.2f} degrees); give at most {reach:.6g} "
                f"({math.degrees(reach):.2f} degrees), the limit of the {self.kind} "
                "model with these coefficients"
            )

    def _within(self, angle):
        # The edge belongs to the field of view if it has an image.
        if np.isinf(self.max_radius):
            return angle < self.max_angle
        return angle <= self.max_angle + ANGLE_TOL_RAD

    @staticmethod
    def _at(function, value):
        return float(function(np.array([value]))[0])

    def _fields(self):
        # A given limit only: the law's own limit follows from the other fields.
        fields = super()._fields()
        del fields["max_angle"]
        if self._asked_angle is not None:
            fields["max_angle"] = np.array(float(self._asked_angle))
        return fields

    def project(self, points: ArrayLike) -> Projection:
        """Return the pixels of points.

        Parameters
        ----------
        points : array_like, shape (N, 3)
            Points in the camera frame, mm.

        Returns
        -------
        Projection
            Pixels of points.
        """
        points = as_rows(points, 3)
        x, y, z = points.T
        z = self._look * z
        with np.errstate(over="ignore", invalid="ignore"):
            across = np.hypot(x, y)
            angle = np.arctan2(across, z)
        valid = np.isfinite(points).all(axis=1) & ((across > 0) | (z > 0))
        valid &= self._within(angle)
        p = np.full((len(x), 2), np.nan)
        with np.errstate(all="ignore"):
            radius = self._radius(np.minimum(angle[valid], self.max_angle))
            unit = points[valid, :2] / np.where(across > 0, across, 1.0)[valid, None]
            p[valid] = radius[:, None] * unit
        valid &= np.isfinite(p).all(axis=1) & (np.hypot(*p.T) < np.inf)
        if self._warp is not None:
            p[valid], good = self._warp.apply(p[valid])
            valid[valid] = good
        with np.errstate(over="ignore", invalid="ignore"):
            pixels = p @ self._affine.T + self._centre
        valid &= np.isfinite(pixels).all(axis=1)
        return Projection(np.where(valid[:, None], pixels, np.nan), valid)

    def _rays(self, pixels: ArrayLike) -> Rays:
        """Rays through the origin."""
        with np.errstate(over="ignore", invalid="ignore"):
            offset = as_rows(pixels, 2) - self._centre
            p = offset @ np.linalg.inv(self._affine).T
        if self._warp is not None:
            p, _ = self._warp.invert(p)
        with np.errstate(all="ignore"):
            r = np.hypot(*p.T)
            valid = np.isfinite(r) & (r <= self.max_radius * (1 + ANGLE_TOL_RAD))
            angle = np.full(len(r), np.nan)
            angle[valid] = self._angle(np.minimum(r[valid], self.max_radius))
            valid &= self._within(angle)
            unit = p / np.where(r > 0, r, 1.0)[:, None]
            z = self._look * np.cos(angle)
            d = np.column_stack([unit * np.sin(angle)[:, None], z])
        d = np.where(valid[:, None], d, np.nan)
        return Rays(0.0 * d, d, valid)


class PlaneLaw:
    """Law of a plane perpendicular to the axis: r = tan(theta), in front only."""

    def _radius(self, angle):
        return np.tan(angle)

    def _angle(self, radius):
        return np.arctan(radius)


# Inverse of a rising function of one variable: Newton's method inside a bracket.


def smallest_positive_root(ascending):
    """Smallest real root > 0 of a polynomial with ascending coefficients; else inf."""
    descending = np.array(ascending, float)[::-1]
    # The root for so small a leading coefficient overflows.
    descending[np.abs(descending) < 1e-200 * np.abs(descending).max()] = 0
    roots = np.roots(np.trim_zeros(descending, "f"))
    # Rounding splits a double root, the inflection of a curve, into a complex pair.
    real = roots.real[np.abs(roots.imag) <= 1e-12 * np.abs(roots)]
    return float(real[real > 0].min(initial=np.inf))


N_NODES = 1025  # of the table of initial values


def invert_rising(function, slope, targets, high):
    """x in [0, high] with function(x) = targets, for a function rising from 0.

    targets: (N,) in [0, function(high)]; for an infinite `high` the targets must be
    below the function's supremum. Safeguarded: a tangent that leaves the bracket is
    replaced by bisection, so the iteration stays on the branch between 0 and `high`.
    """
    targets = np.asarray(targets, float)
    with np.errstate(all="ignore"):
        low, top, x = _bracket(function, targets, high)
        # Newton's method needs forty steps from the table to such small values.
        done = targets == 0
        x = np.where(done, 0.0, x)
        for _ in range(200):
            gap = function(x) - targets
            top = np.where(gap > 0, x, top)
            low = np.where(gap < 0, x, low)
            new = x - gap / slope(x)
            new = np.where((new >= low) & (new <= top), new, (low + top) / 2)
            # Converged values stay, so results do not depend on their neighbours.
            settled = (gap == 0) | (np.abs(new - x) <= 1e-15 * x) | (top <= low)
            x = np.where(done | (gap == 0), x, new)
            done |= settled
            if done.all():
                break
    return x


def _bracket(function, targets, high):
    """Ends of a bracket of each solution, and an initial value.

    For a finite range, from a table of the function. The table depends on the range
    only, so an initial value does not depend on the other targets.
    """
    if np.isfinite(high):
        nodes = np.linspace(0, high, N_NODES)
        values = np.maximum.accumulate(function(nodes))
        if np.isfinite(values).all():
            place = np.clip(np.searchsorted(values, targets), 1, N_NODES - 1)
            return nodes[place - 1], nodes[place], np.interp(targets, values, nodes)
    low = np.zeros_like(targets)
    top = np.full_like(targets, min(high, 1.0))
    while True:
        short = (function(top) < targets) & (top < min(high, 1e200))
        if not short.any():
            return low, top, (low + top) / 2
        low = np.where(short, top, low)
        top = np.where(short, np.minimum(2 * top, high), top)
