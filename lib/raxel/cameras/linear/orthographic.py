"""Orthographic camera: parallel rays, the viewer of a paraboloid mirror."""

import numpy as np

from raxel.cameras.core.base import (
    Camera,
    Projection,
    Rays,
    check_size,
    checked_array,
    checked_positive,
    near_rows,
)
from raxel.cameras.core.named_fields import NamedFields


class OrthographicCamera(NamedFields, Camera):
    """All rays run along +z: pixel = pixels_per_mm (x, y) + principal_point.

    pixels_per_mm: one positive number; principal_point: (2,) in pixels. Origins lie on
    the plane z = 0 of the camera frame and only points with z > 0 are seen: that plane
    is where a telecentric lens ends. The rays meet at infinity, so the camera is not
    central in the sense of 2.3.1: no finite point is its centre.
    Raises InputError for values out of range.
    """

    kind = "orthographic"
    central = False
    # Scale only: where the axes pierce the image is a choice of the frame.
    parameters = 1

    def __init__(self, pixels_per_mm, principal_point, width, height):
        check_size(self, width, height)
        self.pixels_per_mm = float(checked_positive("pixels_per_mm", pixels_per_mm))
        self.principal_point = checked_array("principal_point", principal_point, (2,))

    def rays(self, pixels):
        """Rays along +z through pixels (N, 2)."""
        pixels = near_rows(pixels, 2)
        valid = np.isfinite(pixels).all(axis=1)
        origins = np.full((len(pixels), 3), np.nan)
        place = (pixels[valid] - self.principal_point) / self.pixels_per_mm
        origins[valid] = np.column_stack([place, np.zeros(len(place))])
        directions = np.where(valid[:, None], [0.0, 0.0, 1.0], np.nan)
        return Rays(origins, directions, valid)

    def project(self, points):
        """Pixels of points (N, 3) with z > 0."""
        points = near_rows(points, 3)
        valid = np.isfinite(points).all(axis=1) & (points[:, 2] > 0)
        pixels = self.pixels_per_mm * points[:, :2] + self.principal_point
        return Projection(np.where(valid[:, None], pixels, np.nan), valid)
