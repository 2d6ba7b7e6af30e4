"""Radial and decentring (tangential) distortion of the image plane."""

import math

import numpy as np

from raxel.cameras.core.base import (
    check_size,
    checked_array,
    checked_calibration_matrix,
)
from raxel.cameras.lenses.azimuthal import AzimuthalCamera, PlaneLaw
from raxel.cameras.lenses.plane_map import PlaneMap
from raxel.cameras.lenses.rising import smallest_positive_root


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
        # A dip of the slope between two rings of the scan is not overlooked so.
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
    """radius -> BrownMap on that disc, or None where there is no distortion."""
    if not (np.any(radial) or np.any(tangential) or np.any(prism)):
        return None
    return lambda radius: BrownMap(radial, tangential, radius, prism)


class BrownCamera(PlaneLaw, AzimuthalCamera):
    """Pinhole with any number of radial terms (2.4) and two of decentring.

    K: (3, 3) of the form (2.1), pixels; radial: (n,), n >= 0; tangential: (p1, p2), in
    OpenCV's signs; both for lens-centric normalised coordinates. The camera sees points
    with z > 0 inside the first circle r = tan(theta) on which the map folds.
    5 + n + 2 parameters. Sources: Brown 1971, Close-range camera
    calibration, Photogrammetric Engineering 37(8); Heikkila and Silven 1997,
    doi:10.1109/CVPR.1997.609468. Raises InputError naming the field.
    """

    kind = "brown"

    def __init__(self, K, radial, tangential, width, height, max_angle=None):
        check_size(self, width, height)
        self.K = checked_calibration_matrix(K)
        self.radial = checked_array("radial", radial, (None,))
        self.tangential = checked_array("tangential", tangential, (2,))
        warp = distortion_warp(self.radial, self.tangential)
        self._set_up(
            self.K[:2, :2], self.K[:2, 2], max_angle, math.pi / 2, math.inf, warp
        )

    @property
    def parameters(self):
        """The five of K, the radial ones, and p1, p2."""
        return 7 + len(self.radial)
