"""The unified sphere model of central catadioptric cameras, with distortion."""

import math

import numpy as np

from raxel.cameras.core.base import (
    check_size,
    checked_array,
    checked_calibration_matrix,
)
from raxel.cameras.lenses.azimuthal import AzimuthalCamera
from raxel.cameras.lenses.brown import distortion_warp
from raxel.errors import InputError


class UnifiedSphereCamera(AzimuthalCamera):
    """Onto the unit sphere, then from a point xi behind its centre onto a plane.

    With X on the sphere, p = (x, y) / (z + xi), so r = sin theta / (cos theta + xi).
    xi = 0 is a pinhole, xi = 1 a paraboloid, 0 < xi < 1 a hyperboloid or ellipsoid;
    xi > 1 fits some fisheye lenses. K: (3, 3) of the form (2.1) after the distortion.
    radial: up to any order (2.4) and tangential: (p1, p2) act on p as Mei and Rives do;
    theirs has three radial terms. prism: (s1, s2) adds (s1 r^2, s2 r^2) to it.

    For xi <= 1 the field of view ends at cos theta = -xi, where r is infinite; for
    xi > 1 at cos theta = -1 / xi, where r = 1 / sqrt(xi^2 - 1) turns. 6 parameters,
    with distortion 6 + n + 2, and 2 of a prism. The centre of the image sees +z.

    Sources: Geyer and Daniilidis 2000, doi:10.1007/3-540-45053-X_29; Mei and Rives
    2007, doi:10.1109/ROBOT.2007.364084. Raises InputError naming the field.
    """

    kind = "unified sphere"

    def __init__(
        self,
        xi,
        K,
        width,
        height,
        radial=(),
        tangential=(0, 0),
        max_angle=None,
        prism=(0, 0),
    ):
        check_size(self, width, height)
        self.xi = float(checked_array("xi", xi, ()))
        if self.xi < 0:
            raise InputError(
                f"field 'xi': found {xi}; the centre of projection lies at xi >= 0"
            )
        self.K = checked_calibration_matrix(K)
        self.radial = checked_array("radial", radial, (None,))
        self.tangential = checked_array("tangential", tangential, (2,))
        self.prism = checked_array("prism", prism, (2,))
        if self.xi <= 1:
            limits = math.acos(-self.xi), math.inf
        else:
            limits = math.acos(-1 / self.xi), 1 / math.sqrt(self.xi**2 - 1)
        warp = distortion_warp(self.radial, self.tangential, self.prism)
        self._set_up(self.K[:2, :2], self.K[:2, 2], max_angle, *limits, warp)

    @property
    def parameters(self):
        """xi, the five of K, and the distortion if there is any."""
        off_axis = [terms for terms in (self.tangential, self.prism) if np.any(terms)]
        return 6 + len(self.radial) + 2 * len(off_axis)

    def _radius(self, angle):
        return np.sin(angle) / (np.cos(angle) + self.xi)

    def _angle(self, radius):
        xi, squared = self.xi, radius**2
        root = np.sqrt(np.maximum(1 + (1 - xi * xi) * squared, 0.0))
        # The ray (t p, t - xi) meets the sphere at t = (xi + root) / (1 + r^2).
        return np.arctan2(radius * (xi + root), root - xi * squared)
