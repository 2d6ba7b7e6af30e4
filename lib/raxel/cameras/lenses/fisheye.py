"""Ideal fisheye cameras: equidistance, equisolid angle, stereographic (2.5 to 2.8)."""

import math

import numpy as np

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
from raxel.errors import InputError

PROJECTIONS = ("equidistance", "equisolid", "stereographic")
# Rounding of an angle, so that a ray on the rim of the field of view stays inside.
RIM = 1e-12


class FisheyeCamera(Camera):
    """A radially symmetric camera p = r(theta) (cos phi, sin phi) (2.5).

    theta is the angle to the principal axis (+z). With f the focal length in pixels,
    r is f theta (2.6, 'equidistance'), 2 f sin(theta/2) (2.7, 'equisolid') or
    2 f tan(theta/2) (2.8, 'stereographic'). Points behind the camera are seen as far as
    `max_angle`, in radians, at most pi; the one direction straight back has no azimuth
    and no pixel. principal_point: (2,) in pixels.
    Raises InputError for an unknown projection or values out of range.
    """

    kind = "fisheye"
    central = True

    def __init__(
        self, projection, focal_px, principal_point, width, height, max_angle=math.pi
    ):
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
    def parameters(self):
        """Focal length and principal point; the rim only says where to stop."""
        return 3

    def project(self, points):
        """Pixels of points (N, 3), also of points behind the camera."""
        points = as_rows(points, 3)
        x, y, z = points.T
        across = np.hypot(x, y)
        angle = np.arctan2(across, z)
        valid = np.isfinite(points).all(axis=1) & ((across > 0) | (z > 0))
        valid &= angle <= self.max_angle + RIM
        pixels = np.full((len(x), 2), np.nan)
        with np.errstate(over="ignore", divide="ignore", invalid="ignore"):
            scale = self._radius_over_distance(across[valid], z[valid])
            offset = scale[:, None] * np.column_stack([x, y])[valid]
        pixels[valid] = self.focal_px * offset + self.principal_point
        valid &= np.isfinite(pixels).all(axis=1)
        return Projection(np.where(valid[:, None], pixels, np.nan), valid)

    def rays(self, pixels):
        """Rays through the origin of pixels (N, 2)."""
        pixels = as_rows(pixels, 2)
        with np.errstate(over="ignore", invalid="ignore"):
            offset = (pixels - self.principal_point) / self.focal_px
            across, z, angle = self._direction(np.hypot(*offset.T))
            d = np.column_stack([offset * across[:, None], z])
        valid = (angle <= self.max_angle + RIM) & np.isfinite(d).all(axis=1)
        d = np.where(valid[:, None], d, np.nan)
        return Rays(0.0 * d, d, valid)

    def _radius_over_distance(self, across, z):
        """r(theta) / (f * distance from the axis), exact on the axis.

        Half-angle forms that differ ahead and behind keep full precision up to pi.
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
            angle = np.where(radius <= math.pi + RIM, radius, np.nan)
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
