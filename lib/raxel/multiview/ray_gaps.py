"""How far matched rays of a general camera miss each other, and what motion does to it.

Rays (p_1, d_1) and (p_2, d_2) of two views meet under X_2 = R X_1 + t where

    g = (q x d_2) . b = 0,   q = R d_1,   b = R p_1 + t - p_2,

which is (5.30) written out. Its first-order standard deviation s follows from the rays'
noise; g / s is the residual (Sampson's error): its square is the least sum of squares,
in standard deviations, by which origins and directions of a pair have to move until it
meets. For a central camera that is `epipolar.epipolar_angles`. Distances alone would
reward a small scene.

Both views have the same frame but for the motion. It is told about a point c of that
frame, its `centre`: X_2 - c = R (X_1 - c) + u, with t = u + c - R c. For a bent mirror
the frame's origin is far from where its rays come from, and a turn about there would
look like a shift.
"""

from typing import NamedTuple

import numpy as np

from raxel.cameras.core.base import Rays, centrality, closest_point
from raxel.errors import CalibrationError
from raxel.geometry.poses import pose, rotation_from_vector, tangent_bases
from raxel.multiview.noisy_rays import with_noise

ONE_POINT = 1e-9  # of the distances at hand: rays so near to one point share it
FEWEST = 6  # pairs, for rotation and translation
ORTHOGONAL = 1e-4  # by which R R^T of a pose may miss I
# Where two origins coincide; its powers must not overflow.
LEAST_VARIANCE = 1e-90


class MatchedRays(NamedTuple):
    """rays_1, rays_2: NoisyRays (N,) of two views, matched, in a frame whose origin is
    at `centre` (3,) of the camera's frame; spread: mm, RMS distance of the rays' lines
    from that point, zero where they all pass through it."""

    rays_1: object
    rays_2: object
    centre: np.ndarray
    spread: float

    def of(self, which):
        """Those pairs that an index or a mask (N,) selects; centre and spread stay."""
        return self._replace(rays_1=self.rays_1.of(which), rays_2=self.rays_2.of(which))

    def whole(self, R, u):
        """T_2_1 (4, 4) in the camera's frame of a motion R, u about the centre."""
        return pose(R, u + self.centre - R @ self.centre)

    def about_centre(self, T_2_1):
        """(R, u) of a motion (4, 4) in the camera's frame."""
        T = np.asarray(T_2_1, float)
        R = T[:3, :3]
        return R, T[:3, 3] - self.centre + R @ self.centre


def matched_rays(rays_1, rays_2, *, about=None, fewest=FEWEST):
    """MatchedRays of two equal sets; about: (3,), else the point next to all rays.

    rays: NoisyRays, or as for `angular_rays`. Raises CalibrationError for sets that do
    not match or have fewer than `fewest` pairs, and rays that are not finite.
    """
    rays_1, rays_2 = with_noise(rays_1), with_noise(rays_2)
    count = len(rays_1.origins)
    if count != len(rays_2.origins):
        raise CalibrationError(
            f"motion: {count} rays and {len(rays_2.origins)} rays; give as many of"
            " both",
            code="shape",
        )
    if count < fewest:
        raise CalibrationError(
            f"motion: {count} pairs of rays; {fewest} or more are needed",
            code="too-few-rays",
        )
    different = _different(rays_1, rays_2)
    if different < min(count, fewest + 1):
        raise CalibrationError(
            f"motion: only {different} of {count} pairs of rays differ, the others are "
            f"repeated; more than {fewest} different ones are needed",
            code="degenerate-points",
        )
    o, d = (
        np.concatenate([getattr(rays, name) for rays in (rays_1, rays_2)])
        for name in ("origins", "directions")
    )
    both = Rays(o, d, np.ones(2 * count, bool))
    centre = closest_point(both) if about is None else np.asarray(about, float)
    spread = centrality(both)
    reach = np.abs(o).max() + np.abs(centre).max()
    if spread <= ONE_POINT * reach:
        spread = 0.0
    return MatchedRays(rays_1.moved(centre), rays_2.moved(centre), centre, spread)


def _different(rays_1, rays_2):
    """How many of the pairs are not the same as another one."""
    pairs = np.column_stack([*rays_1[:2], *rays_2[:2]])
    return len(np.unique(pairs, axis=0))


def checked_motion(T_2_1):
    """A motion (4, 4) as floats; CalibrationError for what is no rotation and shift."""
    T = np.asarray(T_2_1, float)
    if T.shape != (4, 4) or not are_rotations(T[:3, :3]):
        raise CalibrationError(
            f"motion: the start {T.shape} is none; give (4, 4), a rotation and a shift",
            code="shape",
        )
    return T


def are_rotations(R):
    """Whether matrices (..., 3, 3) are finite, and rotations to within rounding."""
    R = np.asarray(R, float)
    if not np.isfinite(R).all():
        return False
    off = np.abs(R @ np.swapaxes(R, -1, -2) - np.eye(3)).max(initial=0)
    return bool(off < ORTHOGONAL and np.all(np.linalg.det(R) > 0))


def gaps(R, u, pairs):
    """g / s (N,): by how many standard deviations pairs miss each other; with sign."""
    return _Gap(R, u, pairs).residuals


def gap_system(R, u, pairs):
    """`gaps` (N,) and their Jacobian (N, 6).

    The motion moves as `moved_motion`: exp([w]x) R about the centre, u + v; columns w,
    v.
    """
    gap = _Gap(R, u, pairs)
    return gap.residuals, gap.jacobian()


def moved_motion(state, step):
    """The motion (R, u) after a step (6,): exp([w]x) R, and u + v."""
    R, u = state
    return rotation_from_vector(step[:3]) @ R, u + step[3:]


def along_sphere(u):
    """Steps of a motion whose u keeps its length: D (6, 5), step = D y."""
    D = np.zeros((6, 5))
    D[:3, :3] = np.eye(3)
    D[3:, 3:] = tangent_bases((u / np.linalg.norm(u))[None])[0]
    return D


def depths_of_pairs(R, u, pairs):
    """Where matched rays pass nearest to each other: (N, 2), mm from their origins.

    Negative behind the origins, infinite or NaN for parallel rays.
    """
    (p_1, d_1, _), (p_2, d, _) = pairs.rays_1, pairs.rays_2
    q, b = d_1 @ R.T, p_1 @ R.T + u - p_2
    cosine = np.einsum("ni,ni->n", q, d)
    qb, db = np.einsum("ni,ni->n", q, b), np.einsum("ni,ni->n", d, b)
    with np.errstate(divide="ignore", invalid="ignore"):
        sine = np.einsum("ni,ni->n", *2 * [np.cross(q, d)])
        return np.stack([cosine * db - qb, db - cosine * qb], axis=1) / sine[:, None]


def share_ahead(R, u, pairs):
    """Share of the pairs that pass nearest to each other ahead of both origins."""
    if not len(pairs.rays_1.origins):
        return 0.0
    return float(np.mean(np.all(depths_of_pairs(R, u, pairs) > 0, axis=1)))


class _Gap:
    """One motion's gaps; derivatives are triple products of what is kept here."""

    def __init__(self, R, u, pairs):
        (p_1, d_1, C_1), (p_2, self.d, C_2) = pairs.rays_1, pairs.rays_2
        self.q, self.arm = d_1 @ R.T, p_1 @ R.T
        self.b = self.arm + u - p_2
        self.n = np.cross(self.q, self.d)
        self.m_1, self.m_2 = np.cross(self.d, self.b), np.cross(self.b, self.q)
        self.g = np.einsum("ni,ni->n", self.n, self.b)
        # What noise of each ray's (origin, direction) does to g, and C times that.
        by_1 = np.concatenate([self.n @ R, self.m_1 @ R], axis=1)
        by_2 = np.concatenate([-self.n, self.m_2], axis=1)
        self.h_1, self.h_2 = (
            np.einsum("nij,nj->ni", C, by) for C, by in ((C_1, by_1), (C_2, by_2))
        )
        variance = np.einsum("ni,ni->n", by_1, self.h_1)
        variance += np.einsum("ni,ni->n", by_2, self.h_2)
        self.variance = np.maximum(variance, LEAST_VARIANCE)
        self.residuals = self.g / np.sqrt(self.variance)
        self.R = R

    def jacobian(self):
        """(N, 6), of residuals by (w, v)."""
        q, d, b = self.q, self.d, self.b
        o_1, t_1 = self.h_1[:, :3] @ self.R.T, self.h_1[:, 3:] @ self.R.T
        o_2, t_2 = self.h_2[:, :3], self.h_2[:, 3:]
        # Half the variance by q and by b, and by the turn of the first view's noise.
        by_q = np.cross(d, o_1 - o_2) + np.cross(t_2, b)
        by_b = np.cross(t_1, d) + np.cross(q, t_2)
        turn = np.cross(o_1, self.n) + np.cross(t_1, self.m_1)
        half = self._by_motion(by_q, by_b)
        half[:, :3] += turn
        by_g = self._by_motion(self.m_1, self.n)
        s = np.sqrt(self.variance)[:, None]
        return by_g / s - (self.g[:, None] / s**3) * half

    def _by_motion(self, by_q, by_b):
        """Derivatives (N, 6) by (w, v) of what changes so by q and b."""
        w = np.cross(self.q, by_q) + np.cross(self.arm, by_b)
        return np.concatenate([w, by_b], axis=1)
