"""Rays and planes: the bulk intersection, and the thesis's Plücker form of it (4.15).

A plane is the set z = 0 of a pose `T_world_plane` (4, 4): a grid of a calibration
target lies in it, with grid coordinates (x, y) in the plane's frame.
"""

from typing import NamedTuple

import numpy as np

from raxel.geometry.poses import inverse_pose, rotate, transform

# Lines in space in Plücker form: the 4x4 matrix (2.11) and the 6-vector (2.12). Both
# forms are homogeneous: only their direction in 16 or 6 dimensions has a meaning. The
# 6-vector keeps the thesis's order, which is **not** the usual one: direction first,
# then the moment with its sign *reversed*. For finite points A and B L = 2 (B - A ;
# -(A x B)) = 2 (d ; q), q = d x A = -(A x d), while textbooks write (d ; A x d).
# Whoever takes a formula from a book into code that uses this order changes the sign
# of the last three entries (errata E-2.03, E-5.12).


# Row and column of the first term of each entry of (2.12), counted from zero.
ORDER = ((3, 0), (3, 1), (3, 2), (2, 1), (0, 2), (1, 0))


def pluecker_matrix(A, B):
    """Plücker matrix A B^T - B A^T of the line through two distinct points (2.11).

    A, B: (..., 4) homogeneous points, any frame and unit. Returns (..., 4, 4),
    skew-symmetric. Two equal points have no line: their matrix is zero.
    """
    A, B = np.asarray(A, float), np.asarray(B, float)
    product = A[..., :, None] * B[..., None, :]
    return product - np.swapaxes(product, -1, -2)


def pluecker_matrix_of_rays(origins, directions):
    """Plücker matrices of the lines through `origins` along `directions`.

    origins: (..., 3) in the unit of length of the frame; directions: (..., 3), not
    zero. Returns (..., 4, 4). With unit directions, (2.12) of the result is
    2 (d ; -(o x d)).
    """
    origins, directions = np.broadcast_arrays(
        np.asarray(origins, float), np.asarray(directions, float)
    )
    one = np.ones((*origins.shape[:-1], 1))
    return pluecker_matrix(
        np.concatenate([origins, one], axis=-1),
        np.concatenate([directions, 0.0 * one], axis=-1),
    )


def pluecker_vector(M):
    """Plücker 6-vector of a Plücker matrix, in the thesis's order (2.12).

    M: (..., 4, 4). Returns (..., 6): twice the direction, then twice the negated
    moment. The last three entries vanish for a line through the origin.
    """
    M = np.asarray(M, float)
    return np.stack([M[..., i, j] - M[..., j, i] for i, j in ORDER], axis=-1)


# Steps of a vector that is told up to its length, and kept at length 1.


def tangents(p):
    """Unit vectors (n, n - 1), in columns, across p (n,) and each other."""
    return np.linalg.svd(p[None])[2][1:].T


def stepped(p, step):
    """p (n,) after a step (n - 1,) along its `tangents`, at length 1."""
    moved = p + tangents(p) @ step
    return moved / np.linalg.norm(moved)


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
