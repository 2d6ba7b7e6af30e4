"""Radial laws with one or two parameters: the FOV model and two fisheye models."""

import math

import numpy as np

from raxel.cameras.core.base import (
    check_size,
    checked_array,
    checked_calibration_matrix,
    checked_positive,
    checked_word,
)
from raxel.cameras.lenses.azimuthal import AzimuthalCamera
from raxel.cameras.lenses.brown import distortion_warp
from raxel.errors import InputError

LAWS = ("rational", "sine")


class FieldOfViewCamera(AzimuthalCamera):
    """The FOV model: r = arctan(2 tan(theta) tan(omega / 2)) / omega.

    omega: the model's field of view, radians in (0, pi); at 2 tan(omega / 2) = 1 the
    law is that of equidistance. K: (3, 3) of the form (2.1). radial: coefficients of
    (2.4) applied to the point that the law gives, for lenses that omega alone does
    not describe. As published the law displaces points of the image plane, so it sees
    less than 90 degrees off the axis; r ends at pi / (2 omega).
    6 + n parameters. Source: Devernay and Faugeras 2001, doi:10.1007/PL00013269.
    Raises InputError naming the field.
    """

    kind = "field of view"

    def __init__(self, omega, K, width, height, radial=(), max_angle=None):
        check_size(self, width, height)
        self.omega = float(checked_array("omega", omega, ()))
        if not 0 < self.omega < math.pi:
            raise InputError(
                f"field 'omega': found {omega}; give radians in (0, pi), open ends"
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
    def parameters(self):
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

    law 'rational': theta = a r / (1 + b r^2), found for the Nikon FC-E8; a in radians
    per pixel, b in 1 / pixel^2. law 'sine': r = (a / b) sin(b theta), found for a Sigma
    8 mm lens; a in pixels per radian, b a pure number. With b = 0 both are
    equidistance, with f = 1 / a and f = a. principal_point: (2,) pixels.

    The rational law turns at r = 1 / sqrt(b), theta = a / (2 sqrt(b)), the sine law at
    theta = pi / (2 b). 4 parameters. Source: Micusik and Pajdla 2006, Structure from
    motion with wide circular field of view cameras, IEEE Transactions on Pattern
    Analysis and Machine Intelligence 28(7). Raises InputError naming the field.
    """

    kind = "micusik-pajdla"

    def __init__(self, law, a, b, principal_point, width, height, max_angle=None):
        check_size(self, width, height)
        self.law = checked_word("law", law, LAWS)
        self.a = float(checked_positive("a", a))
        self.b = float(checked_array("b", b, ()))
        self.principal_point = checked_array("principal_point", principal_point, (2,))
        self._set_up(np.eye(2), self.principal_point, max_angle, *self._own_limits())

    @property
    def parameters(self):
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
