"""Pinhole camera with radial distortion (2.1 to 2.4)."""

from __future__ import annotations

import math

import numba
import numpy as np
from numpy.typing import ArrayLike

from raxel.cameras.core.base import (
    Camera,
    Projection,
    Rays,
    as_rows,
    check_size,
    checked_array,
    checked_calibration_matrix,
)
from raxel.cameras.lenses.azimuthal import (
    AzimuthalCamera,
    PlaneLaw,
    smallest_positive_root,
)
from raxel.cameras.lenses.plane_map import PlaneMap

# Radial and decentring (tangential) distortion of the image plane.


class BrownMap(PlaneMap):
    """p (1 + k1 r^2 + k2 r^4 + ...) (2.4) plus the decentring of p1 and p2.

    With p = (x, y) the decentring is (2 p1 x y + p2 (r^2 + 2 x^2),
    p1 (r^2 + 2 y^2) + 2 p2 x y), OpenCV's order and signs. A thin prism adds
    (s1 r^2, s2 r^2).
    """

    def __init__(self, radial, tangential, radius, prism=(0.0, 0.0)):
        self._factor = np.concatenate([[1.0], radial])[::-1]
        # Derivative of the factor with respect to r^2.
        self._change = (np.arange(1, len(radial) + 1) * radial)[::-1]
        self._tangential, self._prism = tangential, prism
        if np.any(tangential) or np.any(prism):
            super().__init__(radius)
            return
        super().__init__(radius, azimuths=1)
        # This also detects a minimum of the slope between two rings of the scan.
        powers = np.arange(len(radial) + 1)
        slope = (1 + 2 * powers) * self._factor[::-1]
        turn = math.sqrt(smallest_positive_root(slope))
        if turn < self.limit * (1 - 1e-9):
            self.limit = turn

    def value(self, p):
        x, y = p.T
        p1, p2 = self._tangential
        s1, s2 = self._prism
        squared = x * x + y * y
        factor = np.polyval(self._factor, squared)
        return np.column_stack(
            [
                x * factor + 2 * p1 * x * y + p2 * (squared + 2 * x * x) + s1 * squared,
                y * factor + p1 * (squared + 2 * y * y) + 2 * p2 * x * y + s2 * squared,
            ]
        )

    def jacobian(self, p):
        x, y = p.T
        p1, p2 = self._tangential
        s1, s2 = self._prism
        squared = x * x + y * y
        factor = np.polyval(self._factor, squared)
        change = 2 * np.polyval(self._change, squared) if len(self._change) else 0.0
        across = change * x * y + 2 * p1 * x + 2 * p2 * y
        J = np.empty((len(p), 2, 2))
        J[:, 0, 0] = factor + change * x * x + 2 * p1 * y + (6 * p2 + 2 * s1) * x
        J[:, 0, 1], J[:, 1, 0] = across + 2 * s1 * y, across + 2 * s2 * x
        J[:, 1, 1] = factor + change * y * y + (6 * p1 + 2 * s2) * y + 2 * p2 * x
        return J


def distortion_warp(radial, tangential, prism=(0.0, 0.0)):
    """radius -> BrownMap on that disc, or None without distortion."""
    if not (np.any(radial) or np.any(tangential) or np.any(prism)):
        return None
    return lambda radius: BrownMap(radial, tangential, radius, prism)


class BrownCamera(PlaneLaw, AzimuthalCamera):
    """Pinhole with any number of radial terms (2.4) and two of decentring.

    Coefficients are for lens-centric normalised coordinates. The camera sees points
    with z > 0 inside the first circle r = tan(theta) on which the map folds. It has 5 +
    n + 2 parameters.

    Parameters
    ----------
    K : array_like, shape (3, 3)
        Calibration matrix of the form (2.1), px.
    radial : array_like, shape (n,)
        Radial coefficients, n >= 0.
    tangential : array_like, shape (2,)
        Decentring (p1, p2), in OpenCV's signs.
    width, height : int
        Size of the image, px.
    max_angle : float, optional
        Largest angle to the axis, rad; the law's own limit if omitted.

    Raises
    ------
    InputError
        A field has values that no such camera can have; the message names it.

    References
    ----------
    Brown 1971, Close-range camera calibration, Photogrammetric Engineering 37(8);
    Heikkila and Silven 1997, doi:10.1109/CVPR.1997.609468.
    """

    kind = "brown"

    def __init__(
        self,
        K: ArrayLike,
        radial: ArrayLike,
        tangential: ArrayLike,
        width: int,
        height: int,
        max_angle: float | None = None,
    ) -> None:
        check_size(self, width, height)
        self.K = checked_calibration_matrix(K)
        self.radial = checked_array("radial", radial, (None,))
        self.tangential = checked_array("tangential", tangential, (2,))
        warp = distortion_warp(self.radial, self.tangential)
        self._set_up(
            self.K[:2, :2], self.K[:2, 2], max_angle, math.pi / 2, math.inf, warp
        )

    @property
    def parameters(self) -> int:
        """The five of K, the radial ones, and p1, p2."""
        return 7 + len(self.radial)


@numba.njit(cache=True, error_model="numpy")
def _undistorting_factors(distorted, limit, factor, slope):
    """r / distorted radius on the rising branch, by Newton inside a bracket.

    The iteration is in log r: far out, where the highest power of r dominates, its
    logarithm is a straight line and one step suffices. limit: end of the branch;
    factor, slope: polynomials in r^2 of distorted / r and of its derivative by r. The
    result is 1 over the former, which rounding of r hardly moves.
    """
    found = np.empty_like(distorted)
    for n, target in enumerate(distorted):
        low, high, r, share = 1e-300, min(limit, 1e300), -1.0, 1.0
        new = min(target, high)
        while abs(new - r) > 1e-15 * abs(r) and target >= 1e-300:
            r, share, rate = new, 0.0, 0.0
            for k in range(len(factor)):
                share, rate = share * r * r + factor[k], rate * r * r + slope[k]
            image = r * share
            low, high = (r if image < target else low), (r if image > target else high)
            new = r * np.exp(np.log(target / image) * image / (r * rate))
            # Bisection where the tangent leaves the bracket keeps the branch.
            if not (abs(new - r) <= 1e-15 * r or low < new < high):
                new = np.sqrt(low) * np.sqrt(high)
        found[n] = 1 / share
    return found


class PerspectiveCamera(Camera):
    """Pinhole with calibration matrix K (2.1) and radial coefficients (2.4).

    As in OpenCV, the distorted point is p (1 + k1 r^2 + k2 r^4 + ...) with r = |p| and
    lens-centric normalised coordinates p = (x/z, y/z). The camera sees points with
    z > 0 at r below the first turning point of r (1 + k1 r^2 + ...). Beyond that the
    polynomial folds the scene back onto pixels that are taken. Pixels farther out than
    the turning point's image have no ray.

    Parameters
    ----------
    K : array_like, shape (3, 3)
        [[alpha f, s, p_x], [0, f, p_y], [0, 0, 1]], px.
    radial : array_like, shape (n,)
        Radial coefficients k1, k2, ..., n >= 0.
    width, height : int
        Size of the image, px.

    Raises
    ------
    InputError
        K has another form, or values are not finite.

    References
    ----------
    Thesis (2.1) to (2.4).

    Examples
    --------
    >>> from raxel.cameras import PerspectiveCamera
    >>> K = [[800, 0, 320], [0, 800, 240], [0, 0, 1]]
    >>> camera = PerspectiveCamera(K, [-0.1], 640, 480)
    >>> pixels = camera.project([[0.5, 0, 1]]).pixels
    >>> pixels.round(6)
    array([[710., 240.]])
    >>> rays = camera.rays(pixels)
    >>> (rays.directions / rays.directions[:, 2:]).round(6)
    array([[0.5, 0. , 1. ]])
    """

    kind = "perspective"
    central = True

    def __init__(
        self, K: ArrayLike, radial: ArrayLike, width: int, height: int
    ) -> None:
        check_size(self, width, height)
        self.K = checked_calibration_matrix(K)
        self.radial = checked_array("radial", radial, (None,))
        # Ascending odd polynomial in s = r^2: distorted r is r * factor(s).
        factor = np.concatenate([[1.0], self.radial])
        self._factor = factor[::-1]
        self._slope = (factor * (2 * np.arange(len(factor)) + 1))[::-1]
        self.max_radius = self._turning_point()
        self.max_distorted_radius = (
            self._distorted(self.max_radius) if np.isfinite(self.max_radius) else np.inf
        )

    @property
    def parameters(self) -> int:
        """The five of K (2.1) and the radial coefficients."""
        return 5 + len(self.radial)

    def project(self, points: ArrayLike) -> Projection:
        """Return the pixels of points.

        Parameters
        ----------
        points : array_like, shape (N, 3)
            Points in the camera frame, mm.

        Returns
        -------
        Projection
            Pixels (2.2 with R = I, C = 0, then 2.4) of points.
        """
        x, y, z = as_rows(points, 3).T
        ahead = np.where(z > 0, z, np.nan)
        with np.errstate(over="ignore", invalid="ignore"):
            p = np.column_stack([x / ahead, y / ahead])
            squared = np.sum(p**2, axis=1)
            p *= np.polyval(self._factor, squared)[:, None]
            pixels = p @ self.K[:2, :2].T + self.K[:2, 2]
            inside = squared < self.max_radius**2
        valid = inside & np.isfinite(pixels).all(axis=1)
        return Projection(np.where(valid[:, None], pixels, np.nan), valid)

    def _rays(self, pixels: ArrayLike) -> Rays:
        """Rays through the origin: 2.1, then the inverse of 2.4."""
        u, v = as_rows(pixels, 2).T
        y = (v - self.K[1, 2]) / self.K[1, 1]
        with np.errstate(invalid="ignore"):
            x = (u - self.K[0, 2] - self.K[0, 1] * y) / self.K[0, 0]
        distorted = np.hypot(x, y)
        valid = distorted < self.max_distorted_radius
        factor = np.full(len(distorted), np.nan)
        factor[valid] = _undistorting_factors(
            distorted[valid], self.max_radius, self._factor, self._slope
        )
        x, y, z = x * factor, y * factor, np.where(valid, 1.0, np.nan)
        # hypot does not overflow for far pixels, unlike their squares.
        d = np.column_stack([x, y, z]) / np.hypot(np.hypot(x, y), 1)[:, None]
        return Rays(np.where(valid[:, None], 0.0, np.nan) * d, d, valid)

    def _distorted(self, r):
        return r * np.polyval(self._factor, r * r)

    def _turning_point(self):
        """Smallest r > 0 where the distorted radius stops rising; inf if none."""
        roots = np.roots(self._slope)
        real = roots.real[roots.imag == 0]
        return np.sqrt(real[real > 0].min(initial=np.inf))

    def _fields(self):
        return {"K": self.K, "radial": self.radial}

    @classmethod
    def _from_file(cls, file):
        return cls(
            file.numbers("K"),
            file.numbers("radial"),
            file.number("width"),
            file.number("height"),
        )
