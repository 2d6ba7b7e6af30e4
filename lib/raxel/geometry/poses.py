"""Rigid poses as 4x4 arrays, named target from source.

`T_camera_grid` maps grid coordinates to camera coordinates: X_camera = R X_grid + t.
Poses chain by `@` when the inner names agree: T_world_grid = T_world_camera @
T_camera_grid. Lengths are mm (or units of the pitch), angles radians.
"""

import numpy as np

from raxel.errors import InputError

# Rays as Plücker vectors, what a motion does to them, and when two of them meet. The
# order is the thesis's (2.12), see `lines`: (d; -(o x d)), direction first, then the
# moment with its sign reversed. With X_2 = R X_1 + t and E = [t]x R, lines that meet
# satisfy L_2^T G L_1 = 0 (5.30), where G = [[E, -R], [-R, 0]] in this order, G = [[E,
# R], [ R, 0]] in the usual one, (d; o x d) (errata E-5.12). Whoever hands rays to
# another program, or takes a formula from a book, calls `other_order` on the way.
# Source: Pless 2003, doi:10.1109/CVPR.2003.1211520.


def pluecker_of_rays(origins, directions):
    """Plücker vectors (..., 6) of rays, thesis order: (d; -(o x d)).

    origins: (..., 3) in the unit of length of the frame; directions: (..., 3). With
    unit directions the last three are as long as the line is far from the frame's
    origin. Any point of the line will do as its origin.
    """
    o, d = np.broadcast_arrays(np.asarray(origins, float), np.asarray(directions))
    return np.concatenate([d, np.cross(d, o)], axis=-1)


def other_order(L):
    """Plücker vectors (..., 6) from the thesis's order to the usual one, or back."""
    return np.asarray(L, float) * [1, 1, 1, -1, -1, -1]


def generalised_essential(T_2_1):
    """Generalised essential matrix (..., 6, 6) of a motion, thesis order (5.30).

    T_2_1: (..., 4, 4), X_2 = R X_1 + t.
    """
    T = np.asarray(T_2_1, float)
    R, G = T[..., :3, :3], np.zeros((*T.shape[:-2], 6, 6))
    G[..., :3, :3] = cross_matrix(T[..., :3, 3]) @ R
    G[..., :3, 3:] = G[..., 3:, :3] = -R
    return G


def side_products(L_1, L_2, T_2_1):
    """L_2^T G L_1 (N,) of matched lines (5.30), zero where they meet.

    L_1, L_2: (N, 6), thesis order, each in the frame of its view. For unit directions
    this is their distance times the sine of the angle between them, with a sign.
    """
    G = generalised_essential(T_2_1)
    return np.einsum("ni,ij,nj->n", np.asarray(L_2, float), G, np.asarray(L_1, float))


# Pose of a plane from its homography into calibrated directions (2.5.2).


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


def pose(R, t):
    """Pose (..., 4, 4) from rotations R (..., 3, 3) and translations t (..., 3)."""
    R, t = np.asarray(R, float), np.asarray(t, float)
    shape = np.broadcast_shapes(R.shape[:-2], t.shape[:-1])
    T = np.zeros((*shape, 4, 4))
    T[..., :3, :3] = R
    T[..., :3, 3] = t
    T[..., 3, 3] = 1.0
    return T


def inverse_pose(T):
    """Inverse of poses (..., 4, 4): (R^T, -R^T t), exact for orthonormal R."""
    T = np.asarray(T, float)
    Rt = np.swapaxes(T[..., :3, :3], -1, -2)
    return pose(Rt, -(Rt @ T[..., :3, 3, None])[..., 0])


def transform(T, points):
    """Points of the source frame in the target frame.

    T: (4, 4) with points (..., 3); or a stack (n, 4, 4) with points (N, 3) or
    (n, N, 3), which gives (n, N, 3).
    """
    T = np.asarray(T, float)
    t = T[..., :3, 3]
    return rotate(T, points) + (t if T.ndim == 2 else t[..., None, :])


def rotate(T, directions):
    """Directions of the source frame in the target frame; shapes as `transform`.

    T may also be a bare rotation (3, 3) or a stack of them.
    """
    R = np.asarray(T, float)[..., :3, :3]
    return np.asarray(directions, float) @ np.swapaxes(R, -1, -2)


def rotation_from_vector(vectors):
    """Rotation matrices (..., 3, 3) of rotation vectors (..., 3) (Rodrigues).

    The vector's direction is the axis, its length the angle in radians.
    """
    w = np.asarray(vectors, float)
    angle = np.linalg.norm(w, axis=-1)[..., None, None]
    W = cross_matrix(w)
    # np.sinc keeps both coefficients exact down to a zero angle.
    sine = np.sinc(angle / np.pi)
    versine = 0.5 * np.sinc(angle / (2 * np.pi)) ** 2
    return np.eye(3) + sine * W + versine * (W @ W)


def vector_from_rotation(R):
    """Rotation vectors (..., 3), of length at most pi, of rotations (..., 3, 3)."""
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


def tangent_bases(directions):
    """Two unit vectors at right angles to each unit vector (N, 3) and to each other.

    Returns (N, 3, 2), the vectors in columns.
    """
    smallest = np.argmin(np.abs(directions), axis=1)
    first = np.cross(directions, np.eye(3)[smallest])
    first /= np.linalg.norm(first, axis=1, keepdims=True)
    return np.stack([first, np.cross(directions, first)], axis=2)


def nearest_rotation(M):
    """Rotation (..., 3, 3) nearest to M in the Frobenius norm.

    M: (..., 3, 3), or (..., 3, 2): the first two columns of a rotation, for which the
    nearest orthonormal pair is completed by its cross product. The scale of M does not
    matter. Raises InputError when M leaves the rotation open: columns parallel or zero.
    Source: Arun, Huang, Blostein 1987, doi:10.1109/TPAMI.1987.4767965; Umeyama 1991,
    doi:10.1109/34.88573 (sign of the determinant).
    """
    M = np.asarray(M, float)
    U, s, Vt = np.linalg.svd(M, full_matrices=False)
    if not np.all(s[..., 1] > 1e-12 * s[..., 0]):
        raise InputError(
            "rotation: the matrix has rank below 2, so no single rotation is nearest; "
            "its columns must not be parallel or zero"
        )
    if M.shape[-1] == 2:
        pair = U @ Vt
        third = np.cross(pair[..., 0], pair[..., 1])
        return np.concatenate([pair, third[..., None]], axis=-1)
    sign = np.sign(np.linalg.det(U @ Vt))
    U = np.concatenate([U[..., :2], U[..., 2:] * sign[..., None, None]], axis=-1)
    return U @ Vt


def angle_between_rotations(A, B):
    """Angle (...) in radians, 0 to pi, of the rotation A^T B; A, B (..., 3, 3)."""
    D = np.swapaxes(np.asarray(A, float), -1, -2) @ np.asarray(B, float)
    axis = [D[..., k, j] - D[..., j, k] for j, k in [(1, 2), (2, 0), (0, 1)]]
    trace = np.trace(D, axis1=-2, axis2=-1)
    # The arc tangent is accurate at 0 and at pi, where arc cosine or sine is not.
    return np.arctan2(np.linalg.norm(np.stack(axis, axis=-1), axis=-1), trace - 1)


def fit_pose(source, target, weights=None):
    """Pose T_target_source (4, 4) that best maps points to points.

    source, target: (N, 3), N >= 3, same unit; weights: (N,), each multiplies the
    squared distance of its pair. Minimises sum w |R s + t - p|^2. Raises InputError for
    fewer than three points, values that are not finite, or points on one line.
    Source: Arun, Huang, Blostein 1987, doi:10.1109/TPAMI.1987.4767965.
    """
    source, target = np.asarray(source, float), np.asarray(target, float)
    w = np.ones(len(source)) if weights is None else np.asarray(weights, float)
    if source.shape != target.shape or source.shape[1:] != (3,) or len(source) < 3:
        raise InputError(
            f"pose fit: found points {source.shape} and {target.shape}; give two equal "
            "arrays (N, 3) with at least three points"
        )
    if not (np.isfinite(source).all() and np.isfinite(target).all()):
        raise InputError("pose fit: some points are not finite; remove them first")
    w = w / w.sum()
    centre_s, centre_t = w @ source, w @ target
    covariance = (target - centre_t).T @ ((source - centre_s) * w[:, None])
    R = nearest_rotation(covariance)
    return pose(R, centre_t - R @ centre_s)
