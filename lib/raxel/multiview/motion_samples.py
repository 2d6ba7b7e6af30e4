"""Motions of many small samples of matched rays at once, for a robust start.

Each sample starts from several rotations: the one that best turns the first directions
into the second, which is near where points are far or the motion small; and the two of
the sample's central essential matrix, which are near where the rays come close to one
point. Each gets shifts of its own, and then a few damped Gauss-Newton steps on the
sample's angles, all samples side by side. Rays turn alike to all sides about their
pivots here (`NoisyRays.pivots`).

Arrays are (3, m, n): components, motions, pairs. Frame: centre of the rays.
"""

from typing import NamedTuple

import numpy as np

from raxel.geometry.poses import nearest_rotation, rotation_from_vector, tangent_bases

SAMPLE = 8
SPREADS = 2.0, 8.0  # lengths that are tried, in spreads of the rays
STEPS, FREE_STEPS, DAMPING, LEAST_DAMPING = 8, 3, 1e-2, 1e-9
LARGEST_TURN = 0.5  # radians, of one step
LEAST = 1e-300
FLAT = 1e-12  # share of the trace that keeps a normal matrix from being singular
# Sines of angles between rays below this many thresholds leave it open whether a point
# lies ahead.
PARALLEL = 3.0


class TurningPairs(NamedTuple):
    """Pairs whose rays turn about points: p, d (3, ..., n) of either view with sd
    (..., n), radians."""

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
    A small sample may hold next to nothing of the length, and steps that are free to
    change it then end at no motion at all. So lengths of several spreads are held, and
    set free at the end. Motions that do not even fit their own sample to within the
    threshold, in standard deviations, are left out: its pairs are not all right.
    """
    R, axes = _start_rotations(samples)
    samples = _repeated(samples, len(R) // samples.d_1.shape[1])
    ways, least = _start_shifts(R, axes, samples)
    lengths = [length] if length is not None else [times * spread for times in SPREADS]
    found = [(settled(R, least, samples), samples)] if length is None else []
    samples, ways = _repeated(samples, len(lengths)), np.tile(ways, (len(lengths), 1))
    lengths = np.repeat(lengths, len(R))
    R = np.tile(R, (len(lengths) // len(R), 1, 1))
    held = settled(R, lengths[:, None] * ways, samples, lengths)
    found.append((held, samples))
    if length is None:
        found.append((settled(*held, samples, steps=FREE_STEPS), samples))
    kept = [_fitting(*motions, own, threshold) for motions, own in found]
    return tuple(np.concatenate(part) for part in zip(*kept, strict=True))


def _fitting(R, u, samples, threshold):
    keep = squared_gaps(R, u, samples, threshold).mean(axis=1) < threshold**2
    return R[keep], u[keep]


def _repeated(samples, times):
    """The samples one after another, so many times over."""
    return TurningPairs(*(np.concatenate([f] * times, axis=-2) for f in samples))


def settled(R, u, samples, length=None, steps=STEPS):
    """Motions R (m, 3, 3), u (m, 3) after Gauss-Newton steps on a sample each.

    Residuals are divided by their standard deviations of the moment; near the minimum
    of a small sample that makes no difference.
    """
    damping = DAMPING
    for _ in range(steps):
        _, g, variance, J = _linearised(R, u, samples)
        weight = 1 / np.sqrt(variance)
        J, g = J * weight, g * weight
        free = None if length is None else _tangents(u)
        if free is not None:
            J = np.concatenate([J[:3], np.einsum("mip,imn->pmn", free, J[3:])])
        step = _damped(J, g, damping)
        damping = max(damping / 10, LEAST_DAMPING)
        turn = np.linalg.norm(step[:, :3], axis=1, keepdims=True)
        step = step * np.minimum(1, LARGEST_TURN / np.maximum(turn, LEAST))
        R = rotation_from_vector(step[:, :3]) @ R
        shift = step[:, 3:]
        if free is not None:
            shift = np.einsum("mip,mp->mi", free, shift)
        u = u + shift
        if length is not None:
            u = u * (length / np.maximum(np.linalg.norm(u, axis=1), LEAST))[:, None]
    return R, u


def squared_gaps(R, u, pairs, threshold):
    """Squared `gaps` (m, N) of motions and all pairs; infinite where a point is behind
    a pivot.

    Not behind an origin: a mirror is far ahead of its rays' pivots, and a length that
    is hardly told may put points in between. Rays that are parallel to within
    `threshold` standard deviations meet nowhere that could be told from infinity, so
    they are asked nothing.
    """
    (q, b, n), g, variance, _ = _linearised(R, u, pairs, jacobian=False)
    cosine, sine = _dot(q, pairs.d_2), _dot(n, n)
    qb, db = _dot(q, b), _dot(pairs.d_2, b)
    room = PARALLEL**2 * threshold**2 * (pairs.sd_1**2 + pairs.sd_2**2)
    behind = (cosine * db - qb <= 0) | (db - cosine * qb <= 0)
    squared = np.where(behind & (sine > room), np.inf, g**2 / variance)
    return np.where(np.isfinite(squared), squared, np.inf)


def best_turn(d_1, d_2):
    """Rotations (m, 3, 3) that turn d_1 (3, m, k) into d_2 in the least-squares sense.

    Source: Arun, Huang, Blostein 1987, doi:10.1109/TPAMI.1987.4767965.
    """
    return nearest_rotation(np.einsum("imk,jmk->mij", d_2, d_1))


def _start_rotations(samples):
    """Rotations (3 m, 3, 3), the m samples three times over, and axes (3 m, 3)."""
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
    """(ways (m, 3), least (m, 3)): the unit axes, turned to where they put more points
    ahead, and the shifts that least squares give to the rotations."""
    (q, _, n), g, _, _ = _linearised(R, np.zeros_like(axes), samples, jacobian=False)
    normal = np.einsum("imk,jmk->mij", n, n)
    normal += FLAT * np.trace(normal, axis1=1, axis2=2)[:, None, None] * np.eye(3)
    right = np.einsum("imk,mk->mi", n, g)
    least = -np.linalg.solve(normal, right[:, :, None])[:, :, 0]
    b = axes.T[:, :, None]
    cosine, qb, db = _dot(q, samples.d_2), _dot(q, b), _dot(samples.d_2, b)
    votes = np.sign(cosine * db - qb) + np.sign(db - cosine * qb)
    return np.where(votes.sum(axis=1) < 0, -1.0, 1.0)[:, None] * axes, least


def _linearised(R, u, pairs, jacobian=True):
    """((q, b, n), g, variance (m, n), dg (6, m, n)) of motions."""
    q, arm = (np.einsum("mij,jmn->imn", R, np.broadcast_to(x, _wide(x, R)))
              for x in (pairs.d_1, pairs.p_1))  # fmt: skip
    d = pairs.d_2
    b = arm + u.T[:, :, None] - pairs.p_2
    n = _cross(q, d)
    g = _dot(n, b)
    far = _dot(b, b) - g**2
    variance = pairs.sd_1**2 * (far - _dot(d, b) ** 2)
    variance += pairs.sd_2**2 * (far - _dot(q, b) ** 2)
    variance = np.maximum(variance, LEAST)
    if not jacobian:
        return (q, b, n), g, variance, None
    by_w = _cross(q, _cross(d, b)) + _cross(arm, n)
    return (q, b, n), g, variance, np.concatenate([by_w, n])


def _damped(J, g, damping):
    """Damped Gauss-Newton steps (m, p) of J (p, m, n) and g (m, n)."""
    J = J.transpose(1, 0, 2)
    normal, right = J @ J.transpose(0, 2, 1), J @ g[:, :, None]
    size = np.sqrt(np.maximum(np.einsum("mpp->mp", normal), LEAST))
    scaled = normal / (size[:, :, None] * size[:, None]) + damping * np.eye(J.shape[1])
    return -np.linalg.solve(scaled, right / size[:, :, None])[:, :, 0] / size


def _tangents(u):
    length = np.maximum(np.linalg.norm(u, axis=1, keepdims=True), LEAST)
    return tangent_bases(u / length)


def _wide(x, R):
    return (3, len(R), x.shape[2])


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
