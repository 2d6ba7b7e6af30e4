"""Lens models by polynomials: polar, radial laws, and rays in closed form.

Models that give the ray in closed form: (p, f(|p|)) with a polynomial f.

The depth f may pass through zero: then the ray has a negative z.
"""

from __future__ import annotations

import abc
import math

import numpy as np
from numpy.typing import ArrayLike

from raxel.cameras.core.base import (
    check_size,
    checked_array,
    checked_calibration_matrix,
    checked_positive,
    checked_word,
)
from raxel.cameras.lenses.azimuthal import (
    AzimuthalCamera,
    PlaneLaw,
    invert_rising,
    smallest_positive_root,
)
from raxel.cameras.lenses.perspective import distortion_warp
from raxel.cameras.lenses.plane_map import PlaneMap
from raxel.errors import InputError

# Polynomials of the radius for both polar coordinates of the image plane (2.2.2).


ORDER = 5


class PolarMap(PlaneMap):
    """(r, phi) to (a1 r + a2 r^2 + ..., phi + b1 r + b2 r^2 + ...).

    As a complex number the image of p is p A(r) exp(i B(r)), with A the radial
    polynomial over r and B the turn.
    """

    def __init__(self, radial, tangential, radius):
        self._stretch = np.asarray(radial, float)[::-1]
        self._rise = np.arange(len(radial), 0, -1) * self._stretch
        self._turn = np.append(np.asarray(tangential, float)[::-1], 0.0)
        super().__init__(radius, azimuths=1)
        # This also detects a minimum of the slope between two rings of the scan.
        self.limit = min(self.limit, smallest_positive_root(self._rise[::-1]))

    def value(self, p):
        z, factor, _ = self._polar(p)
        return _pairs(z * factor)

    def jacobian(self, p):
        z, factor, change = self._polar(p)
        # d(z F) = F dz + z F' dr, and dr is the part of dz along z.
        unit = _pairs(z) / np.where(z != 0, np.abs(z), 1.0)[:, None]
        J = np.stack([_pairs(factor), _pairs(1j * factor)], axis=2)
        return J + _pairs(z * change)[:, :, None] * unit[:, None]

    def invert(self, q):
        """Points (N, 2) that map to `q` (N, 2), first r, then phi; which exist (N,)."""
        with np.errstate(over="ignore", invalid="ignore"):
            image = q[:, 0] + 1j * q[:, 1]
            reach = np.abs(image)
            inside = reach <= self._radius(np.array(self.limit))
            r = invert_rising(
                self._radius, self._slope, np.where(inside, reach, 0.0), self.limit
            )
            z = image * np.exp(-1j * np.polyval(self._turn, r))
            z = z * (r / np.where(reach > 0, reach, 1.0))
        return np.where(inside[:, None], _pairs(z), np.nan), inside

    def _radius(self, r):
        return r * np.polyval(self._stretch, r)

    def _slope(self, r):
        return np.polyval(self._rise, r)

    def _polar(self, p):
        """p as a complex number, F = A exp(i B), and its derivative with r."""
        z = p[:, 0] + 1j * p[:, 1]
        r = np.abs(z)
        stretch, turn = np.polyval(self._stretch, r), np.polyval(self._turn, r)
        rate = np.polyval(np.polyder(self._stretch), r)
        rate = rate + 1j * stretch * np.polyval(np.polyder(self._turn), r)
        direction = np.exp(1j * turn)
        return z, stretch * direction, rate * direction


def _pairs(z):
    """Complex numbers (N,) as rows (N, 2)."""
    return np.column_stack([z.real, z.imag])


class ShahAggarwalCamera(PlaneLaw, AzimuthalCamera):
    """Pinhole whose image is distorted by two polynomials of fifth order.

    With (r, phi) the polar coordinates of the undistorted point (X / Z, Y / Z), the
    distorted one has

        radius a1 r + a2 r^2 + a3 r^3 + a4 r^4 + a5 r^5,
        azimuth phi + b1 r + b2 r^2 + b3 r^3 + b4 r^4 + b5 r^5.

    The camera sees points with Z > 0 inside the first circle on which the radius stops
    rising. The thesis states that radial and tangential distortion have a polynomial of
    fifth order each, ten parameters together. It does not print the formula; this is a
    form that has both, not a copy of the paper's. There are 15 parameters with the five
    of K, one of them twice: the size of K and that of the a.

    Parameters
    ----------
    K : array_like, shape (3, 3)
        Calibration matrix of the form (2.1), px.
    radial : array_like, shape (5,)
        (a1, ..., a5), a1 > 0.
    tangential : array_like, shape (5,)
        (b1, ..., b5), rad.
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
    Shah and Aggarwal 1994, A simple calibration procedure for fish-eye (high
    distortion) lens camera, IEEE Int. Conf. on Robotics and Automation.
    """

    kind = "shah-aggarwal"

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
        self.radial = checked_array("radial", radial, (ORDER,))
        self.tangential = checked_array("tangential", tangential, (ORDER,))
        if not self.radial[0] > 0:
            raise InputError(
                f"field 'radial': found a1 = {self.radial[0]:g}; give a positive a1 "
                "(the radius must rise from the axis)"
            )
        self._set_up(
            self.K[:2, :2],
            self.K[:2, 2],
            max_angle,
            math.pi / 2,
            math.inf,
            lambda radius: PolarMap(self.radial, self.tangential, radius),
        )

    @property
    def parameters(self) -> int:
        """The five of K, and both polynomials."""
        return 5 + 2 * ORDER


# Radial laws with one or two parameters: the FOV model and two fisheye models.


LAWS = ("rational", "sine")


class FieldOfViewCamera(AzimuthalCamera):
    """The FOV model: r = arctan(2 tan(theta) tan(omega / 2)) / omega.

    At 2 tan(omega / 2) = 1 the law is that of equidistance. As published the law
    displaces points of the image plane, so it sees less than 90 degrees off the axis; r
    ends at pi / (2 omega). It has 6 + n parameters.

    Parameters
    ----------
    omega : float
        The model's field of view, rad in (0, pi).
    K : array_like, shape (3, 3)
        Calibration matrix of the form (2.1), px.
    width, height : int
        Size of the image, px.
    radial : array_like, shape (n,)
        Coefficients of (2.4) applied to the point that the law gives, for lenses that
        omega alone does not describe.
    max_angle : float, optional
        Largest angle to the axis, rad; the law's own limit if omitted.

    Raises
    ------
    InputError
        A field has values that no such camera can have; the message names it.

    References
    ----------
    Devernay and Faugeras 2001, doi:10.1007/PL00013269.
    """

    kind = "field of view"

    def __init__(
        self,
        omega: float,
        K: ArrayLike,
        width: int,
        height: int,
        radial: ArrayLike = (),
        max_angle: float | None = None,
    ) -> None:
        check_size(self, width, height)
        self.omega = float(checked_array("omega", omega, ()))
        if not 0 < self.omega < math.pi:
            raise InputError(
                f"field 'omega': found {omega}; give radians between 0 and pi"
            )
        self.K = checked_calibration_matrix(K)
        self.radial = checked_array("radial", radial, (None,))
        self._double = 2 * math.tan(self.omega / 2)
        self._set_up(
            self.K[:2, :2],
            self.K[:2, 2],
            max_angle,
            math.pi / 2,
            math.pi / (2 * self.omega),
            distortion_warp(self.radial, np.zeros(2)),
        )

    @property
    def parameters(self) -> int:
        """omega, the five of K, and the radial ones."""
        return 6 + len(self.radial)

    def _within(self, angle):
        # The plane has no point for a ray parallel to it.
        return super()._within(angle) & (angle < math.pi / 2)

    def _radius(self, angle):
        ahead = np.cos(angle)
        return np.arctan2(self._double * np.sin(angle), ahead) / self.omega

    def _angle(self, radius):
        turn = self.omega * radius
        return np.arctan2(np.sin(turn), self._double * np.cos(turn))


class MicusikPajdlaCamera(AzimuthalCamera):
    """Two fisheye laws that add one parameter b to equidistance (2.6).

    Law 'rational' is theta = a r / (1 + b r^2), found for the Nikon FC-E8. Law 'sine'
    is r = (a / b) sin(b theta), found for a Sigma 8 mm lens. With b = 0 both are
    equidistance, with f = 1 / a and f = a. The rational law turns at r = 1 / sqrt(b),
    theta = a / (2 sqrt(b)), the sine law at theta = pi / (2 b). It has 4 parameters.

    Parameters
    ----------
    law : str
        'rational' or 'sine'.
    a : float
        rad / px for 'rational', px / rad for 'sine'.
    b : float
        1 / px^2 for 'rational', a pure number for 'sine'.
    principal_point : array_like, shape (2,)
        Principal point, px.
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
    Micusik and Pajdla 2006, Structure from motion with wide circular field of view
    cameras, IEEE Transactions on Pattern Analysis and Machine Intelligence 28(7).
    """

    kind = "micusik-pajdla"

    def __init__(
        self,
        law: str,
        a: float,
        b: float,
        principal_point: ArrayLike,
        width: int,
        height: int,
        max_angle: float | None = None,
    ) -> None:
        check_size(self, width, height)
        self.law = checked_word("law", law, LAWS)
        self.a = float(checked_positive("a", a))
        self.b = float(checked_array("b", b, ()))
        self.principal_point = checked_array("principal_point", principal_point, (2,))
        self._set_up(np.eye(2), self.principal_point, max_angle, *self._own_limits())

    @property
    def parameters(self) -> int:
        """a, b and the principal point."""
        return 4

    def _own_limits(self):
        a, b = self.a, self.b
        if self.law == "sine":
            turn = math.pi / (2 * abs(b)) if b else math.inf
            return turn, a / abs(b) if b else math.inf
        if b > 0:
            return a / (2 * math.sqrt(b)), 1 / math.sqrt(b)
        return math.inf, math.inf

    def _radius(self, angle):
        if self.law == "sine":
            return self.a * angle * np.sinc(self.b * angle / math.pi)
        # The stable root of b theta r^2 - a r + theta = 0, zero at theta = 0.
        root = np.sqrt(np.maximum(self.a**2 - 4 * self.b * angle**2, 0.0))
        return 2 * angle / (self.a + root)

    def _angle(self, radius):
        if self.law == "rational":
            return self.a * radius / (1 + self.b * radius**2)
        if self.b == 0:
            return radius / self.a
        return np.arcsin(np.minimum(abs(self.b) * radius / self.a, 1.0)) / abs(self.b)


class RayPolynomialCamera(AzimuthalCamera):
    """theta = atan2(r, f(r)), rising up to the first positive root of f - r f'."""

    @abc.abstractmethod
    def _depths(self):
        """Ascending coefficients of f."""

    def _own_limits(self, name):
        depth = self._depths()
        if depth[0] == 0:
            raise InputError(
                f"field '{name}': the first coefficient is 0; give a nonzero depth of "
                "the image centre, positive to look along +z"
            )
        self._look = math.copysign(1.0, depth[0])
        depth = self._look * depth
        self._poly = depth[::-1]
        powers = np.arange(len(depth))
        self._rise = ((1 - powers) * depth)[::-1]
        self._change = (powers * depth)[:0:-1]
        self._turn = smallest_positive_root(self._rise[::-1])
        if np.isfinite(self._turn):
            return self._at(self._angle, self._turn), self._turn
        return self._far_angle(), math.inf

    def _far_angle(self):
        """Limit of theta far out, without a turning point."""
        highest = np.trim_zeros(self._poly, "f")
        if len(highest) == 1:
            return math.pi / 2
        if len(highest) == 2:
            return math.atan2(1.0, highest[0])
        # theta rises without bound, so f falls faster than r.
        return math.pi

    def _radius(self, angle):
        def slope(r):
            f = np.polyval(self._poly, r)
            return np.polyval(self._rise, r) / (f * f + r * r)

        return invert_rising(self._angle, slope, angle, self._turn)

    def _angle(self, radius):
        return np.arctan2(radius, np.polyval(self._poly, radius))


class DivisionCamera(RayPolynomialCamera):
    """Division model: undistorted = distorted / (1 + l1 r^2 + l2 r^4 + ...).

    r is the radius of the distorted point in lens-centric normalised coordinates. The
    model is a displacement in the image plane: it ends where the denominator vanishes,
    at 90 degrees, or turns before. It has 5 + n parameters; n = 1 is the form of
    Fitzgibbon.

    Parameters
    ----------
    K : array_like, shape (3, 3)
        Calibration matrix of the form (2.1), px.
    coefficients : array_like, shape (n,)
        l1, l2, ..., n >= 1.
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
    Fitzgibbon 2001, doi:10.1109/CVPR.2001.990465.
    """

    kind = "division"

    def __init__(
        self,
        K: ArrayLike,
        coefficients: ArrayLike,
        width: int,
        height: int,
        max_angle: float | None = None,
    ) -> None:
        check_size(self, width, height)
        self.K = checked_calibration_matrix(K)
        self.coefficients = checked_array("coefficients", coefficients, (None,))
        if len(self.coefficients) < 1:
            raise InputError(
                "field 'coefficients': found none; give at least l1 (0 for a pinhole)"
            )
        angle, radius = self._own_limits("coefficients")
        edge = smallest_positive_root(self._poly[::-1])
        if edge <= radius:
            angle, radius = math.pi / 2, edge
        self._set_up(self.K[:2, :2], self.K[:2, 2], max_angle, angle, radius)

    @property
    def parameters(self) -> int:
        """The five of K and the coefficients."""
        return 5 + len(self.coefficients)

    def _within(self, angle):
        # The plane has no point for a ray parallel to it.
        return super()._within(angle) & (angle < math.pi / 2)

    def _depths(self):
        depth = np.zeros(2 * len(self.coefficients) + 1)
        depth[0] = 1
        depth[2::2] = self.coefficients
        return depth


class TardifCamera(RayPolynomialCamera):
    """Radially symmetric camera whose focal length f(r) is a full-order polynomial.

    f(r) = c0 + c1 r + c2 r^2 + ..., with all powers of r; the ray of p is (p, f(|p|)).
    It passes 90 degrees where f changes sign. With c0 < 0 the centre of the image looks
    along -z. It has n + 2 parameters for n coefficients.

    Parameters
    ----------
    coefficients : array_like, shape (n,)
        c0, c1, ..., for r in px from the principal point.
    principal_point : array_like, shape (2,)
        Principal point, px.
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
    Tardif, Sturm and Roy 2006, HAL inria-00387130.
    """

    kind = "tardif"

    def __init__(
        self,
        coefficients: ArrayLike,
        principal_point: ArrayLike,
        width: int,
        height: int,
        max_angle: float | None = None,
    ) -> None:
        check_size(self, width, height)
        self.coefficients = checked_array("coefficients", coefficients, (None,))
        if len(self.coefficients) < 1:
            raise InputError("field 'coefficients': found none; give at least c0")
        self.principal_point = checked_array("principal_point", principal_point, (2,))
        limits = self._own_limits("coefficients")
        self._set_up(np.eye(2), self.principal_point, max_angle, *limits)

    @property
    def parameters(self) -> int:
        """The coefficients and the principal point."""
        return len(self.coefficients) + 2

    def _depths(self):
        return self.coefficients


class ScaramuzzaCamera(RayPolynomialCamera):
    """Scaramuzza's polynomial (2.10): r = (p, a0 + a2 |p|^2 + a3 |p|^3 + ...).

    p is in sensor coordinates; there is no a1, because theta would not be smooth on the
    axis. Pixels = [[c, d], [e, 1]] p + centre. Here p = (u, v), where the published
    toolbox counts rows first. With a0 < 0, the toolbox's sign, the centre of the image
    looks along -z. It has n + 5 parameters for n coefficients.

    Parameters
    ----------
    coefficients : array_like, shape (n,)
        (a0, a2, a3, ..., an).
    centre : array_like, shape (2,)
        Centre of the image, px.
    width, height : int
        Size of the image, px.
    affine : array_like, shape (3,)
        (c, d, e), with c - d e > 0.
    max_angle : float, optional
        Largest angle to the axis, rad; the law's own limit if omitted.

    Raises
    ------
    InputError
        A field has values that no such camera can have; the message names it.

    References
    ----------
    Scaramuzza, Martinelli and Siegwart 2006, doi:10.1109/ICVS.2006.3.
    """

    kind = "scaramuzza"

    def __init__(
        self,
        coefficients: ArrayLike,
        centre: ArrayLike,
        width: int,
        height: int,
        affine: ArrayLike = (1, 0, 0),
        max_angle: float | None = None,
    ) -> None:
        check_size(self, width, height)
        self.coefficients = checked_array("coefficients", coefficients, (None,))
        if len(self.coefficients) < 1:
            raise InputError("field 'coefficients': found none; give at least a0")
        self.centre = checked_array("centre", centre, (2,))
        self.affine = checked_array("affine", affine, (3,))
        c, d, e = self.affine
        if not c - d * e > 0:
            raise InputError(
                f"field 'affine': found (c, d, e) = {self.affine.tolist()}; give "
                "values with c - d e above 0"
            )
        limits = self._own_limits("coefficients")
        self._set_up([[c, d], [e, 1]], self.centre, max_angle, *limits)

    @property
    def parameters(self) -> int:
        """The polynomial's coefficients, c, d, e, and the centre."""
        return len(self.coefficients) + 5

    def _depths(self):
        return np.concatenate([self.coefficients[:1], [0.0], self.coefficients[1:]])
