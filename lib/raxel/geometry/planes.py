"""Rays and planes: the bulk intersection, and the thesis's Plücker form of it (4.15).

A plane is the set z = 0 of a pose `T_world_plane` (4, 4): a grid of a calibration
target lies in it, with grid coordinates (x, y) in the plane's frame.
"""

from typing import NamedTuple

import numpy as np

from raxel.geometry.poses import inverse_pose, rotate, transform


class PlaneIntersection(NamedTuple):
    """Where rays meet a plane.

    points: (..., N, 2) x and y in the plane's frame, NaN where not valid.
    range: (..., N) signed distance from the origin of the ray, in lengths of its
        direction; NaN for a ray parallel to the plane.
    valid: (..., N) True where the ray meets the plane ahead of its origin.
    """

    points: np.ndarray
    range: np.ndarray
    valid: np.ndarray


def on_plane(points):
    """Points (..., 2) of a plane in the plane's own frame (..., 3): with z = 0."""
    points = np.asarray(points)
    lifted = np.zeros((*points.shape[:-1], 3), points.dtype)
    lifted[..., :2] = points
    return lifted


def intersect_rays_plane(origins, directions, T_world_plane):
    """Meet N rays with the plane z = 0 of a pose, all at once.

    origins: (3,) or (N, 3) in the world frame; directions: (N, 3), unit if the range is
    to be a distance; T_world_plane: (4, 4), or a stack (n, 4, 4) for n planes, which
    gives results with a leading n. Rays that are parallel to the plane, or meet it
    behind their origin, are not valid: at wide fields of view the sign of the range
    tells them, its size does not. Equal to (4.15) to rounding.
    """
    T_plane_world = inverse_pose(T_world_plane)
    d = rotate(T_plane_world, directions)
    o = transform(T_plane_world, np.atleast_2d(origins))
    slope = np.where(d[..., 2] != 0, d[..., 2], np.nan)
    distance = -o[..., 2] / slope
    valid = distance > 0
    points = o[..., :2] + distance[..., None] * d[..., :2]
    return PlaneIntersection(
        np.where(valid[..., None], points, np.nan), distance, valid
    )


def plane_of_pose(T_world_plane):
    """Homogeneous plane S (..., 4) with S . X = 0 for X on z = 0 of the pose.

    The first three entries are the unit normal r3, towards +z of the plane's frame.
    """
    T = np.asarray(T_world_plane, float)
    normal = T[..., :3, 2]
    offset = -np.sum(normal * T[..., :3, 3], axis=-1, keepdims=True)
    return np.concatenate([normal, offset], axis=-1)


def intersect_lines_plane(matrices, plane):
    """Meet lines with a plane by one matrix product: X = -M^T S (4.15).

    matrices: (n, 4, 4) Plücker matrices (2.11); plane: (4,) homogeneous, same frame.
    Returns (n, 4) homogeneous points; the fourth entry is zero for a line parallel to
    the plane, and all four for a line inside it. A line has no beginning: points
    behind a camera are not told apart here (see `intersect_rays_plane`).
    """
    matrices = np.asarray(matrices, float)
    # M = [M_1 ... M_n] of the thesis is 4 x 4n; skew symmetry makes -M^T the same
    # matrices stacked upon each other, which is how they lie in memory.
    return (matrices.reshape(-1, 4) @ np.asarray(plane, float)).reshape(-1, 4)
