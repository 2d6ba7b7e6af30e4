"""How far a calibrated flexible mirror is off: shape, rays, back-projection."""

from __future__ import annotations

import numpy as np

from raxel.calibration import pose_from_non_central_rays
from raxel.geometry import intersect_rays_plane

STEPS, ARRIVED_MM = 20, 1e-9


def load_height(rig, found, true):
    """Height (mm) of a calibrated mirror over the flat sheet where the load acts.

    found, true: cameras of one stage. It is read on the line through the load along
    which a load moves the sheet; NaN where the spline does not reach it.
    """
    place, along = rig.load_point(true), rig.deflection_direction()
    height = along @ (place - true.T_viewer_mirror[:3, 3])
    shift = 0.0
    for _ in range(STEPS):
        P = place + shift * along
        # The mirror's point on the same viewing ray, and its tangent plane there.
        S = found.mirror.points((P[:2] / P[2])[None])
        n = found.mirror.normals(S)[0]
        step = n @ (S[0] - P) / (n @ along)
        shift += step
        if not abs(step) > ARRIVED_MM:
            break
    return float(height + shift)


def ray_angles(found, true, pixels):
    """Angles (N,), degrees, between the rays of two cameras, NaN where one has none."""
    return angles_between(*(camera.rays(pixels).directions for camera in (found, true)))


def angles_between(first, second):
    """Angles (N,), degrees, between unit directions (N, 3)."""
    half = np.linalg.norm(first - second, axis=1) / 2
    return np.degrees(2 * np.arcsin(half))


def back_projection(found, pixels, points, T_camera_board=None):
    """Errors (N, 2) mm on a board between its corners and where their rays meet it.

    pixels: (N, 2), NaN where not seen; points: (N, 2). T_camera_board: (4, 4), the true
    pose, or None for the one that the calibrated camera itself finds, as in 5.3.3.
    """
    rays = found.rays(pixels)
    if T_camera_board is None:
        T_camera_board = pose_from_non_central_rays(rays, points).T_camera_grid
    met = intersect_rays_plane(rays.origins, rays.directions, T_camera_board)
    return met.points - points


def lengths(errors):
    """Lengths (n,) of errors (N, 2), without those that are unknown."""
    found = np.linalg.norm(errors, axis=1)
    return found[np.isfinite(found)]
