"""Rigid poses as 4x4 arrays, named target from source.

`T_camera_grid` maps grid coordinates to camera coordinates: X_camera = R X_grid + t.
Poses chain by `@` when the inner names agree: T_world_grid = T_world_camera @
T_camera_grid. Lengths are mm (or units of the pitch), angles radians.
"""

from __future__ import annotations

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.errors import InputError

# Rays as Plücker vectors, their motion, and the condition that two of them meet. The
# order is the thesis's (2.12), see `lines`: (d; -(o x d)), direction first, then the
# moment with its sign reversed. With X_2 = R X_1 + t and E = [t]x R, lines that meet
# satisfy L_2^T G L_1 = 0 (5.30), where G = [[E, -R], [-R, 0]] in this order, G = [[E,
# R], [ R, 0]] in the usual one, (d; o x d) (errata E-5.12). Source: Pless 2003,
# doi:10.1109/CVPR.2003.1211520.


def pluecker_of_rays(origins: ArrayLike, directions: ArrayLike) -> NDArray[np.float64]:
    """Return Plücker vectors (d; -(o x d)) of rays, in the thesis's order.

    Parameters
    ----------
    origins : array_like, shape (..., 3)
        Any point of each line, in the unit of length of the frame.
    directions : array_like, shape (..., 3)
        Directions.

    Returns
    -------
    ndarray, shape (..., 6)
        Plücker vectors. With unit directions the length of the last three is the
        distance of the line from the frame's origin.

    References
    ----------
    Thesis (2.12).
    """
    o, d = np.broadcast_arrays(np.asarray(origins, float), np.asarray(directions))
    return np.concatenate([d, np.cross(d, o)], axis=-1)


def generalised_essential(T_2_1):
    """Generalised essential matrix (..., 6, 6) of a motion, thesis order (5.30).

    T_2_1: (..., 4, 4), X_2 = R X_1 + t.
    """
    T = np.asarray(T_2_1, float)
    R, G = T[..., :3, :3], np.zeros((*T.shape[:-2], 6, 6))
    G[..., :3, :3] = cross_matrix(T[..., :3, 3]) @ R
    G[..., :3, 3:] = G[..., 3:, :3] = -R
    return G


def side_products(
    L_1: ArrayLike, L_2: ArrayLike, T_2_1: ArrayLike
) -> NDArray[np.float64]:
    """Return L_2^T G L_1 of matched lines, zero where they meet.

    For unit directions this is their distance times the sine of the angle between
    them, with a sign.

    Parameters
    ----------
    L_1, L_2 : array_like, shape (N, 6)
        Plücker vectors in the thesis's order, each in the frame of its view.
    T_2_1 : array_like, shape (4, 4)
        Motion, X_2 = R X_1 + t.

    Returns
    -------
    ndarray, shape (N,)
        Products, in the unit of length of the frame for unit directions.

    References
    ----------
    Thesis (5.30).
    """
    G = generalised_essential(T_2_1)
    return np.einsum("ni,ij,nj->n", np.asarray(L_2, float), G, np.asarray(L_1, float))


# Pose of a plane from its homography into calibrated directions (2.5.2).


def pose_from_homography(H: ArrayLike) -> NDArray[np.float64]:
    """Return the pose of a plane that a calibrated central camera sees.

    The first two columns give the scale (mean of their lengths) and, as nearest
    orthonormal pair, the rotation. The sign is the one that puts the origin of the
    grid in front of the camera (z > 0). The unit is that of the grid.

    Parameters
    ----------
    H : array_like, shape (3, 3)
        Maps (x, y, 1) on the plane z = 0 of the grid to homogeneous directions in the
        camera frame, H ~ [r1 r2 t]. Its scale and sign are free.

    Returns
    -------
    ndarray, shape (4, 4)
        T_camera_grid.

    Raises
    ------
    InputError
        The first two columns are parallel or zero, or H is not finite.

    References
    ----------
    Thesis 2.5.2.
    """
    H = np.asarray(H, float)
    size = np.linalg.norm(H[:, :2], axis=0).mean()
    if not (size > 0 and np.isfinite(H).all()):
        raise InputError(
            "homography: its first columns are zero, or it is not finite (no pose); "
            "give another one"
        )
    scale = (-1 if H[2, 2] < 0 else 1) / size
    return pose(nearest_rotation(scale * H[:, :2]), scale * H[:, 2])


def pose(R: ArrayLike, t: ArrayLike) -> NDArray[np.float64]:
    """Return poses from rotations and translations.

    Parameters
    ----------
    R : array_like, shape (..., 3, 3)
        Rotations.
    t : array_like, shape (..., 3)
        Translations, mm or units of the pitch.

    Returns
    -------
    ndarray, shape (..., 4, 4)
        Poses T with X_target = R X_source + t.
    """
    R, t = np.asarray(R, float), np.asarray(t, float)
    shape = np.broadcast_shapes(R.shape[:-2], t.shape[:-1])
    T = np.zeros((*shape, 4, 4))
    T[..., :3, :3] = R
    T[..., :3, 3] = t
    T[..., 3, 3] = 1.0
    return T


def inverse_pose(T: ArrayLike) -> NDArray[np.float64]:
    """Return inverses (R^T, -R^T t) of poses, exact for orthonormal R.

    Parameters
    ----------
    T : array_like, shape (..., 4, 4)
        Poses T_target_source.

    Returns
    -------
    ndarray, shape (..., 4, 4)
        Poses T_source_target.
    """
    T = np.asarray(T, float)
    Rt = np.swapaxes(T[..., :3, :3], -1, -2)
    return pose(Rt, -(Rt @ T[..., :3, 3, None])[..., 0])


def transform(T: ArrayLike, points: ArrayLike) -> NDArray[np.float64]:
    """Return points of the source frame in the target frame.

    Parameters
    ----------
    T : array_like, shape (4, 4) or (n, 4, 4)
        Pose T_target_source, or a stack of poses.
    points : array_like, shape (..., 3)
        Points in the source frame. For a stack of poses, (N, 3) or (n, N, 3).

    Returns
    -------
    ndarray, shape (..., 3) or (n, N, 3)
        Points in the target frame.
    """
    T = np.asarray(T, float)
    t = T[..., :3, 3]
    return rotate(T, points) + (t if T.ndim == 2 else t[..., None, :])


def rotate(T: ArrayLike, directions: ArrayLike) -> NDArray[np.float64]:
    """Return directions of the source frame in the target frame.

    Parameters
    ----------
    T : array_like, shape (..., 4, 4) or (..., 3, 3)
        Poses T_target_source, or bare rotations.
    directions : array_like, shape (..., N, 3)
        Directions in the source frame; shapes as in `transform`.

    Returns
    -------
    ndarray, shape (..., N, 3)
        Directions in the target frame.
    """
    R = np.asarray(T, float)[..., :3, :3]
    return np.asarray(directions, float) @ np.swapaxes(R, -1, -2)


def rotation_from_vector(vectors: ArrayLike) -> NDArray[np.float64]:
    """Return rotation matrices of rotation vectors (Rodrigues).

    Parameters
    ----------
    vectors : array_like, shape (..., 3)
        The vector's direction is the axis, its length the angle in rad.

    Returns
    -------
    ndarray, shape (..., 3, 3)
        Rotation matrices.
    """
    w = np.asarray(vectors, float)
    angle = np.linalg.norm(w, axis=-1)[..., None, None]
    W = cross_matrix(w)
    # np.sinc keeps both coefficients exact down to a zero angle.
    sine = np.sinc(angle / np.pi)
    versine = 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    return np.eye(3) + sine * W + versine * (W @ W)


def vector_from_rotation(R: ArrayLike) -> NDArray[np.float64]:
    """Return rotation vectors, of length at most pi, of rotations.

    Parameters
    ----------
    R : array_like, shape (..., 3, 3)
        Rotation matrices.

    Returns
    -------
    ndarray, shape (..., 3)
        Rotation vectors, rad.
    """
    from scipy.spatial.transform import Rotation

    R = np.asarray(R, float)
    flat = Rotation.from_matrix(R.reshape(-1, 3, 3)).as_rotvec()
    return flat.reshape(R.shape[:-1])


def cross_matrix(vectors):
    """Matrices [w]x (..., 3, 3) of vectors (..., 3): [w]x a = w x a."""
    w = np.asarray(vectors, float)
    W = np.zeros((*w.shape, 3))
    for i, j, k in [(0, 1, 2), (1, 2, 0), (2, 0, 1)]:
        W[..., i, j] = -w[..., k]
        W[..., j, i] = w[..., k]
    return W


def tangent_bases(directions: NDArray[np.float64]) -> NDArray[np.float64]:
    """Return two unit vectors orthogonal to each unit vector and to each other.

    Parameters
    ----------
    directions : ndarray, shape (N, 3)
        Unit vectors.

    Returns
    -------
    ndarray, shape (N, 3, 2)
        The two vectors, in columns.
    """
    smallest = np.argmin(np.abs(directions), axis=1)
    first = np.cross(directions, np.eye(3)[smallest])
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(directions, first)], axis=2)


def nearest_rotation(M: ArrayLike) -> NDArray[np.float64]:
    """Return the rotation nearest to a matrix in the Frobenius norm.

    The scale of M does not matter.

    Parameters
    ----------
    M : array_like, shape (..., 3, 3) or (..., 3, 2)
        Matrices. Two columns are the first two of a rotation: the nearest orthonormal
        pair is completed by its cross product.

    Returns
    -------
    ndarray, shape (..., 3, 3)
        Rotation matrices.

    Raises
    ------
    InputError
        M leaves the rotation undetermined: its columns are parallel or zero.

    References
    ----------
    Arun, Huang, Blostein 1987, doi:10.1109/TPAMI.1987.4767965; Umeyama 1991,
    doi:10.1109/34.88573 (sign of the determinant).
    """
    M = np.asarray(M, float)
    U, s, Vt = np.linalg.svd(M, full_matrices=False)
    if not np.all(s[..., 1] > 1e-12 * s[..., 0]):
        raise InputError(
            "rotation: the matrix has rank below 2 (no unique nearest rotation); give "
            "columns that are not parallel or zero"
        )
    if M.shape[-1] == 2:
        pair = U @ Vt
        third = np.cross(pair[..., 0], pair[..., 1])
        return np.concatenate([pair, third[..., None]], axis=-1)
    sign = np.sign(np.linalg.det(U @ Vt))
    U = np.concatenate([U[..., :2], U[..., 2:] * sign[..., None, None]], axis=-1)
    return U @ Vt


def angle_between_rotations(A: ArrayLike, B: ArrayLike) -> NDArray[np.float64]:
    """Return the angle of the rotation A^T B.

    Parameters
    ----------
    A, B : array_like, shape (..., 3, 3)
        Rotation matrices.

    Returns
    -------
    ndarray, shape (...)
        Angles in rad, 0 to pi.
    """
    D = np.swapaxes(np.asarray(A, float), -1, -2) @ np.asarray(B, float)
    axis = [D[..., k, j] - D[..., j, k] for j, k in [(1, 2), (2, 0), (0, 1)]]
    trace = np.trace(D, axis1=-2, axis2=-1)
    # The arc tangent is accurate at 0 and at pi, where arc cosine or sine is not.
    return np.arctan2(np.linalg.norm(np.stack(axis, axis=-1), axis=-1), trace - 1)


def fit_pose(
    source: ArrayLike, target: ArrayLike, weights: ArrayLike | None = None
) -> NDArray[np.float64]:
    """Return the pose that best maps points to points.

    It minimises sum w |R s + t - p|^2.

    Parameters
    ----------
    source, target : array_like, shape (N, 3)
        Pairs of points, N >= 3, same unit.
    weights : array_like, shape (N,), optional
        Each multiplies the squared distance of its pair.

    Returns
    -------
    ndarray, shape (4, 4)
        T_target_source.

    Raises
    ------
    InputError
        Fewer than three points, values that are not finite, or points on one line.

    References
    ----------
    Arun, Huang, Blostein 1987, doi:10.1109/TPAMI.1987.4767965.
    """
    source, target = np.asarray(source, float), np.asarray(target, float)
    w = np.ones(len(source)) if weights is None else np.asarray(weights, float)
    if source.shape != target.shape or source.shape[1:] != (3,) or len(source) < 3:
        raise InputError(
            f"pose fit: found points {source.shape} and {target.shape}; give two equal "
            "arrays (N, 3) with at least three points"
        )
    if not (np.isfinite(source).all() and np.isfinite(target).all()):
        raise InputError("pose fit: points must be finite; remove NaN and infinity")
    w = w / w.sum()
    centre_s, centre_t = w @ source, w @ target
    covariance = (target - centre_t).T @ ((source - centre_s) * w[:, None])
    R = nearest_rotation(covariance)
    return pose(R, centre_t - R @ centre_s)
