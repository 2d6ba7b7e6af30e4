"""Lines, planes, rigid poses and homographies.

Everything is vectorised over points and rays, in float64. Poses are 4x4 arrays named
target from source; Plücker lines keep the thesis's order (see `lines`).
"""

from raxel.geometry.homography import (
    apply_homography,
    homography_dlt,
    homography_ransac,
    refine_homography,
    transfer_jacobian,
)
from raxel.geometry.homography_stream import HomographyFit, fit_homography
from raxel.geometry.planes import (
    PlaneIntersection,
    intersect_lines_plane,
    intersect_rays_plane,
    on_plane,
    plane_of_pose,
    pluecker_matrix,
    pluecker_matrix_of_rays,
    pluecker_vector,
)
from raxel.geometry.poses import (
    angle_between_rotations,
    cross_matrix,
    fit_pose,
    inverse_pose,
    nearest_rotation,
    pose,
    pose_from_homography,
    rotate,
    rotation_from_vector,
    transform,
    vector_from_rotation,
)

__all__ = [
    "HomographyFit",
    "PlaneIntersection",
    "angle_between_rotations",
    "apply_homography",
    "cross_matrix",
    "fit_homography",
    "fit_pose",
    "homography_dlt",
    "homography_ransac",
    "intersect_lines_plane",
    "intersect_rays_plane",
    "inverse_pose",
    "nearest_rotation",
    "on_plane",
    "plane_of_pose",
    "pluecker_matrix",
    "pluecker_matrix_of_rays",
    "pluecker_vector",
    "pose",
    "pose_from_homography",
    "refine_homography",
    "rotate",
    "rotation_from_vector",
    "transfer_jacobian",
    "transform",
    "vector_from_rotation",
]
