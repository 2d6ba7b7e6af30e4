"""Cameras whose rays meet lines: orthographic, pushbroom, crossed slits (2.2.4)."""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike

from raxel.cameras.core.base import (
    Camera,
    Projection,
    Rays,
    check_size,
    checked_array,
    checked_positive,
    near_rows,
)
from raxel.cameras.core.storage import NamedFields
from raxel.errors import InputError

# Orthographic camera: parallel rays, the viewing camera of a paraboloid mirror.


class OrthographicCamera(NamedFields, Camera):
    """All rays run along +z: pixel = pixels_per_mm (x, y) + principal_point.

    Origins are on the plane z = 0 of the camera frame and only points with z > 0 are
    seen: that plane is where a telecentric lens ends. The rays meet at infinity, so the
    camera is not central in the sense of 2.3.1: no finite point is its centre.

    Parameters
    ----------
    pixels_per_mm : float
        Scale, px / mm, positive.
    principal_point : array_like, shape (2,)
        Principal point, px.
    width, height : int
        Size of the image, px.

    Raises
    ------
    InputError
        A field has values that no such camera can have; the message names it.
    """

    kind = "orthographic"
    central = False
    # Scale only: the intersection of axis and image is a choice of the frame.
    parameters = 1

    def __init__(
        self,
        pixels_per_mm: ArrayLike,
        principal_point: ArrayLike,
        width: int,
        height: int,
    ) -> None:
        check_size(self, width, height)
        self.pixels_per_mm = float(checked_positive("pixels_per_mm", pixels_per_mm))
        self.principal_point = checked_array("principal_point", principal_point, (2,))

    def _rays(self, pixels: ArrayLike) -> Rays:
        """Rays along +z."""
        pixels = near_rows(pixels, 2)
        valid = np.isfinite(pixels).all(axis=1)
        origins = np.full((len(pixels), 3), np.nan)
        place = (pixels[valid] - self.principal_point) / self.pixels_per_mm
        origins[valid] = np.column_stack([place, np.zeros(len(place))])
        directions = np.where(valid[:, None], [0.0, 0.0, 1.0], np.nan)  # type: ignore[index]
        return Rays(origins, directions, valid)  # type: ignore[arg-type]

    def project(self, points: ArrayLike) -> Projection:
        """Return the pixels of points.

        Parameters
        ----------
        points : array_like, shape (N, 3)
            Points in the camera frame, mm.

        Returns
        -------
        Projection
            Pixels of points with z > 0.
        """
        points = near_rows(points, 3)
        valid = np.isfinite(points).all(axis=1) & (points[:, 2] > 0)
        pixels = self.pixels_per_mm * points[:, :2] + self.principal_point
        return Projection(np.where(valid[:, None], pixels, np.nan), valid)


# Linear pushbroom camera: a line sensor that moves along a straight path (2.2.4).


class PushbroomCamera(NamedFields, Camera):
    """Row v of the image is seen at once, from a centre that moves from row to row.

    The centre of row v is velocity (v - reference_row). A row sees the plane y = 0 of
    its centre: pixel u looks along ((u - principal_column) / focal_px, 0, 1). Rows are
    perspective, columns parallel. So the camera is the crossed-slits camera whose one
    slit is the path and whose other is the line at infinity of the planes y = 0.

    Parameters
    ----------
    focal_px : float
        Focal length, px.
    principal_column : float
        Principal column, px.
    velocity : array_like, shape (3,)
        mm per row, in the camera frame, whose axes do not rotate.
    width, height : int
        Size of the image, px.
    reference_row : float
        Row whose centre is the origin, px.

    Raises
    ------
    InputError
        The focal length is not positive, or the path is inside y = 0, where rows would
        see the same plane.

    References
    ----------
    Gupta, Hartley 1997, Linear pushbroom cameras, IEEE Transactions on Pattern Analysis
    and Machine Intelligence 19(9).
    """

    kind = "pushbroom"
    central = False
    # Focal length, principal column, velocity; the reference row is the frame's.
    parameters = 5

    def __init__(
        self,
        focal_px: float,
        principal_column: float,
        velocity: ArrayLike,
        width: int,
        height: int,
        reference_row: float = 0.0,
    ) -> None:
        check_size(self, width, height)
        self.focal_px = float(checked_positive("focal_px", focal_px))
        self.principal_column = float(
            checked_array("principal_column", principal_column, ())
        )
        self.velocity = checked_array("velocity", velocity, (3,))
        self.reference_row = float(checked_array("reference_row", reference_row, ()))
        if abs(self.velocity[1]) <= 1e-9 * np.linalg.norm(self.velocity):
            raise InputError(
                f"field 'velocity': found {self.velocity.tolist()}; give a nonzero y "
                "(otherwise all rows see one plane)"
            )

    def _rays(self, pixels: ArrayLike) -> Rays:
        """Rays from the centres of their rows."""
        u, v = near_rows(pixels, 2).T
        x = (u - self.principal_column) / self.focal_px
        d = np.column_stack([x, 0 * x, 1 + 0 * x]) / np.hypot(x, 1)[:, None]
        origins = (v - self.reference_row)[:, None] * self.velocity
        valid = np.isfinite(d).all(axis=1) & np.isfinite(origins).all(axis=1)
        keep = valid[:, None]
        return Rays(np.where(keep, origins, np.nan), np.where(keep, d, np.nan), valid)

    def project(self, points: ArrayLike) -> Projection:
        """Return the pixels of points.

        Parameters
        ----------
        points : array_like, shape (N, 3)
            Points in the camera frame, mm.

        Returns
        -------
        Projection
            Pixels of points: the row whose plane holds the point, then 2.2.
        """
        points = near_rows(points, 3)
        rows = points[:, 1] / self.velocity[1]
        x = points[:, 0] - rows * self.velocity[0]
        z = points[:, 2] - rows * self.velocity[2]
        valid = np.isfinite(points).all(axis=1) & (z > 0)
        with np.errstate(over="ignore"):
            u = self.focal_px * x / np.where(valid, z, np.nan) + self.principal_column
        pixels = np.column_stack([u, rows + self.reference_row])
        valid &= np.isfinite(u)
        return Projection(np.where(valid[:, None], pixels, np.nan), valid)


# Sine of an angle, and fraction of a length, below which lines or planes coincide.
COINCIDENCE_TOL = 1e-9


class XSlitsCamera(NamedFields, Camera):
    """Rays through the image plane and two slits, lines that do not meet.

    The image plane is z = image_distance, and a point (x, y) of it is the pixel
    pixels_per_mm (x, y) + principal_point. A ray is where the plane of a pixel and the
    first slit meets the plane of that pixel and the second. It runs towards +z and
    begins at the slit farther ahead, so points behind that slit are not seen. Two slits
    that meet would be a pinhole.

    Parameters
    ----------
    slit_points : array_like, shape (2, 3)
        A point on each slit, mm, camera frame.
    slit_directions : array_like, shape (2, 3)
        Direction of each slit, of any length.
    image_distance : float
        z of the image plane, mm, any sign.
    pixels_per_mm : array_like, shape (2,)
        Scales, px / mm.
    principal_point : array_like, shape (2,)
        Principal point, px.
    width, height : int
        Size of the image, px.

    Raises
    ------
    InputError
        The slits meet, are parallel or are in the image plane, or values are out of
        range.

    References
    ----------
    Zomet, Feldman, Peleg, Weinshall 2003, doi:10.1109/TPAMI.2003.1201823.
    """

    kind = "x-slits"
    central = False
    # Two lines (4 each) and two scales, in the frame of the image plane.
    parameters = 10

    def __init__(
        self,
        slit_points: ArrayLike,
        slit_directions: ArrayLike,
        image_distance: float,
        pixels_per_mm: ArrayLike,
        principal_point: ArrayLike,
        width: int,
        height: int,
    ) -> None:
        check_size(self, width, height)
        self.slit_points = checked_array("slit_points", slit_points, (2, 3))
        self.slit_directions = checked_array("slit_directions", slit_directions, (2, 3))
        self.image_distance = float(checked_array("image_distance", image_distance, ()))
        self.pixels_per_mm = checked_positive("pixels_per_mm", pixels_per_mm, (2,))
        self.principal_point = checked_array("principal_point", principal_point, (2,))
        self._slits = self._unit_slits()

    def _unit_slits(self):
        """Unit directions of the slits, which must be skew and outside the image."""
        length = np.linalg.norm(self.slit_directions, axis=1)
        if not (length > 0).all():
            raise InputError("field 'slit_directions': a direction is zero; change it")
        slits = self.slit_directions / length[:, None]
        separation = self.slit_points[1] - self.slit_points[0]
        across = np.cross(slits[0], slits[1])
        if np.linalg.norm(across) < COINCIDENCE_TOL:
            raise InputError(
                "field 'slit_directions': the slits are parallel (no ray meets both); "
                "rotate one of them"
            )
        if abs(separation @ across) <= COINCIDENCE_TOL * np.linalg.norm(separation):
            raise InputError(
                "field 'slit_points': the slits meet (a pinhole); move them apart, or "
                "use a camera of kind 'perspective'"
            )
        height = self.slit_points[:, 2] - self.image_distance
        if np.any(
            (np.abs(height) < COINCIDENCE_TOL) & (np.abs(slits[:, 2]) < COINCIDENCE_TOL)
        ):
            raise InputError(
                "field 'image_distance': the image plane contains a slit; move the "
                "plane"
            )
        return slits

    def _rays(self, pixels: ArrayLike) -> Rays:
        """Rays; origins on the slit farther ahead."""
        place = (near_rows(pixels, 2) - self.principal_point) / self.pixels_per_mm
        points = np.column_stack([place, np.full(len(place), self.image_distance)])
        directions, along, valid = self._lines(points)
        with np.errstate(invalid="ignore"):
            origins = points + along.max(axis=1)[:, None] * directions
        valid &= np.isfinite(origins).all(axis=1)
        keep = valid[:, None]
        return Rays(
            np.where(keep, origins, np.nan), np.where(keep, directions, np.nan), valid
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
            Pixels of points ahead of both slits.
        """
        points = near_rows(points, 3)
        directions, along, valid = self._lines(points)
        with np.errstate(invalid="ignore"):
            valid &= along.max(axis=1) < 0
            to_plane = (self.image_distance - points[:, 2]) / directions[:, 2]
            meet = points[:, :2] + to_plane[:, None] * directions[:, :2]
            pixels = self.pixels_per_mm * meet + self.principal_point
        valid &= np.isfinite(pixels).all(axis=1)
        return Projection(np.where(valid[:, None], pixels, np.nan), valid)

    def _lines(self, points):
        """The line through each point (N, 3) and both slits.

        Returns unit directions towards +z, signed distances (N, 2) along them to the
        slits, and which lines exist and are not parallel to the image plane.
        """
        reach = points[:, None] - self.slit_points
        normals = np.cross(reach, self._slits)
        with np.errstate(divide="ignore", invalid="ignore"):
            normals = normals / np.linalg.norm(reach, axis=2, keepdims=True)
            d = np.cross(normals[:, 0], normals[:, 1])
            d = d / np.linalg.norm(d, axis=1, keepdims=True)
            d = np.where(d[:, 2:] < 0, -d, d)
            sine = np.cross(d[:, None], self._slits)
            square = np.sum(sine**2, axis=2)
            along = -np.sum(np.cross(reach, self._slits) * sine, axis=2) / square
            valid = (np.abs(d[:, 2]) > COINCIDENCE_TOL) & (
                square > COINCIDENCE_TOL**2
            ).all(axis=1)
        return np.where(valid[:, None], d, np.nan), along, valid
