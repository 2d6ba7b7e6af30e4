"""Pose of a plane from its homography into calibrated directions (2.5.2)."""

import numpy as np

from raxel.errors import InputError
from raxel.geometry.poses import nearest_rotation, pose


def pose_from_homography(H):
    """Pose T_camera_grid (4, 4) of a plane that a calibrated central camera sees.

    H: (3, 3), maps (x, y, 1) on the plane z = 0 of the grid to homogeneous directions
    in the camera frame, H ~ [r1 r2 t]; its scale and sign are free. The first two
    columns give the scale (mean of their lengths) and, as nearest orthonormal pair, the
    rotation; the sign is that which puts the origin of the grid ahead (z > 0). The unit
    is that of the grid. Raises InputError for columns that are parallel or zero.
    """
    H = np.asarray(H, float)
    size = np.linalg.norm(H[:, :2], axis=0).mean()
    if not (size > 0 and np.isfinite(H).all()):
        raise InputError(
            "homography: its first columns are zero, or it is not finite; no pose "
            "follows"
        )
    scale = (-1 if H[2, 2] < 0 else 1) / size
    return pose(nearest_rotation(scale * H[:, :2]), scale * H[:, 2])
