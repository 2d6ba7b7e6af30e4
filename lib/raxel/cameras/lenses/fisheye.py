"""Ideal fisheye cameras: equidistance, equisolid angle, stereographic (2.5 to 2.8)."""

from __future__ import annotations

import math

import numpy as np
from numpy.typing import ArrayLike

from raxel.cameras.core.base import (
    Camera,
    Projection,
    Rays,
    as_rows,
    check_size,
    checked_array,
    checked_positive,
    checked_word,
)
from raxel.cameras.lenses.azimuthal import (
    AzimuthalCamera,
    invert_rising,
    smallest_positive_root,
)
from raxel.cameras.lenses.perspective import distortion_warp
from raxel.cameras.lenses.plane_map import PlaneMap
from raxel.errors import InputError

PROJECTIONS = ("equidistance", "equisolid", "stereographic")
# Rounding tolerance of an angle, so that a ray at the edge of the field is inside.
ANGLE_TOL_RAD = 1e-12


class FisheyeCamera(Camera):
    """A radially symmetric camera p = r(theta) (cos phi, sin phi) (2.5).

    theta is the angle to the principal axis (+z). With f the focal length in pixels,
    r is f theta (2.6, 'equidistance'), 2 f sin(theta/2) (2.7, 'equisolid') or
    2 f tan(theta/2) (2.8, 'stereographic'). Points behind the camera are seen as far
    as `max_angle`. The one direction straight back has no azimuth and no pixel.

    Parameters
    ----------
    projection : str
        'equidistance', 'equisolid' or 'stereographic'.
    focal_px : float
        Focal length f, px.
    principal_point : array_like, shape (2,)
        Principal point, px.
    width, height : int
        Size of the image, px.
    max_angle : float
        Largest theta, rad, at most pi.

    Raises
    ------
    InputError
        The projection is unknown, or values are out of range.

    References
    ----------
    Thesis (2.5) to (2.8).

    Examples
    --------
    >>> from raxel.cameras import FisheyeCamera
    >>> camera = FisheyeCamera("equisolid", 300, [319.5, 239.5], 640, 480)
    >>> camera.project([[0, 0, 1], [1, 0, 1]]).pixels.round(3)
    array([[319.5 , 239.5 ],
           [549.11, 239.5 ]])
    """

    kind = "fisheye"
    central = True

    def __init__(
        self,
        projection: str,
        focal_px: float,
        principal_point: ArrayLike,
        width: int,
        height: int,
        max_angle: float = math.pi,
    ) -> None:
        check_size(self, width, height)
        self.projection = checked_word("projection", projection, PROJECTIONS)
        self.focal_px = float(checked_positive("focal_px", focal_px))
        self.principal_point = checked_array("principal_point", principal_point, (2,))
        self.max_angle = float(checked_array("max_angle", max_angle, ()))
        if not 0 < self.max_angle <= math.pi:
            raise InputError(
                f"field 'max_angle': found {max_angle}; give radians in (0, pi]"
            )

    @property
    def parameters(self) -> int:
        """Focal length and principal point; `max_angle` is not counted."""
        return 3

    def project(self, points: ArrayLike) -> Projection:
        """Return the pixels of points.

        Parameters
        ----------
        points : array_like, shape (N, 3)
            Points in the camera frame, mm.

        Returns
        -------
        Projection
            Pixels of points, also of points behind the camera.
        """
        points = as_rows(points, 3)
        x, y, z = points.T
        across = np.hypot(x, y)
        angle = np.arctan2(across, z)
        valid = np.isfinite(points).all(axis=1) & ((across > 0) | (z > 0))
        valid &= angle <= self.max_angle + ANGLE_TOL_RAD
        pixels = np.full((len(x), 2), np.nan)
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            scale = self._radius_over_distance(across[valid], z[valid])
            offset = scale[:, None] * np.column_stack([x, y])[valid]
        pixels[valid] = self.focal_px * offset + self.principal_point
        valid &= np.isfinite(pixels).all(axis=1)
        return Projection(np.where(valid[:, None], pixels, np.nan), valid)

    def _rays(self, pixels: ArrayLike) -> Rays:
        """Rays through the origin."""
        pixels = as_rows(pixels, 2)
        with np.errstate(over="ignore", invalid="ignore"):
            offset = (pixels - self.principal_point) / self.focal_px
            across, z, angle = self._direction(np.hypot(*offset.T))
            d = np.column_stack([offset * across[:, None], z])
        valid = (angle <= self.max_angle + ANGLE_TOL_RAD) & np.isfinite(d).all(axis=1)
        d = np.where(valid[:, None], d, np.nan)
        return Rays(0.0 * d, d, valid)

    def _radius_over_distance(self, across, z):
        """r(theta) / (f * distance from the axis), exact on the axis.

        Half-angle forms for both signs of z keep full precision up to pi.
        """
        length = np.hypot(across, z)
        if self.projection == "equidistance":
            axis = across == 0
            angle = np.where(axis, 1.0, np.arctan2(across, z))
            return angle / np.where(axis, z, across)
        ahead = z >= 0
        near = np.where(ahead, length + z, length - z)
        away = np.where(ahead, 1.0, across)
        if self.projection == "equisolid":
            return np.where(
                ahead,
                2 / np.sqrt(2 * length * near),
                2 * np.sqrt(near / (2 * length)) / away,
            )
        return np.where(ahead, 2 / near, 2 * near / away**2)

    def _direction(self, radius):
        """Unit direction (across / radius, z) and angle at r / f; NaN outside."""
        if self.projection == "equidistance":
            angle = np.where(radius <= math.pi + ANGLE_TOL_RAD, radius, np.nan)
            return np.sinc(angle / math.pi), np.cos(angle), angle
        half = radius / 2
        if self.projection == "equisolid":
            half = np.where(half <= 1, half, np.nan)
            cosine = np.sqrt((1 - half) * (1 + half))
            return cosine, 1 - 2 * half**2, 2 * np.arcsin(half)
        square = 1 + half**2
        return 1 / square, (1 - half) * (1 + half) / square, 2 * np.arctan(half)

    def _fields(self):
        return {
            "projection": np.array(self.projection),
            "focal_px": np.array(self.focal_px),
            "principal_point": self.principal_point,
            "max_angle": np.array(self.max_angle),
        }

    @classmethod
    def _from_file(cls, file):
        return cls(
            file.text("projection"),
            file.number("focal_px"),
            file.numbers("principal_point"),
            file.number("width"),
            file.number("height"),
            file.number("max_angle"),
        )


# Kannala and Brandt's fisheye model (2.9), symmetric and complete.


class AsymmetricMap(PlaneMap):
    """theta (cos phi, sin phi) to (r + D_r) u_r + D_t u_phi (2.9).

    The polynomials have one power of theta less than those of the model: the common
    factor theta is the length of the argument.
    """

    def __init__(self, k, radial_l, radial_i, tangential_m, tangential_j, radius):
        self._k, self._l, self._m = k[::-1], radial_l[::-1], tangential_m[::-1]
        self._i, self._j = radial_i, tangential_j
        super().__init__(radius)

    def value(self, p):
        out, around, unit, normal = self._polar(p)
        theta = np.hypot(*p.T)[:, None]
        return theta * (out[0][:, None] * unit + around[0][:, None] * normal)

    def jacobian(self, p):
        (R, R_theta, R_phi), (T, T_theta, T_phi), unit, normal = self._polar(p)
        along = R_theta[:, None] * unit + T_theta[:, None] * normal
        across = (R_phi - T)[:, None] * unit + (R + T_phi)[:, None] * normal
        return along[:, :, None] * unit[:, None] + across[:, :, None] * normal[:, None]

    def _polar(self, p):
        """(value / theta, d/dtheta, d/dphi / theta) along u_r and u_phi; the two."""
        squared, phi = np.sum(p * p, axis=1), np.arctan2(p[:, 1], p[:, 0])
        unit = np.column_stack([np.cos(phi), np.sin(phi)])
        normal = np.column_stack([-np.sin(phi), np.cos(phi)])
        wave, slope = harmonics(self._i, phi)
        swing, swing_slope = harmonics(self._j, phi)
        (k, k_theta), (size, size_theta), (turn, turn_theta) = (
            odd_polynomial(terms, squared) for terms in (self._k, self._l, self._m)
        )
        out = (k + size * wave, k_theta + size_theta * wave, size * slope)
        around = (turn * swing, turn_theta * swing, turn * swing_slope)
        return out, around, unit, normal


def odd_polynomial(descending, squared):
    """P(theta) / theta and P'(theta) of c1 theta + c2 theta^3 + ..."""
    odd = 2 * np.arange(len(descending))[::-1] + 1
    return np.polyval(descending, squared), np.polyval(odd * descending, squared)


def harmonics(c, phi):
    """c1 cos phi + c2 sin phi + c3 cos 2 phi + c4 sin 2 phi, and its derivative."""
    cosine, sine = np.cos(phi), np.sin(phi)
    cosine_2, sine_2 = np.cos(2 * phi), np.sin(2 * phi)
    value = c[0] * cosine + c[1] * sine + c[2] * cosine_2 + c[3] * sine_2
    slope = c[1] * cosine - c[0] * sine + 2 * (c[3] * cosine_2 - c[2] * sine_2)
    return value, slope


class KannalaBrandtCamera(AzimuthalCamera):
    """r = k1 theta + k2 theta^3 + ... + k5 theta^9, with optional asymmetric terms.

    With mu, mv = fx, fy and k1 = 1 the symmetric model is OpenCV's fisheye model. The
    asymmetric terms of (2.9) are

        D_r = (l1 theta + l2 theta^3 + l3 theta^5)
              (i1 cos phi + i2 sin phi + i3 cos 2 phi + i4 sin 2 phi)

    along the radius and D_t, the same with m and j, across it. Each pair, radial_l and
    radial_i, tangential_m and tangential_j, is given together or omitted. In their
    place `tangential` and `prism` may add a decentring that the model does not have. It
    acts on r / k1 as `BrownMap` defines it, with (x, y) = theta (cos phi, sin phi).

    The camera sees as far as r rises, at most to pi; with terms that are not symmetric,
    inside the first circle on which the map folds. It has 6 (k1, k2) to 23 parameters,
    counted as the authors do; tangential and prism are two each. Three of the 23 are
    scales that cancel: between k and mu, mv, between l and i, between m and j.

    Parameters
    ----------
    k : array_like, shape (n,)
        2 to 5 coefficients.
    pixels_per_unit : array_like, shape (2,)
        (mu, mv), px per unit of r.
    principal_point : array_like, shape (2,)
        Principal point, px.
    width, height : int
        Size of the image, px.
    radial_l, tangential_m : array_like, shape (3,)
        Asymmetric polynomials in theta.
    radial_i, tangential_j : array_like, shape (4,)
        Asymmetric harmonics of phi.
    max_angle : float, optional
        Largest angle to the axis, rad; the law's own limit if omitted.
    tangential : array_like, shape (2,)
        Decentring (p1, p2).
    prism : array_like, shape (2,)
        Thin prism (s1, s2).

    Raises
    ------
    InputError
        A field is not valid, also for an r that does not rise; the message names the
        field.

    References
    ----------
    Kannala and Brandt 2006, doi:10.1109/TPAMI.2006.153. Thesis (2.9).
    """

    kind = "kannala-brandt"

    def __init__(
        self,
        k: ArrayLike,
        pixels_per_unit: ArrayLike,
        principal_point: ArrayLike,
        width: int,
        height: int,
        radial_l: ArrayLike = (),
        radial_i: ArrayLike = (),
        tangential_m: ArrayLike = (),
        tangential_j: ArrayLike = (),
        max_angle: float | None = None,
        tangential: ArrayLike = (0, 0),
        prism: ArrayLike = (0, 0),
    ) -> None:
        check_size(self, width, height)
        self.k = checked_array("k", k, (None,))
        if not 2 <= len(self.k) <= 5:
            raise InputError(
                f"field 'k': found {len(self.k)} coefficients; give k1, k2 and at most "
                "three more"
            )
        if not self.k[0] > 0:
            raise InputError(
                f"field 'k': found k1 = {self.k[0]}; give a positive k1 (r must rise "
                "from the axis)"
            )
        self.pixels_per_unit = checked_positive(
            "pixels_per_unit", pixels_per_unit, (2,)
        )
        self.principal_point = checked_array("principal_point", principal_point, (2,))
        self.radial_l, self.radial_i = _pair("radial", "l", "i", radial_l, radial_i)
        self.tangential_m, self.tangential_j = _pair(
            "tangential", "m", "j", tangential_m, tangential_j
        )
        self.tangential = checked_array("tangential", tangential, (2,))
        self.prism = checked_array("prism", prism, (2,))
        self._off_axis = bool(np.any(self.tangential) or np.any(self.prism))
        asymmetric = len(self.radial_l) or len(self.tangential_m)
        if asymmetric and self._off_axis:
            raise InputError(
                "field 'tangential' or 'prism': found together with asymmetric terms; "
                "give one of the two"
            )
        self.symmetric = not (asymmetric or self._off_axis)
        affine = np.diag(self.pixels_per_unit) * (self.k[0] if self._off_axis else 1.0)
        limits, warp = self._own_limits()
        self._set_up(affine, self.principal_point, max_angle, *limits, warp)  # type: ignore[call-arg]

    @property
    def parameters(self) -> int:
        """Coefficients k, asymmetric terms, and four of the affine map."""
        return (
            len(self.k)
            + 7 * bool(len(self.radial_l))
            + (7 * bool(len(self.tangential_m)) + 4)
            + 2 * bool(np.any(self.tangential))
            + 2 * bool(np.any(self.prism))
        )

    def _own_limits(self):
        if self._off_axis:
            radial = self.k[1:] / self.k[0]
            off_axis = self.tangential, self.prism
            return (math.pi, math.pi), distortion_warp(radial, *off_axis)
        if not self.symmetric:
            terms = [
                _or_zeros(self.radial_l, 3),
                _or_zeros(self.radial_i, 4),
                _or_zeros(self.tangential_m, 3),
                _or_zeros(self.tangential_j, 4),
            ]
            return (math.pi, math.pi), lambda r: AsymmetricMap(self.k, *terms, r)
        rise = np.zeros(2 * len(self.k) - 1)
        rise[::2] = self.k * (2 * np.arange(len(self.k)) + 1)
        turn = min(smallest_positive_root(rise), math.pi)
        return (turn, float(turn * odd_polynomial(self.k[::-1], turn**2)[0])), None

    def _radius(self, angle):
        if not self.symmetric:
            return angle
        return angle * odd_polynomial(self.k[::-1], angle**2)[0]

    def _angle(self, radius):
        if not self.symmetric:
            return radius
        return invert_rising(
            self._radius,
            lambda angle: odd_polynomial(self.k[::-1], angle**2)[1],
            radius,
            self.max_angle,
        )


def _pair(name, first, second, amplitudes, waves):
    """Both of a pair of asymmetric terms, or neither."""
    if np.size(amplitudes) == 0 and np.size(waves) == 0:
        return np.zeros(0), np.zeros(0)
    return (
        checked_array(f"{name}_{first}", amplitudes, (3,)),
        checked_array(f"{name}_{second}", waves, (4,)),
    )


def _or_zeros(terms, length):
    return terms if len(terms) else np.zeros(length)
