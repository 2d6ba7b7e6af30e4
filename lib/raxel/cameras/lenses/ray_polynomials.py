"""Models that give the ray in closed form: (p, f(|p|)) with a polynomial f.

The depth f may pass through zero: then the ray leaves the image plane and looks back.
"""

import abc
import math

import numpy as np

from raxel.cameras.core.base import (
    check_size,
    checked_array,
    checked_calibration_matrix,
)
from raxel.cameras.lenses.azimuthal import AzimuthalCamera
from raxel.cameras.lenses.rising import invert_rising, smallest_positive_root
from raxel.errors import InputError


class RayPolynomialCamera(AzimuthalCamera):
    """theta = atan2(r, f(r)), rising up to the first positive root of f - r f'."""

    @abc.abstractmethod
    def _depths(self):
        """Ascending coefficients of f."""

    def _own_limits(self, name):
        depth = self._depths()
        if depth[0] == 0:
            raise InputError(
                f"field '{name}': the first is 0; the centre of the image needs a "
                "depth, positive to look along +z"
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
        """Where theta tends to far out, if it never turns."""
        highest = np.trim_zeros(self._poly, "f")
        if len(highest) == 1:
            return math.pi / 2
        if len(highest) == 2:
            return math.atan2(1.0, highest[0])
        # It rises for ever, so f falls faster than r.
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

    r is the radius of the distorted point in lens-centric normalised coordinates; K:
    (3, 3) of the form (2.1); coefficients: (n,), n >= 1. A displacement in the image
    plane: it ends where the denominator vanishes, at 90 degrees, or turns before.
    5 + n parameters; with n = 1 the form of Fitzgibbon 2001,
    doi:10.1109/CVPR.2001.990465. Raises InputError naming the field.
    """

    kind = "division"

    def __init__(self, K, coefficients, width, height, max_angle=None):
        check_size(self, width, height)
        self.K = checked_calibration_matrix(K)
        self.coefficients = checked_array("coefficients", coefficients, (None,))
        if len(self.coefficients) < 1:
            raise InputError(
                "field 'coefficients': none found; give l1 at least, 0 for a pinhole"
            )
        angle, radius = self._own_limits("coefficients")
        edge = smallest_positive_root(self._poly[::-1])
        if edge <= radius:
            angle, radius = math.pi / 2, edge
        self._set_up(self.K[:2, :2], self.K[:2, 2], max_angle, angle, radius)

    @property
    def parameters(self):
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

    f(r) = c0 + c1 r + c2 r^2 + ..., r in pixels from principal_point (2,), all powers;
    the ray of p is (p, f(|p|)). It passes 90 degrees where f changes sign. With c0 < 0
    the centre of the image looks along -z. n + 2 parameters for n coefficients. Source:
    Tardif, Sturm and Roy 2006, HAL inria-00387130. Raises InputError naming the field.
    """

    kind = "tardif"

    def __init__(self, coefficients, principal_point, width, height, max_angle=None):
        check_size(self, width, height)
        self.coefficients = checked_array("coefficients", coefficients, (None,))
        if len(self.coefficients) < 1:
            raise InputError("field 'coefficients': none found; give c0 at least")
        self.principal_point = checked_array("principal_point", principal_point, (2,))
        limits = self._own_limits("coefficients")
        self._set_up(np.eye(2), self.principal_point, max_angle, *limits)

    @property
    def parameters(self):
        """The coefficients and the principal point."""
        return len(self.coefficients) + 2

    def _depths(self):
        return self.coefficients


class ScaramuzzaCamera(RayPolynomialCamera):
    """Scaramuzza's polynomial (2.10): r = (p, a0 + a2 |p|^2 + a3 |p|^3 + ...).

    coefficients: (a0, a2, a3, ..., an), p in sensor coordinates; there is no a1,
    because theta would not be smooth on the axis. Pixels = [[c, d], [e, 1]] p + centre,
    affine: (c, d, e). Here p = (u, v), where the published toolbox counts rows first.
    With a0 < 0, the toolbox's sign, the centre of the image looks along -z.
    n + 5 parameters for n coefficients. Source: Scaramuzza, Martinelli and Siegwart
    2006, doi:10.1109/ICVS.2006.3. Raises InputError naming the field.
    """

    kind = "scaramuzza"

    def __init__(
        self, coefficients, centre, width, height, affine=(1, 0, 0), max_angle=None
    ):
        check_size(self, width, height)
        self.coefficients = checked_array("coefficients", coefficients, (None,))
        if len(self.coefficients) < 1:
            raise InputError("field 'coefficients': none found; give a0 at least")
        self.centre = checked_array("centre", centre, (2,))
        self.affine = checked_array("affine", affine, (3,))
        c, d, e = self.affine
        if not c - d * e > 0:
            raise InputError(
                f"field 'affine': (c, d, e) = {self.affine.tolist()} found; c - d e "
                "must be positive"
            )
        limits = self._own_limits("coefficients")
        self._set_up([[c, d], [e, 1]], self.centre, max_angle, *limits)

    @property
    def parameters(self):
        """The polynomial's coefficients, c, d, e, and the centre."""
        return len(self.coefficients) + 5

    def _depths(self):
        return np.concatenate([self.coefficients[:1], [0.0], self.coefficients[1:]])
