"""Rays and planes: the bulk intersection, and the thesis's Plücker form of it (4.15).

A plane is the set z = 0 of a pose `T_world_plane` (4, 4): a grid of a calibration
target is in it, with grid coordinates (x, y) in the plane's frame.
"""

from __future__ import annotations

from typing import Any, NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.geometry.poses import inverse_pose, rotate, transform

# Lines in space in Plücker form: the 4x4 matrix (2.11) and the 6-vector (2.12). Both
# forms are homogeneous: only their direction in 16 or 6 dimensions has a meaning. The
# 6-vector keeps the thesis's order, which is **not** the usual one: direction first,
# then the moment with its sign *reversed*. For finite points A and B L = 2 (B - A ;
# -(A x B)) = 2 (d ; q), q = d x A = -(A x d), while textbooks write (d ; A x d).
# Formulas from textbooks need the opposite sign of the last three entries in this
# order (errata E-2.03, E-5.12).


# Row and column of the first term of each entry of (2.12), counted from zero.
ORDER = ((3, 0), (3, 1), (3, 2), (2, 1), (0, 2), (1, 0))


def pluecker_matrix(A: ArrayLike, B: ArrayLike) -> NDArray[np.float64]:
    """Return the Plücker matrix A B^T - B A^T of the line through two points.

    Parameters
    ----------
    A, B : array_like, shape (..., 4)
        Homogeneous points in any frame and unit. Two equal points have no line:
        their matrix is zero.

    Returns
    -------
    ndarray, shape (..., 4, 4)
        Skew-symmetric matrix.

    References
    ----------
    Thesis (2.11).
    """
    A, B = np.asarray(A, float), np.asarray(B, float)
    product = A[..., :, None] * B[..., None, :]
    return product - np.swapaxes(product, -1, -2)


def pluecker_matrix_of_rays(
    origins: ArrayLike, directions: ArrayLike
) -> NDArray[np.float64]:
    """Return the Plücker matrices of lines through origins along directions.

    With unit directions, (2.12) of the result is 2 (d ; -(o x d)).

    Parameters
    ----------
    origins : array_like, shape (..., 3)
        A point on each line, in the unit of length of the frame.
    directions : array_like, shape (..., 3)
        Directions, not zero.

    Returns
    -------
    ndarray, shape (..., 4, 4)
        Skew-symmetric matrices.

    References
    ----------
    Thesis (2.11).
    """
    origins, directions = np.broadcast_arrays(
        np.asarray(origins, float), np.asarray(directions, float)
    )
    one = np.ones((*origins.shape[:-1], 1))
    return pluecker_matrix(
        np.concatenate([origins, one], axis=-1),
        np.concatenate([directions, 0.0 * one], axis=-1),
    )


def pluecker_vector(M: ArrayLike) -> NDArray[np.float64]:
    """Return the Plücker 6-vector of a Plücker matrix, in the thesis's order.

    Parameters
    ----------
    M : array_like, shape (..., 4, 4)
        Plücker matrices.

    Returns
    -------
    ndarray, shape (..., 6)
        Twice the direction, then twice the negated moment. The last three entries
        vanish for a line through the origin.

    References
    ----------
    Thesis (2.12).
    """
    M = np.asarray(M, float)
    return np.stack([M[..., i, j] - M[..., j, i] for i, j in ORDER], axis=-1)


# Steps of a vector with an arbitrary length, kept at length 1.


def tangents(p):
    """Unit vectors (n, n - 1), in columns, across p (n,) and each other."""
    return np.linalg.svd(p[None])[2][1:].T


def stepped(p, step):
    """p (n,) after a step (n - 1,) along its `tangents`, at length 1."""
    moved = p + tangents(p) @ step
    return moved / np.linalg.norm(moved)


class PlaneIntersection(NamedTuple):
    """Hold the points where rays meet a plane.

    Attributes
    ----------
    points : ndarray, shape (..., N, 2)
        x and y in the plane's frame, NaN where not valid.
    range : ndarray, shape (..., N)
        Signed distance from the origin of the ray, in lengths of its direction. NaN
        for a ray parallel to the plane.
    valid : ndarray of bool, shape (..., N)
        True where the ray meets the plane ahead of its origin.
    """

    points: np.ndarray
    range: np.ndarray
    valid: np.ndarray


def on_plane(points: ArrayLike) -> NDArray[Any]:
    """Return points of a plane in the plane's own 3D frame, with z = 0.

    Parameters
    ----------
    points : array_like, shape (..., 2)
        x and y in the plane.

    Returns
    -------
    ndarray, shape (..., 3)
        Points of the same dtype.
    """
    points = np.asarray(points)
    lifted = np.zeros((*points.shape[:-1], 3), points.dtype)
    lifted[..., :2] = points
    return lifted


def intersect_rays_plane(
    origins: ArrayLike, directions: ArrayLike, T_world_plane: ArrayLike
) -> PlaneIntersection:
    """Intersect N rays with the plane z = 0 of a pose, all at once.

    Rays that are parallel to the plane, or meet it behind their origin, are not
    valid. At wide fields of view the sign of the range reveals them, its size does
    not. Equal to (4.15) to rounding.

    Parameters
    ----------
    origins : array_like, shape (3,) or (N, 3)
        Origins of the rays in the world frame.
    directions : array_like, shape (N, 3)
        Directions in the world frame; unit if the range is to be a distance.
    T_world_plane : array_like, shape (4, 4) or (n, 4, 4)
        Pose of the plane, or a stack of n, which gives results with a leading n.

    Returns
    -------
    PlaneIntersection
        Points in the plane's frame, range, and validity.

    References
    ----------
    Thesis (4.15).

    Examples
    --------
    >>> from raxel.geometry import intersect_rays_plane, pose
    >>> T_world_plane = pose([[1, 0, 0], [0, 1, 0], [0, 0, 1]], [0, 0, 500])
    >>> hit = intersect_rays_plane([0, 0, 0], [[0.6, 0, 0.8]], T_world_plane)
    >>> hit.points.round(6), hit.range.round(6)
    (array([[375.,   0.]]), array([625.]))
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


def plane_of_pose(T_world_plane: ArrayLike) -> NDArray[np.float64]:
    """Return the homogeneous plane S with S . X = 0 for X on z = 0 of the pose.

    Parameters
    ----------
    T_world_plane : array_like, shape (..., 4, 4)
        Pose of the plane.

    Returns
    -------
    ndarray, shape (..., 4)
        Plane in the world frame. The first three entries are the unit normal r3,
        towards +z of the plane's frame.
    """
    T = np.asarray(T_world_plane, float)
    normal = T[..., :3, 2]
    offset = -np.sum(normal * T[..., :3, 3], axis=-1, keepdims=True)
    return np.concatenate([normal, offset], axis=-1)


def intersect_lines_plane(matrices: ArrayLike, plane: ArrayLike) -> NDArray[np.float64]:
    """Intersect lines with a plane by one matrix product, X = -M^T S.

    A line has no beginning: points behind a camera are not distinguished here (see
    `intersect_rays_plane`).

    Parameters
    ----------
    matrices : array_like, shape (n, 4, 4)
        Plücker matrices (2.11).
    plane : array_like, shape (4,)
        Homogeneous plane, same frame.

    Returns
    -------
    ndarray, shape (n, 4)
        Homogeneous points. The fourth entry is zero for a line parallel to the plane,
        and all four for a line inside it.

    References
    ----------
    Thesis (4.15).
    """
    matrices = np.asarray(matrices, float)
    # M = [M_1 ... M_n] of the thesis is 4 x 4n; by skew symmetry -M^T contains the same
    # matrices as a vertical stack, which is their memory layout.
    return (matrices.reshape(-1, 4) @ np.asarray(plane, float)).reshape(-1, 4)
