"""Polynomials of the radius for both polar coordinates of the image plane (2.2.2)."""

import math

import numpy as np

from raxel.cameras.core.base import (
    check_size,
    checked_array,
    checked_calibration_matrix,
)
from raxel.cameras.lenses.azimuthal import AzimuthalCamera, PlaneLaw
from raxel.cameras.lenses.plane_map import PlaneMap
from raxel.cameras.lenses.rising import invert_rising, smallest_positive_root
from raxel.errors import InputError

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
        # A dip of the slope between two rings of the scan is not overlooked so.
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
    radial: (a1, ..., a5), a1 > 0; tangential: (b1, ..., b5), radians; K: (3, 3) of the
    form (2.1). The camera sees points with Z > 0 inside the first circle on which the
    radius stops rising.

    The thesis says of the model that radial and tangential distortion have a
    polynomial of fifth order each, ten parameters together. It does not print the
    formula; this is a form that has both, not a copy of the paper's. 15 parameters
    with the five of K, one of them twice: the size of K and that of the a.
    Source: Shah and Aggarwal 1994, A simple calibration procedure for fish-eye (high
    distortion) lens camera, IEEE Int. Conf. on Robotics and Automation.
    Raises InputError naming the field.
    """

    kind = "shah-aggarwal"

    def __init__(self, K, radial, tangential, width, height, max_angle=None):
        check_size(self, width, height)
        self.K = checked_calibration_matrix(K)
        self.radial = checked_array("radial", radial, (ORDER,))
        self.tangential = checked_array("tangential", tangential, (ORDER,))
        if not self.radial[0] > 0:
            raise InputError(
                f"field 'radial': a1 = {self.radial[0]:g} found; the radius must rise "
                "from the axis, so give a positive a1"
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
    def parameters(self):
        """The five of K, and both polynomials."""
        return 5 + 2 * ORDER
