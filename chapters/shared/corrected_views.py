"""From pixels to the corrected view of a calibrated camera, and back."""

import numpy as np

from raxel.evaluation import corrected_view, synthetic_plane
from raxel.geometry import on_plane, transform


def source_pixels_of(camera, plane, corrected):
    """Pixels of the source image under points (M, 2) of the corrected view."""
    flat = (corrected - plane.principal_pixel) / plane.px_per_unit
    points = transform(plane.T_camera_plane, on_plane(flat))
    return camera.project(points).pixels


def in_view(camera, pixels):
    """Points (N, 2) of the corrected view under pixels, NaN without one."""
    plane = synthetic_plane(camera)
    rays = camera.rays(pixels)
    seen, ahead = corrected_view(rays.directions, plane, np.nan_to_num(rays.origins))
    usable = (rays.valid & ahead)[:, None]
    return np.where(usable, seen, np.nan), plane
