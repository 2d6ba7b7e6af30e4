"""Lens with an entrance-pupil shift along its axis that depends on the angle."""

from __future__ import annotations

import math

import numba
import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.cameras.core.base import (
    Camera,
    Projection,
    Rays,
    checked_array,
    near_rows,
    nested_fields,
)
from raxel.cameras.core.storage import NamedFields
from raxel.cameras.lenses.azimuthal import AzimuthalCamera
from raxel.cameras.lenses.fisheye import ANGLE_TOL_RAD, FisheyeCamera
from raxel.errors import InputError

# Axial camera: a fisheye with an entrance-pupil shift along the axis (2.2.4).


MAX_N_AXIAL_STEPS = 100
# Half the field of view of common fisheye lenses, a little more than 90 degrees.
DEFAULT_MAX_ANGLE_RAD = math.radians(95)


class AxialCamera(NamedFields, Camera):
    """A fisheye lens (2.5 to 2.8) whose rays cross its axis at different heights.

    The ray at angle theta to the axis (+z) starts at (0, 0, z0(theta)) with

        z0 = (theta / sin(theta) - 1) (e0 + e1 theta^2 + ...).

    Near the axis z0 grows with theta^2: the entrance pupil of a real fisheye moves so.
    Rays of neighbouring theta meet z0'(theta) sin(theta) along the ray from the axis. A
    point beyond that on its ray has the pixel of this ray. One before it has that of
    another ray, if there is one on which the point is beyond.

    Parameters
    ----------
    projection : str
        As in `FisheyeCamera`.
    focal_px : float
        Focal length, px.
    principal_point : array_like, shape (2,)
        Principal point, px.
    pupil_shift : array_like, shape (n,)
        (e0, e1, ...), mm, n >= 0.
    width, height : int
        Size of the image, px.
    max_angle : float
        Largest theta, rad, below pi, where z0 has no limit.

    Raises
    ------
    InputError
        A field has values that no such camera can have; the message names it.

    References
    ----------
    Axial cameras: Sturm 2005, doi:10.1109/CVPR.2005.237; the moving pupil: Gennery
    2006, doi:10.1007/s11263-006-5168-1.
    """

    kind = "axial"

    def __init__(
        self,
        projection: str,
        focal_px: float,
        principal_point: ArrayLike,
        pupil_shift: ArrayLike,
        width: int,
        height: int,
        max_angle: float = DEFAULT_MAX_ANGLE_RAD,
    ) -> None:
        self._lens = FisheyeCamera(
            projection, focal_px, principal_point, width, height, max_angle
        )
        self.width, self.height = self._lens.width, self._lens.height
        self.projection, self.focal_px = projection, self._lens.focal_px
        self.principal_point = self._lens.principal_point
        self.pupil_shift = checked_array("pupil_shift", pupil_shift, (None,))
        self.max_angle = self._lens.max_angle
        if not self.max_angle < math.pi - 1e-6:
            raise InputError(
                f"field 'max_angle': found {max_angle}; give radians below pi (there "
                "the pupil is at infinity)"
            )

    @property
    def central(self) -> bool:
        """Whether the pupil shift is zero."""
        return not self.pupil_shift.any()

    @property
    def parameters(self) -> int:
        """Focal length, principal point and the terms of the shift."""
        return 3 + len(self.pupil_shift)

    def pupil(
        self, angle: NDArray[np.float64]
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return the pupil's height z0 `(N,)` and dz0/dtheta at angles `(N,)`, rad."""
        sinc = np.sinc(angle / math.pi)
        growth = 1 / sinc - 1
        # d(theta / sin theta): a series replaces the difference near cancellation.
        small = np.abs(angle) < 1e-3
        sine = np.where(small, 1.0, np.sin(angle))
        slope = np.where(
            small,
            angle / 3 + 7 * angle**3 / 90,
            (sine - angle * np.cos(angle)) / sine**2,
        )
        shift = self.pupil_shift[::-1] if len(self.pupil_shift) else np.zeros(1)
        value = np.polyval(shift, angle**2)
        rise = 2 * angle * np.polyval(np.polyder(shift), angle**2)
        return growth * value, slope * value + growth * rise

    def _rays(self, pixels: ArrayLike) -> Rays:
        """Rays; origins on the axis."""
        rays = self._lens.rays(pixels)
        z0, _ = self.pupil(_angle(rays.directions))
        origins = rays.origins + np.column_stack([0 * z0, 0 * z0, z0])
        return Rays(origins, rays.directions, rays.valid)

    def project(self, points: ArrayLike) -> Projection:
        """Return the pixels of points.

        Parameters
        ----------
        points : array_like, shape (N, 3)
            Points in the camera frame, mm.

        Returns
        -------
        Projection
            Pixels of points: of the ray on which each lies beyond the caustic.
        """
        points = near_rows(points, 3)
        angle = self._angles(np.hypot(points[:, 0], points[:, 1]), points[:, 2])
        z0, slope = self.pupil(angle)
        from_pupil = points - np.column_stack([0 * z0, 0 * z0, z0])
        with np.errstate(invalid="ignore"):
            distance = np.linalg.norm(from_pupil, axis=1)
            clear = distance > slope * np.sin(angle)
        return self._lens.project(np.where(clear[:, None], from_pupil, np.nan))

    def _angles(self, across, z):
        """theta of the ray through (across, z); NaN without one.

        (z - z0) sin(theta) - across cos(theta) rises through zero there: Newton
        inside a bracket that bisection maintains.
        """
        low = np.zeros_like(across)
        high = np.full_like(across, self.max_angle + ANGLE_TOL_RAD)
        start = np.arctan2(across, z)
        angle, done = np.clip(start, low, high), ~np.isfinite(start)
        with np.errstate(all="ignore"):
            for _ in range(MAX_N_AXIAL_STEPS):
                z0, slope = self.pupil(angle)
                sine, cosine = np.sin(angle), np.cos(angle)
                miss = (z - z0) * sine - across * cosine
                rise = (z - z0) * cosine + across * sine - slope * sine
                low = np.where(miss < 0, angle, low)
                high = np.where(miss > 0, angle, high)
                new = angle - miss / rise
                settled = np.abs(new - angle) <= 2e-16 * np.maximum(angle, 1e-3)
                new = np.where((new >= low) & (new <= high), new, (low + high) / 2)
                angle = np.where(done, angle, new)
                done |= settled | (miss == 0) | (high - low <= 4e-16)
                if done.all():
                    break
            z0, _ = self.pupil(angle)
            miss = (z - z0) * np.sin(angle) - across * np.cos(angle)
            meets = np.abs(miss) <= 1e-12 * (np.hypot(across, z) + np.abs(z0))
        return np.where(meets, angle, np.nan)


MAX_N_STEPS = 60
STEP_TOL_RAD = 1e-15


class MovingPupilCamera(NamedFields, Camera):
    """A central lens of any radial law whose rays cross its axis at z0(theta).

    The lens gives each pixel its direction. The ray at the angle theta to the axis (+z)
    starts at (0, 0, z0), z0 = a1 theta^2 + a2 theta^4 + ... A ray and its neighbour of
    the same azimuth meet z0'(theta) sin(theta) along it. A point beyond that on its ray
    has the ray's pixel; one before it may have another ray's. The parameters are the
    lens's and n.

    Parameters
    ----------
    lens : AzimuthalCamera
        Lens (Kannala-Brandt, unified sphere, fisheye, ...).
    pupil_shift : array_like, shape (n,)
        (a1, a2, ...), mm (or the unit of the chessboard), n >= 0.

    Raises
    ------
    InputError
        A field has values that no such camera can have; the message names it.

    References
    ----------
    Axial cameras: Sturm 2005, doi:10.1109/CVPR.2005.237; the moving pupil: Gennery
    2006, doi:10.1007/s11263-006-5168-1.
    """

    kind = "moving pupil"

    def __init__(self, lens: Camera, pupil_shift: ArrayLike) -> None:
        if not isinstance(lens, AzimuthalCamera) or lens._look < 0:
            found = getattr(lens, "kind", type(lens).__name__)
            raise InputError(
                f"field 'lens': found {found}; give a central lens with a radial law "
                "about +z, such as a kannala-brandt or a unified sphere camera"
            )
        self.lens, self.width, self.height = lens, lens.width, lens.height
        self.pupil_shift = checked_array("pupil_shift", pupil_shift, (None,))

    @property
    def central(self) -> bool:
        """Whether the pupil shift is zero."""
        return not self.pupil_shift.any()

    @property
    def parameters(self) -> int:
        """Those of the lens and of the shift."""
        return self.lens.parameters + len(self.pupil_shift)

    @property
    def max_angle(self) -> float:
        """Largest angle of the lens, rad."""
        return self.lens.max_angle

    def _rays(self, pixels: ArrayLike) -> Rays:
        """Rays; origins on the axis."""
        rays = self.lens.rays(pixels)
        z0, _ = pupil_heights(_angle(rays.directions), self.pupil_shift)
        return Rays(
            rays.origins + z0[:, None] * [0.0, 0.0, 1.0], rays.directions, rays.valid
        )

    def project(self, points: ArrayLike) -> Projection:
        """Return the pixels of points.

        Parameters
        ----------
        points : array_like, shape (N, 3)
            Points in the camera frame, mm.

        Returns
        -------
        Projection
            Pixels of points: of the ray on which each lies beyond the caustic.
        """
        points = near_rows(points, 3)
        with np.errstate(invalid="ignore"):
            rho, z = np.hypot(points[:, 0], points[:, 1]), points[:, 2]
            angle = sight_angles(rho, z, self.pupil_shift)
            z0, slope = pupil_heights(angle, self.pupil_shift)
            height = z - z0
            meets = np.abs(height * np.sin(angle) - rho * np.cos(angle)) <= 1e-10 * (
                np.hypot(rho, z) + np.abs(z0)
            )
            along = height * np.cos(angle) + rho * np.sin(angle)
            clear = meets & (along > slope * np.sin(angle)) & (along > 0)
        from_pupil = points - np.where(clear, z0, 0.0)[:, None] * [0.0, 0.0, 1.0]
        return self.lens.project(np.where(clear[:, None], from_pupil, np.nan))

    def _fields(self):
        return nested_fields("lens", self.lens) | {"pupil_shift": self.pupil_shift}

    @classmethod
    def _from_file(cls, file):
        return cls(file.nested("lens"), file.numbers("pupil_shift"))


@numba.njit(cache=True, error_model="numpy")
def pupil_heights(angle, shift):
    """z0 and dz0/dtheta, of the shape of the angles, for coefficients (a1, a2, ...)."""
    squared = angle**2
    value, slope = 0.0 * squared, 0.0 * squared
    for a in shift[::-1]:
        slope = slope * squared + value
        value = value * squared + a
    return value * squared, 2 * angle * (slope * squared + value)


@numba.njit(cache=True, error_model="numpy")
def sight_angle(rho, z, shift):
    """theta, 0 to pi, at which a point rho from the axis at height z is seen.

    Solves (z - z0(theta)) sin theta = rho cos theta by Newton steps from the angle at a
    fixed pupil. Without convergence, the last angle is returned.
    """
    angle = math.atan2(rho, z)
    for _ in range(MAX_N_STEPS if np.any(shift != 0) else 0):
        z0, slope = pupil_heights(angle, shift)
        sine, cosine = math.sin(angle), math.cos(angle)
        miss = (z - z0) * sine - rho * cosine
        rise = (z - z0) * cosine + rho * sine - slope * sine
        before = angle
        angle -= miss / (rise if rise > 0 else math.hypot(rho, z))
        angle = 0.0 if angle < 0 else math.pi if angle > math.pi else angle
        if not abs(angle - before) > STEP_TOL_RAD + 4e-16 * angle:
            break
    return angle


@numba.njit(cache=True, error_model="numpy")
def sight_angles(rho, z, shift):
    """theta (N,) of points by `sight_angle`."""
    return np.array([sight_angle(rho[n], z[n], shift) for n in range(len(z))])


def _angle(directions):
    """Angle to +z of unit directions (N, 3)."""
    x, y, z = directions.T
    return np.arctan2(np.hypot(x, y), z)
