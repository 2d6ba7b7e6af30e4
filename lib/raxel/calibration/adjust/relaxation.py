"""Relaxation over the grids' poses: the bundle adjustment that the thesis uses (4.1.4).

The centre stays. Each round moves the poses, 6 (n - 1) numbers, by one step against the
ray-point distances (4.18) with the rays as they are; then every ray is joined anew to
the centroid of its points. The rays follow, they are not adjusted. While a round lasts
no pose knows of the others, so each takes its own step of six.

`raxel.calibration.adjust.bundle` minimises the same distances over rays and poses
together. Here rays hold the poses back, and poses the rays: rounds are cheap, but many.
"""

import numpy as np

from raxel.calibration.adjust.bundle import (
    BundleResult,
    check_shared,
    homogeneous,
    residuals_of,
)
from raxel.calibration.adjust.centroid_rays import joined_rays
from raxel.calibration.pose.three_point import refine_pose_ray_point
from raxel.errors import CalibrationError
from raxel.geometry.poses import pose, rotation_from_vector, vector_from_rotation


def relax_poses(
    points, seen, centre, T_base_grid, *, weights=None, iterations=500, tolerance=1e-6
):
    """Poses by relaxation, rays re-joined to the centroid after each round.

    points: (n, N, 2) mm; seen: (n, N) bool; centre: (3,), kept; T_base_grid: (n, 4, 4)
    start; grid 0 is the base, whose pose is the identity. weights: (n,) or (n, N), of
    the centroid; the thesis gives the grids of the linear stage more. tolerance: it
    ends when a round changes the cost by less than this share.

    Returns BundleResult; its costs, of ray-point distances, may also rise: a round does
    not minimise over the rays. Raises CalibrationError when a grid shares fewer than
    three rays with the others, or values are not finite.
    """
    seen = np.asarray(seen, bool)
    check_shared(seen)
    unknowns = pose_vector(T_base_grid)
    joined, q = joined_rays(points, seen, centre, weights), homogeneous(points, seen)
    looks = [points[j, seen[j]] for j in range(len(points))]
    costs = []
    for _ in range(iterations + 1):
        poses = poses_of_vector(unknowns)
        u = joined(poses)
        costs.append(float(np.sum(residuals_of(q, centre, poses, u) ** 2)))
        if not np.isfinite(costs[-1]):
            raise CalibrationError(
                "relaxation: the points or poses are not finite", code="not-finite"
            )
        if len(costs) > 1 and abs(costs[-2] - costs[-1]) <= tolerance * costs[-1]:
            return BundleResult(poses, u, np.array(costs), True)
        unknowns = pose_vector(_moved_once(looks, seen, centre, poses, u))
    return BundleResult(poses, u, np.array(costs), False)


def pose_vector(T_base_grid):
    """The unknowns (6 (n - 1),): Rodrigues vector, translation of all but the base."""
    turns = vector_from_rotation(T_base_grid[1:, :3, :3])
    return np.concatenate([turns, T_base_grid[1:, :3, 3]], axis=1).ravel()


def poses_of_vector(unknowns):
    """Poses (n, 4, 4) of a vector (6 (n - 1),), the base's first."""
    both = unknowns.reshape(-1, 2, 3)
    moving = pose(rotation_from_vector(both[:, 0]), both[:, 1])
    return np.concatenate([np.eye(4)[None], moving])


def _moved_once(looks, seen, centre, poses, u):
    """Poses after one step each, the rays as they are; looks: the points seen of each
    grid."""
    moved = poses.copy()
    for j in range(1, len(poses)):
        moved[j], _ = refine_pose_ray_point(
            u[seen[j]], looks[j], poses[j], origins=centre, iterations=1
        )
    return moved
