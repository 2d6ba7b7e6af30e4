"""Motions of many small samples of matched rays at once, for a robust start.

Each sample starts from several rotations: the one that best rotates the first
directions into the second, close for distant points or small motions; and the two of
the sample's central essential matrix, close for nearly central rays. Each gets its own
shifts, and then a few damped Gauss-Newton steps on the sample's angles, for all samples
in parallel. Ray noise is isotropic about the pivots here (`NoisyRays.pivots`).

Arrays are (3, m, n): components, motions, pairs. Frame: centre of the rays.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.errors import CalibrationError
from raxel.geometry.poses import (
    nearest_rotation,
    pose,
    rotation_from_vector,
    tangent_bases,
)

# Motion between two views from matched rays: epipolar geometry without an image plane.
# A point that two central cameras see along unit directions d_1, d_2 satisfies d_2^T E
# d_1 = 0 with E = [t]x R (thesis 4.25). Directions are independent of the lens: fields
# of view beyond 180 degrees need no special case, if "in front" means along the ray.
# T_2_1 maps points of view 1 to view 2, X_2 = R X_1 + t. Rays determine t up to its
# length: |t| = 1 here. Sources: Hartley 1997, doi:10.1109/34.601246 (normalisation);
# Nister 2004, doi:10.1109/TPAMI.2004.17 (decomposition).


MIN_N_PAIRS = 8
# Smaller singular values of exact pairs, relative to the largest, are zero.
MIN_SINGULAR_RATIO = 1e-9


class RelativePose(NamedTuple):
    """Motion between two views of a central camera.

    Attributes
    ----------
    T_2_1 : ndarray of shape (4, 4)
        Motion with a translation of length 1.
    essential : ndarray of shape (3, 3)
        Essential matrix E, |E| = sqrt 2.
    rms : float
        RMS angle by which the rays of a pair would have to rotate to meet, rad.
    ahead : float
        Share of the pairs that meet ahead along both rays.
    margin : float
        Eighth over ninth singular value of the linear system. Near 1 the motion is
        undetermined: the points are on a plane, or the motion is a rotation alone.
    """

    T_2_1: np.ndarray
    essential: np.ndarray
    rms: float
    ahead: float
    margin: float


def essential_matrix(directions_1, directions_2):
    """E (3, 3) from matched unit directions (N, 3), N >= 8, by linear least squares.

    Both sets of directions are normalised to unit second moments before the system of
    nine columns is solved, so that a target in a small part of the field counts as much
    as one all around. The solution is projected to two equal singular values and a
    zero. Returns E with |E| = sqrt 2, undetermined sign, and the margin of
    `RelativePose`. Raises CalibrationError for fewer than eight pairs, values that are
    not finite, and pairs that do not determine E.
    """
    d_1, d_2 = _checked(directions_1, directions_2)
    to_1, to_2 = _whitening(d_1), _whitening(d_2)
    rows = _rows(d_1 @ to_1.T, d_2 @ to_2.T)
    values, Vt = np.linalg.svd(np.linalg.qr(rows, mode="r"))[1:]
    if not values[7] > MIN_SINGULAR_RATIO * values[0]:
        raise CalibrationError(
            "epipolar geometry: the rays do not determine the motion (points on a "
            "plane or repeated, or a pure rotation); add other points",
            code="degenerate-points",
        )
    E = to_2.T @ Vt[8].reshape(3, 3) @ to_1
    return _projected(E), float(values[7] / max(values[8], 1e-300))


def relative_pose(directions_1: ArrayLike, directions_2: ArrayLike) -> RelativePose:
    """Return the motion between two views from matched directions, linearly.

    Of the four motions that belong to E, the one with most points ahead along both rays
    is taken.

    Parameters
    ----------
    directions_1, directions_2 : array_like of shape (N, 3)
        Matched unit directions in the camera frame, N >= 8.

    Returns
    -------
    RelativePose
        The motion, with a translation of length 1.

    Raises
    ------
    CalibrationError
        With code ``shape``, ``too-few-rays``, ``not-finite``, or ``degenerate-points``
        for pairs that do not determine E.

    References
    ----------
    Thesis (4.25). Hartley 1997, doi:10.1109/34.601246; Nister 2004,
    doi:10.1109/TPAMI.2004.17.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.multiview import relative_pose
    >>> points = np.random.default_rng(1).uniform(-1, 1, (20, 3)) + [0, 0, 4]
    >>> moved = points + [0.5, 0, 0]
    >>> d_1 = points / np.linalg.norm(points, axis=1, keepdims=True)
    >>> d_2 = moved / np.linalg.norm(moved, axis=1, keepdims=True)
    >>> (np.abs(relative_pose(d_1, d_2).T_2_1[:3, 3]).round(6) + 0.0).tolist()
    [1.0, 0.0, 0.0]
    """
    d_1, d_2 = _checked(directions_1, directions_2)
    E, margin = essential_matrix(d_1, d_2)
    T, ahead = motion_of_essential(E, d_1, d_2)
    rms = float(np.sqrt(np.mean(epipolar_angles(T, d_1, d_2) ** 2)))
    return RelativePose(T, E, rms, ahead, margin)


def motion_of_essential(E, directions_1, directions_2):
    """(T_2_1, share): of the four motions of E the one with most points in front.

    E: (3, 3); directions: (N, 3). share: of points in front along both rays.
    """
    U, _, Vt = np.linalg.svd(E)
    U, Vt = U * np.sign(np.linalg.det(U)), Vt * np.sign(np.linalg.det(Vt))
    W = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    candidates = [
        pose(U @ turn @ Vt, sign * U[:, 2]) for turn in (W, W.T) for sign in (1.0, -1.0)
    ]
    shares = [
        np.mean(np.all(depths(T, directions_1, directions_2) > 0, axis=1))
        for T in candidates
    ]
    best = int(np.argmax(shares))
    return candidates[best], float(shares[best])


def depths(T_2_1, directions_1, directions_2):
    """Closest points of matched rays: depths (N, 2), along ray 1 and ray 2.

    In units of the length of the translation; negative behind the camera, infinite or
    NaN for parallel rays.
    """
    q = np.asarray(directions_1) @ T_2_1[:3, :3].T
    d, t = np.asarray(directions_2), T_2_1[:3, 3]
    cosine = np.einsum("ni,ni->n", q, d)
    with np.errstate(divide="ignore", invalid="ignore"):
        first = (cosine * (d @ t) - q @ t) / (1 - cosine**2)
        second = (d @ t - cosine * (q @ t)) / (1 - cosine**2)
    return np.stack([first, second], axis=1)


def epipolar_angles(T_2_1, directions_1, directions_2):
    """Signed angles (N,), rad, by which matched rays miss each other.

    To first order the root of the sum of squared rotations of both rays of a pair until
    they meet (Sampson's error, on the sphere).
    """
    T_2_1, d = np.asarray(T_2_1, float), np.asarray(directions_2)
    t, q = T_2_1[:3, 3], np.asarray(directions_1) @ T_2_1[:3, :3].T
    gap = np.cross(q, d) @ t
    room = np.maximum(2 - (q @ t) ** 2 - (d @ t) ** 2 - 2 * gap**2, 1e-12)
    return gap / np.sqrt(room)


def _rows(d_1, d_2):
    """The equations (4.25): (..., N, 9), for the entries of E row by row."""
    return (d_2[..., :, None] * d_1[..., None, :]).reshape(*d_1.shape[:-1], 9)


def _whitening(d):
    """A (3, 3) such that A d, over directions (N, 3), has a unit second moment."""
    values, vectors = np.linalg.eigh(d.T @ d / len(d))
    # Coplanar rays have no third direction to scale.
    values = np.maximum(values, 1e-12 * values[2])
    return (vectors / np.sqrt(values)) @ vectors.T


def _projected(E):
    """Nearest (..., 3, 3) with singular values 1, 1, 0."""
    U, _, Vt = np.linalg.svd(E)
    return U[..., :2] @ Vt[..., :2, :]


def _checked(
    directions_1: ArrayLike, directions_2: ArrayLike
) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
    d_1, d_2 = np.asarray(directions_1, float), np.asarray(directions_2, float)
    if d_1.ndim != 2 or d_1.shape[1] != 3 or d_1.shape != d_2.shape:
        raise CalibrationError(
            f"epipolar geometry: found directions {d_1.shape} and {d_2.shape}; give "
            "two equal arrays (N, 3)",
            code="shape",
        )
    if len(d_1) < MIN_N_PAIRS:
        raise CalibrationError(
            f"epipolar geometry: found {len(d_1)} pairs of rays; give {MIN_N_PAIRS} or "
            "more",
            code="too-few-rays",
        )
    bad = np.count_nonzero(~np.isfinite(d_1 + d_2).all(axis=1))
    if bad:
        raise CalibrationError(
            f"epipolar geometry: {bad} of {len(d_1)} pairs are not finite; remove them",
            code="not-finite",
        )
    return d_1, d_2


SAMPLE_SIZE = 8
LENGTH_SPREADS = 2.0, 8.0  # trial lengths, in spreads of the rays
N_STEPS, N_FREE_STEPS, FIRST_DAMPING, MIN_DAMPING = 8, 3, 1e-2, 1e-9
MAX_TURN_RAD = 0.5  # of one step
MIN_TURN_RAD = 1e-300
# Share of the trace, against a singular normal matrix.
NORMAL_MATRIX_SHARE = 1e-12
# Thresholds below which the sine of the angle between rays does not determine whether a
# point is in front.
PARALLEL_THRESHOLDS = 3.0


class TurningPairs(NamedTuple):
    """Pairs of rays that rotate about points: p, d (3, ..., n) of either view with sd
    (..., n), rad."""

    p_1: np.ndarray
    d_1: np.ndarray
    sd_1: np.ndarray
    p_2: np.ndarray
    d_2: np.ndarray
    sd_2: np.ndarray

    def of(self, picks):
        """Samples: picks (m, k) of pairs."""
        return TurningPairs(*(field[..., 0, :][..., picks] for field in self))


def turning_pairs(pairs):
    """TurningPairs, (3, 1, N) and (1, N), of MatchedRays."""
    fields = []
    for rays in (pairs.rays_1, pairs.rays_2):
        p, sd = rays.pivots()
        fields += [p.T[:, None], rays.directions.T[:, None], sd[None]]
    return TurningPairs(*fields)


def sampled_motions(samples, spread, threshold, length=None):
    """R (M, 3, 3) and u (M, 3) of m samples, several for each; M may be 0.

    samples: TurningPairs (3, m, k); spread: mm, of the rays; length: mm, of u, or None.
    A small sample may hardly determine the length, and steps with a free length then
    converge to no motion. So several lengths are fixed at first, and freed at the end.
    Motions that do not fit their own sample within the threshold, in standard
    deviations, are excluded: the sample contains an outlier.
    """
    R, axes = _start_rotations(samples)
    samples = _repeated(samples, len(R) // samples.d_1.shape[1])
    directions, least = _start_shifts(R, axes, samples)
    lengths = (
        [length] if length is not None else [times * spread for times in LENGTH_SPREADS]
    )
    found = [(settled(R, least, samples), samples)] if length is None else []
    samples, directions = (
        _repeated(samples, len(lengths)),
        np.tile(directions, (len(lengths), 1)),
    )
    lengths = np.repeat(lengths, len(R))
    R = np.tile(R, (len(lengths) // len(R), 1, 1))
    held = settled(R, lengths[:, None] * directions, samples, lengths)
    found.append((held, samples))
    if length is None:
        found.append((settled(*held, samples, steps=N_FREE_STEPS), samples))
    retained = [_fitting(*motions, own, threshold) for motions, own in found]
    return tuple(np.concatenate(part) for part in zip(*retained, strict=True))


def _fitting(R, u, samples, threshold):
    keep = squared_gaps(R, u, samples, threshold).mean(axis=1) < threshold**2
    return R[keep], u[keep]


def _repeated(samples, times):
    """The samples, repeated `times` times."""
    return TurningPairs(*(np.concatenate([f] * times, axis=-2) for f in samples))


def settled(R, u, samples, length=None, steps=N_STEPS):
    """Motions R (m, 3, 3), u (m, 3) after Gauss-Newton steps on one sample each.

    Residuals are divided by their current standard deviations; near the minimum of a
    small sample that makes no difference.
    """
    damping = FIRST_DAMPING
    for _ in range(steps):
        _, g, variance, J = _linearised(R, u, samples)
        weight = 1 / np.sqrt(variance)
        J, g = J * weight, g * weight
        free = None if length is None else _tangents(u)
        if free is not None:
            J = np.concatenate([J[:3], np.einsum("mip,imn->pmn", free, J[3:])])
        step = _damped(J, g, damping)
        damping = max(damping / 10, MIN_DAMPING)
        turn = np.linalg.norm(step[:, :3], axis=1, keepdims=True)
        step = step * np.minimum(1, MAX_TURN_RAD / np.maximum(turn, MIN_TURN_RAD))
        R = rotation_from_vector(step[:, :3]) @ R
        shift = step[:, 3:]
        if free is not None:
            shift = np.einsum("mip,mp->mi", free, shift)
        u = u + shift
        if length is not None:
            u = (
                u
                * (length / np.maximum(np.linalg.norm(u, axis=1), MIN_TURN_RAD))[
                    :, None
                ]
            )
    return R, u


def squared_gaps(R, u, pairs, threshold):
    """Squared `gaps` (m, N) of motions and all pairs; infinite where a point is behind
    a pivot.

    Points may be behind an origin: a mirror is far in front of its rays' pivots, and a
    weakly determined length may put points in between. Rays that are parallel within
    `threshold` standard deviations meet at a point that is indistinguishable from
    infinity, so they are not tested.
    """
    (q, b, n), g, variance, _ = _linearised(R, u, pairs, jacobian=False)
    cosine, sine = _dot(q, pairs.d_2), _dot(n, n)
    qb, db = _dot(q, b), _dot(pairs.d_2, b)
    room = PARALLEL_THRESHOLDS**2 * threshold**2 * (pairs.sd_1**2 + pairs.sd_2**2)
    behind = (cosine * db - qb <= 0) | (db - cosine * qb <= 0)
    squared = np.where(behind & (sine > room), np.inf, g**2 / variance)
    return np.where(np.isfinite(squared), squared, np.inf)


def best_turn(d_1, d_2):
    """Rotations (m, 3, 3) that rotate d_1 (3, m, k) into d_2, least squares.

    Source: Arun, Huang, Blostein 1987, doi:10.1109/TPAMI.1987.4767965.
    """
    return nearest_rotation(np.einsum("imk,jmk->mij", d_2, d_1))


def _start_rotations(samples):
    """Rotations (3 m, 3, 3), the m samples repeated three times, and axes (3 m, 3)."""
    d_1, d_2 = samples.d_1, samples.d_2
    rows = np.einsum("imk,jmk->mkij", d_2, d_1).reshape(*d_1.shape[1:], 9)
    _, vectors = np.linalg.eigh(np.swapaxes(rows, 1, 2) @ rows)
    U, _, Vt = np.linalg.svd(vectors[:, :, 0].reshape(-1, 3, 3))
    U = U * np.sign(np.linalg.det(U))[:, None, None]
    Vt = Vt * np.sign(np.linalg.det(Vt))[:, None, None]
    W = np.array([[0.0, -1.0, 0.0], [1.0, 0.0, 0.0], [0.0, 0.0, 1.0]])
    turn = best_turn(d_1, d_2)
    q = np.einsum("mij,jmk->imk", turn, d_1)
    n = _cross(q, d_2)
    across = np.linalg.eigh(np.einsum("imk,jmk->mij", n, n))[1][:, :, 0]
    R = np.concatenate([turn, U @ W @ Vt, U @ W.T @ Vt])
    return R, np.concatenate([across, U[:, :, 2], U[:, :, 2]])


def _start_shifts(R, axes, samples):
    """(ways (m, 3), least (m, 3)): the unit axes, with the sign that puts more points
    in front, and the least-squares shifts of the rotations."""
    (q, _, n), g, _, _ = _linearised(R, np.zeros_like(axes), samples, jacobian=False)
    normal = np.einsum("imk,jmk->mij", n, n)
    normal += (
        NORMAL_MATRIX_SHARE
        * np.trace(normal, axis1=1, axis2=2)[:, None, None]
        * np.eye(3)
    )
    right = np.einsum("imk,mk->mi", n, g)
    least = -np.linalg.solve(normal, right[:, :, None])[:, :, 0]
    b = axes.T[:, :, None]
    cosine, qb, db = _dot(q, samples.d_2), _dot(q, b), _dot(samples.d_2, b)
    votes = np.sign(cosine * db - qb) + np.sign(db - cosine * qb)
    return np.where(votes.sum(axis=1) < 0, -1.0, 1.0)[:, None] * axes, least


def _linearised(R, u, pairs, jacobian=True):
    """((q, b, n), g, variance (m, n), dg (6, m, n)) of motions."""
    q, arm = (np.einsum("mij,jmn->imn", R, np.broadcast_to(x, (3, len(R), x.shape[2])))
              for x in (pairs.d_1, pairs.p_1))  # fmt: skip
    d = pairs.d_2
    b = arm + u.T[:, :, None] - pairs.p_2
    n = _cross(q, d)
    g = _dot(n, b)
    far = _dot(b, b) - g**2
    variance = pairs.sd_1**2 * (far - _dot(d, b) ** 2)
    variance += pairs.sd_2**2 * (far - _dot(q, b) ** 2)
    variance = np.maximum(variance, MIN_TURN_RAD)
    if not jacobian:
        return (q, b, n), g, variance, None
    by_w = _cross(q, _cross(d, b)) + _cross(arm, n)
    return (q, b, n), g, variance, np.concatenate([by_w, n])


def _damped(J, g, damping):
    """Damped Gauss-Newton steps (m, p) of J (p, m, n) and g (m, n)."""
    J = J.transpose(1, 0, 2)
    normal, right = J @ J.transpose(0, 2, 1), J @ g[:, :, None]
    size = np.sqrt(np.maximum(np.einsum("mpp->mp", normal), MIN_TURN_RAD))
    scaled = normal / (size[:, :, None] * size[:, None]) + damping * np.eye(J.shape[1])
    return -np.linalg.solve(scaled, right / size[:, :, None])[:, :, 0] / size


def _tangents(u):
    length = np.maximum(np.linalg.norm(u, axis=1, keepdims=True), MIN_TURN_RAD)
    return tangent_bases(u / length)


def _cross(a, b):
    return np.stack(
        [
            a[1] * b[2] - a[2] * b[1],
            a[2] * b[0] - a[0] * b[2],
            a[0] * b[1] - a[1] * b[0],
        ]
    )


def _dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]
