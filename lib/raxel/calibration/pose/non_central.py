"""Pose of a planar grid from the rays of a non-central camera.

(2.26) for all corners at once, as the thesis modifies it for flexible mirrors (5.2.2):
the grid is flat in the model, and the ray-point distances of all corners are minimised.
The start assumes that all rays pass through the point nearest to them, and is the best
of many triples. A small image may leave the tilt ambiguous; then both are refined.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike

from raxel.calibration.pose.three_point import (
    checked_rays,
    placed_points,
    pose_of_spread_triples,
    ray_point_system,
    refine_pose_ray_point,
)
from raxel.cameras.core.base import Rays, closest_point
from raxel.errors import CalibrationError
from raxel.geometry.poses import pose, rotation_from_vector

# Outlier threshold in medians of the distances, and minimum median in mm.
OUTLIER_MEDIANS, MIN_MEDIAN_MM = 6.0, 1e-9
MAX_N_ROUNDS = 8
MIN_N_CORNERS = 6  # twelve equations for the six pose parameters
# Cost of the other tilt over that of the best one: below, the tilt is ambiguous.
AMBIGUOUS_COST_RATIO = 1.5
MIN_NORMAL_DIFFERENCE_RAD = 1e-2  # between the normals of two distinct tilts
# Numbers of widely spaced points whose triples give the start; the second one where the
# better half of the distances exceeds this fraction of the grid's extent (outliers).
N_START_POINTS, MAX_START_ERROR = (6, 12), 3e-3


class NonCentralPose(NamedTuple):
    """Pose of a grid from the rays of a non-central camera.

    Attributes
    ----------
    T_camera_grid
        (4, 4), pose of the grid in the frame of the rays.
    covariance
        (6, 6) of (w, s), the error of the pose as R exp([w]x), t + R s, from the
        scatter of the distances.
    inliers
        (N,) bool, pairs that agree with the pose.
    rms
        Root mean square of the distances of the inliers, mm.
    ambiguous
        Whether the other tilt fits nearly as well.
    """

    T_camera_grid: np.ndarray
    covariance: np.ndarray
    inliers: np.ndarray
    rms: float
    ambiguous: bool


def pose_from_non_central_rays(
    rays: Rays, points: ArrayLike, start: ArrayLike | None = None
) -> NonCentralPose:
    """Return the pose of a grid, robust against up to a fifth of wrong pairs.

    Parameters
    ----------
    rays
        N rays in the camera frame. Rays that are not valid are ignored.
    points
        (N, 2), points on the grid, mm.
    start
        (4, 4), approximate pose, such as that of the previous image. With a start, no
        other pose is tried.

    Returns
    -------
    NonCentralPose
        Pose `T_camera_grid`, covariance and inliers.

    Raises
    ------
    CalibrationError
        Fewer than MIN_N_CORNERS corners have rays ("too-few-points"), most of them fit
        no pose ("too-many-outliers"), or the arrays do not fit ("shape", "not-finite").

    References
    ----------
    Thesis (2.26) and section 5.2.2.
    """
    valid = np.asarray(rays.valid, bool)
    if np.count_nonzero(valid) < MIN_N_CORNERS:
        raise CalibrationError(
            f"grid pose: found {np.count_nonzero(valid)} corners with rays; give "
            f"{MIN_N_CORNERS} or more",
            code="too-few-points",
        )
    origins = np.asarray(rays.origins)[valid]
    directions, found = checked_rays(
        np.asarray(rays.directions)[valid], np.asarray(points, float)[valid]
    )
    if start is not None:
        T, right, cost = _refined(origins, directions, found, start)
        ambiguous = False
    else:
        T, right, cost, ambiguous = _better_tilt(origins, directions, found)
    if 2 * np.count_nonzero(right) < len(right):
        raise CalibrationError(
            f"grid pose: {np.count_nonzero(right)} of {len(right)} corners agree with "
            "one pose; check the assignment of corners to points",
            code="too-many-outliers",
        )
    count = np.count_nonzero(right)
    _, jacobian = ray_point_system(
        directions[right], found[right], T, origins[right], np.ones(count)
    )
    covariance = np.linalg.inv(jacobian.T @ jacobian) * cost / (2 * count - 6)
    inliers = valid.copy()
    inliers[valid] = right
    return NonCentralPose(T, covariance, inliers, np.sqrt(cost / count), ambiguous)


def other_tilt(
    T_camera_grid: np.ndarray, points: np.ndarray, viewpoint: np.ndarray
) -> np.ndarray:
    """Return the pose whose grid is tilted the other way against the line of sight.

    The image of the grid is nearly the same where it is small.

    Parameters
    ----------
    T_camera_grid
        (4, 4), pose of the grid.
    points
        (N, 2), points on the grid, whose mean stays where it is.
    viewpoint
        (3,), point from which the grid is viewed, camera frame.

    Returns
    -------
    ndarray
        (4, 4), pose of the grid.
    """
    R = T_camera_grid[:3, :3]
    middle = placed_points(points.mean(axis=0)[None], T_camera_grid)[0]
    sight = (middle - viewpoint) / np.linalg.norm(middle - viewpoint)
    normal = R[:, 2] * np.sign(R[:, 2] @ sight or 1.0)
    across = np.cross(normal, sight)
    size = np.linalg.norm(across)
    if size < 1e-12:
        return T_camera_grid
    turn = 2 * np.arctan2(size, normal @ sight) * across / size
    other = rotation_from_vector(turn) @ R
    return pose(other, middle - other[:, :2] @ points.mean(axis=0))


def _better_tilt(origins, directions, points):
    """The better of the poses refined from both tilts, and whether it is ambiguous."""
    viewpoint = closest_point(Rays(origins, directions, np.ones(len(points), bool)))
    cost = _truncated(origins, directions, points)
    extent = np.linalg.norm(np.ptp(points, axis=0))
    tried = []
    for count in N_START_POINTS:
        start = pose_of_spread_triples(directions, points, count)
        start[:3, 3] += viewpoint
        one = _refined(origins, directions, points, start)
        start = other_tilt(one[0], points, viewpoint)
        tried += [one, _refined(origins, directions, points, start)]
        best, *others = sorted(tried, key=cost)
        if cost(best) <= len(points) / 2 * (MAX_START_ERROR * extent) ** 2:
            break
    ambiguous = any(
        np.abs(best[0][:3, 2] - other[0][:3, 2]).max() > MIN_NORMAL_DIFFERENCE_RAD
        and other[2] < AMBIGUOUS_COST_RATIO * best[2]
        for other in others
    )
    return *best, ambiguous


def _truncated(origins, directions, points):
    """Cost of a refined pose, truncated to half of the pairs."""

    def cost(refined):
        errors = _distances(origins, directions, points, refined[0])
        return np.sum(np.sort(errors)[: (len(errors) + 1) // 2] ** 2)

    return cost


def _refined(origins, directions, points, T):
    """Pose, inliers (N,) and their cost, mm^2, refined until the inliers are stable."""
    right = np.ones(len(points), bool)
    for _ in range(MAX_N_ROUNDS):
        errors = _distances(origins, directions, points, T)
        width = max(np.median(errors), MIN_MEDIAN_MM)
        now = errors <= OUTLIER_MEDIANS * width
        T, cost = refine_pose_ray_point(
            directions[now], points[now], T, origins=origins[now]
        )
        if np.array_equal(now, right):
            break
        right = now
    return T, now, cost


def _distances(origins, directions, points, T):
    reach = placed_points(points, T) - origins
    along = np.einsum("ni,ni->n", reach, directions)
    errors = np.linalg.norm(reach - along[:, None] * directions, axis=1)
    return np.where(along > 0, errors, np.inf)
