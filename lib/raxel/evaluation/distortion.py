"""What distortion is left after a calibration (thesis section 2.5), and by what angle.

Pixels are turned into their rays, the rays meet a synthetic image plane at right angles
to the principal ray, and a homography from the known metric grid is taken out. What
remains is distortion. The homography also hides much of a wrong centre or pose, so an
angular residual belongs beside it.
"""

from typing import NamedTuple

import numpy as np

from raxel.errors import InputError
from raxel.geometry.homography import (
    apply_homography,
    homography_dlt,
    refine_homography,
)
from raxel.geometry.planes import intersect_rays_plane
from raxel.geometry.poses import nearest_rotation, pose


class SyntheticPlane(NamedTuple):
    """The image plane of a distortion-free view (2.5.1).

    T_camera_plane: (4, 4), plane z = 0, its origin on the principal ray, x along the
    image's u. px_per_unit: pixels per length on the plane, such that the view is as
    large as the image where the principal pixel is. principal_pixel: (2,), shared by
    the image and the view.
    """

    T_camera_plane: np.ndarray
    px_per_unit: float
    principal_pixel: np.ndarray


def synthetic_plane(camera, principal_pixel=None, distance=1.0):
    """The plane at right angles to the ray of principal_pixel, default mid-image.

    camera: any Camera; distance: of the plane along that ray, in the camera's unit. It
    does not matter where all rays start at one point. To a non-central camera it does,
    and before a mirror, even a central one, the plane must lie ahead of all the rays'
    origins. Raises InputError where the camera has no rays around the pixel.
    """
    if principal_pixel is None:
        principal_pixel = (camera.width - 1) / 2, (camera.height - 1) / 2
    pixel = np.asarray(principal_pixel, float)
    steps = np.array([[0, 0], [0.5, 0], [-0.5, 0], [0, 0.5], [0, -0.5]])
    rays = camera.rays(pixel + steps)
    if not rays.valid.all():
        raise InputError(
            f"synthetic plane: no rays around pixel {pixel.tolist()}; give a principal"
            " pixel inside the calibrated area"
        )
    normal = rays.directions[0]
    along_u = rays.directions[1] - rays.directions[2]
    along_u = along_u - (along_u @ normal) * normal
    along_u /= np.linalg.norm(along_u)
    rotation = np.column_stack([along_u, np.cross(normal, along_u), normal])
    T = pose(rotation, rays.origins[0] + distance * normal)
    hits = intersect_rays_plane(rays.origins, rays.directions, T).points
    per_pixel = np.stack([hits[1] - hits[2], hits[3] - hits[4]])
    scale = 1.0 / np.sqrt(abs(np.linalg.det(per_pixel)))
    return SyntheticPlane(T, float(scale), pixel)


def corrected_view(directions, plane, origins=(0.0, 0.0, 0.0)):
    """Where rays appear in the distortion-free view.

    directions: (N, 3); origins: (3,) or (N, 3), in the frame of plane.T_camera_plane.
    Returns pixels (N, 2), NaN where a ray does not meet the plane ahead, and valid
    (N,).
    """
    hits = intersect_rays_plane(origins, directions, plane.T_camera_plane)
    return plane.principal_pixel + plane.px_per_unit * hits.points, hits.valid


def distortion_residual(corrected, metric):
    """Residual vectors after the homography from the metric grid (2.5.1, 2.5.2).

    corrected: (N, 2) px of the corrected view; metric: (N, 2) the points' places on
    their plane; N >= 5. The homography maps metric to corrected and minimises the
    distances there (DLT, then refinement). Returns (N, 2): corrected less mapped.
    Raises InputError as `homography_dlt`.
    """
    H = refine_homography(homography_dlt(metric, corrected), metric, corrected)
    return corrected - apply_homography(H, metric)


def angular_residual(directions, reference, *, aligned=True):
    """Angles (N,) in radians between two sets of unit directions (N, 3).

    aligned: after the rotation that maps one set best to the other (least squares), for
    cameras whose frames were chosen apart; otherwise as they are.
    """
    directions, reference = np.asarray(directions, float), np.asarray(reference, float)
    if aligned:
        directions = directions @ nearest_rotation(reference.T @ directions).T
    across = np.linalg.norm(np.cross(directions, reference), axis=1)
    return np.arctan2(across, np.sum(directions * reference, axis=1))
