"""Noise of rays, and the gaps between matched rays.

Rays (p_1, d_1) and (p_2, d_2) of two views meet under X_2 = R X_1 + t where

    g = (q x d_2) . b = 0,   q = R d_1,   b = R p_1 + t - p_2,

which is (5.30) written out. Its first-order standard deviation s follows from the rays'
noise; g / s is the residual (Sampson's error): its square is the least sum of squares,
in standard deviations, of shifts of origins and directions of a pair until it meets.
For a central camera that is `epipolar.epipolar_angles`. Unweighted distances would
favour a small scene.

Both views have the same frame except for the motion. The motion is relative to a point
c of that frame, its `centre`: X_2 - c = R (X_1 - c) + u, with t = u + c - R c. For a
bent mirror the frame's origin is far from the rays' origins, and a rotation about it
would resemble a shift.
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.cameras.core.base import Camera, Rays, centrality, closest_point
from raxel.errors import CalibrationError
from raxel.geometry.poses import pose, rotation_from_vector, tangent_bases

# Rays with uncertain direction and position. The effect of image noise on a ray depends
# on the camera. In a central one the ray rotates about the centre; with a bent mirror
# it rotates about a point of the caustic, a different one in each direction. Both are a
# covariance of origin and direction. Frame: the camera's; mm, rad.


STEP_PX = 0.25  # for derivatives of a camera's rays
UNIT_NORM_TOL = 1e-6  # error of a unit direction's length
MAX_ORIGIN_MM = 1e15


class NoisyRays(NamedTuple):
    """Rays with the covariance of their origins and directions.

    Only the covariance across the ray matters. An origin may slide along its ray
    together with its covariance without any effect.

    Attributes
    ----------
    origins : ndarray of shape (N, 3)
        Origins, mm.
    directions : ndarray of shape (N, 3)
        Unit directions.
    covariance : ndarray of shape (N, 6, 6)
        Covariance of (origin, direction), mm and rad.
    """

    origins: np.ndarray
    directions: np.ndarray
    covariance: np.ndarray

    def of(self, which: np.ndarray | slice) -> NoisyRays:
        """Return the rays that an index or a mask (N,) selects."""
        return NoisyRays(*(field[which] for field in self))

    def moved(self, shift: NDArray[np.float64]) -> NoisyRays:
        """Return the rays in a frame with origin `shift` (3,) and the same axes."""
        return self._replace(origins=self.origins - shift)

    def slid(self, along: NDArray[np.float64]) -> NoisyRays:
        """Return the same rays with origins moved by `along` (N,) mm along them."""
        slide = np.broadcast_to(np.eye(6), (len(along), 6, 6)).copy()
        slide[:, [0, 1, 2], [3, 4, 5]] = along[:, None]
        C = slide @ self.covariance @ np.swapaxes(slide, 1, 2)
        o = self.origins + along[:, None] * self.directions
        return self._replace(origins=o, covariance=C)

    def pivots(self) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """(points (N, 3), sd (N,)): pivot of each ray, and its angular noise there.

        Isotropic rotation about one point of the ray that is closest to its noise. sd:
        rad, along one axis. Raises CalibrationError for rays with parallel shifts only,
        as in an orthographic camera.
        """
        C = self.covariance
        turn = np.trace(C[:, 3:, 3:], axis1=1, axis2=2)
        if not np.all(turn > 0):
            raise CalibrationError(
                f"rays: {np.count_nonzero(~(turn > 0))} of {len(turn)} have no angular "
                "noise (orthographic camera); give angular_rays"
            )
        along = -np.trace(C[:, :3, 3:], axis1=1, axis2=2) / turn
        return self.origins + along[:, None] * self.directions, np.sqrt(turn / 2)


def angular_rays(rays, sd=1.0, *, about=None):
    """NoisyRays with isotropic angular noise, as those of a central camera.

    rays: object with origins (N, 3) and unit directions (N, 3), such as the `Rays` of a
    camera; sd: rad, (N,) or one, of each of a direction's two components. If it is
    unknown, keep the default: residuals are then radians. about: (3,), each ray rotates
    about its point closest to this one; default: the point closest to all rays. Raises
    CalibrationError for rays that are not finite or directions that are not unit.
    """
    o, d = checked_rays(rays)
    if len(o) == 0:
        raise CalibrationError("rays: found none; give pixels that have a ray")
    if about is not None and not _finite(about, (3,)):
        raise CalibrationError("rays: about: invalid; give three finite numbers, mm")
    if np.shape(sd) not in ((), (len(o),)):
        raise CalibrationError(
            f"rays: standard deviations: found shape {np.shape(sd)} for {len(o)} rays; "
            "give one, or one for each"
        )
    if about is None:
        about = closest_point(Rays(o, d, np.ones(len(o), bool)))
    back = np.einsum("ni,ni->n", o - np.asarray(about, float), d)[:, None, None]
    sd = np.broadcast_to(np.asarray(sd, float), len(o))
    if not np.all((sd > 0) & np.isfinite(sd)):
        raise CalibrationError(
            "rays: standard deviations: invalid; give values finite and above 0"
        )
    across = sd[:, None, None] ** 2 * (np.eye(3) - d[:, :, None] * d[:, None, :])
    C = np.block([[back**2 * across, back * across], [back * across, across]])
    return NoisyRays(o, d, C)


def rays_of_pixels(
    camera: Camera, pixels: ArrayLike, sd_px: ArrayLike = 1.0
) -> NoisyRays:
    """Return the rays that a camera has for pixels with noise.

    The noise is propagated through the camera: origin and direction move together with
    the pixel.

    Parameters
    ----------
    camera : Camera
        Any camera.
    pixels : array_like of shape (N, 2)
        Pixels, px.
    sd_px : float or array_like of shape (N,)
        Standard deviation of each coordinate, px.

    Returns
    -------
    NoisyRays
        Rays (N,) in the camera frame with their covariances.

    Raises
    ------
    CalibrationError
        For pixels without a ray, including positions a quarter of a pixel next to them.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.cameras import PerspectiveCamera
    >>> from raxel.multiview import rays_of_pixels
    >>> K = np.array([[500, 0, 320], [0, 500, 240], [0, 0, 1.0]])
    >>> camera = PerspectiveCamera(K, [], 640, 480)
    >>> rays = rays_of_pixels(camera, [[320, 240]], sd_px=0.5)
    >>> round(float(np.sqrt(rays.covariance[0, 3, 3])), 6)
    0.001
    """
    pixels = np.asarray(pixels, float)
    if pixels.ndim != 2 or pixels.shape[1] != 2:
        raise CalibrationError(f"rays: found pixels {pixels.shape}; give (N, 2)")
    if np.shape(sd_px) not in ((), (len(pixels),)) or not np.all(
        np.isfinite(sd_px) & (np.asarray(sd_px) > 0)
    ):
        raise CalibrationError(
            f"rays: standard deviations: found shape {np.shape(sd_px)} for "
            f"{len(pixels)} pixels; give one, or one for each, finite and above 0"
        )
    steps = STEP_PX * np.array([[0, 0], [1, 0], [-1, 0], [0, 1], [0, -1]])
    rays = camera.rays((pixels + steps[:, None]).reshape(-1, 2))
    lines = np.concatenate([rays.origins, rays.directions], axis=1)
    middle, *sides = lines.reshape(5, -1, 6)
    seen = rays.valid.reshape(5, -1).all(axis=0)
    if not seen.all():
        raise CalibrationError(
            f"rays: {np.count_nonzero(~seen)} of {len(pixels)} pixels, or positions a "
            "quarter of a pixel from them, have no ray; exclude these"
        )
    by_u, by_v = sides[0] - sides[1], sides[2] - sides[3]
    J = np.stack([by_u, by_v], axis=2) / (2 * STEP_PX)
    J = J * np.broadcast_to(np.asarray(sd_px, float), len(pixels))[:, None, None]
    return NoisyRays(middle[:, :3], middle[:, 3:], J @ np.swapaxes(J, 1, 2))


def with_noise(rays) -> NoisyRays:
    """Rays with their own noise if they have one, else as `angular_rays` of 1 rad."""
    if hasattr(rays, "covariance"):
        o, _ = checked_rays(rays)
        C = rays.covariance
        if not _finite(C, (len(o), 6, 6)) or np.any(np.einsum("nii->ni", C) < 0):
            raise CalibrationError(
                f"rays: covariance: found shape {np.shape(C)} for {len(o)} rays; give "
                "(N, 6, 6), finite, without negative variances"
            )
        return rays
    return angular_rays(rays)


def checked_rays(rays):
    """(origins, directions), (N, 3); CalibrationError where they are not finite."""
    if not (hasattr(rays, "origins") and hasattr(rays, "directions")):
        raise CalibrationError(
            f"rays: found {type(rays).__name__}; give the result of camera.rays(pixels)"
        )
    o, d = np.asarray(rays.origins, float), np.asarray(rays.directions, float)
    if o.ndim != 2 or o.shape[1] != 3 or o.shape != d.shape:
        raise CalibrationError(
            f"rays: found origins {o.shape} and directions {d.shape}; give two equal"
            " arrays (N, 3)"
        )
    bad = np.count_nonzero(~np.isfinite(o + d).all(axis=1))
    if bad:
        raise CalibrationError(
            f"rays: {bad} of {len(o)} are not finite; exclude pixels without a ray"
        )
    if len(d) and np.abs(np.linalg.norm(d, axis=1) - 1).max() > UNIT_NORM_TOL:
        raise CalibrationError("rays: directions are not of length 1; normalise them")
    if np.abs(o).max(initial=0) > MAX_ORIGIN_MM:
        raise CalibrationError(
            f"rays: found an origin at {np.abs(o).max():.3g} mm; give origins near the "
            "camera, mm"
        )
    return o, d


def _finite(values, shape):
    return np.shape(values) == shape and bool(np.isfinite(values).all())


COINCIDENCE_TOL = 1e-9  # distance from a common point, over the distances in the scene
MIN_N_POSE_PAIRS = 6  # for rotation and translation
ORTHOGONALITY_TOL = 1e-4  # largest entry of R R^T - I
# Lower bound for coincident origins; its powers must not overflow.
MIN_VARIANCE = 1e-90


class MatchedRays(NamedTuple):
    """Matched rays of two views about their common centre.

    Attributes
    ----------
    rays_1, rays_2 : NoisyRays
        Rays (N,) of the views, in a frame with its origin at `centre`.
    centre : ndarray of shape (3,)
        Centre of the rays in the camera frame, mm.
    spread : float
        RMS distance of the rays from the centre, mm; 0 if all pass through it.
    """

    rays_1: NoisyRays
    rays_2: NoisyRays
    centre: np.ndarray
    spread: float

    def of(self, which: np.ndarray | slice) -> MatchedRays:
        """Return the pairs that an index or mask (N,) selects, same centre."""
        return self._replace(rays_1=self.rays_1.of(which), rays_2=self.rays_2.of(which))

    def whole(
        self, R: NDArray[np.float64], u: NDArray[np.float64]
    ) -> NDArray[np.float64]:
        """Return T_2_1 (4, 4) in the camera frame of a motion R, u about the centre."""
        return pose(R, u + self.centre - R @ self.centre)

    def about_centre(
        self, T_2_1: ArrayLike
    ) -> tuple[NDArray[np.float64], NDArray[np.float64]]:
        """Return (R, u) about the centre of a motion (4, 4) in the camera frame."""
        T = np.asarray(T_2_1, float)
        R = T[:3, :3]
        return R, T[:3, 3] - self.centre + R @ self.centre


def matched_rays(
    rays_1: NoisyRays | Rays,
    rays_2: NoisyRays | Rays,
    *,
    about: ArrayLike | None = None,
    fewest: int = MIN_N_POSE_PAIRS,
) -> MatchedRays:
    """Return matched rays of two views about their common centre.

    Parameters
    ----------
    rays_1, rays_2 : NoisyRays or Rays
        Matched rays (N,) of both views. Rays without noise are treated as by
        `angular_rays`.
    about : array_like of shape (3,), optional
        Centre, mm. None: the point nearest to all rays.
    fewest : int
        Minimum number of pairs.

    Returns
    -------
    MatchedRays
        The rays of both views, with their centre and spread.

    Raises
    ------
    CalibrationError
        With code ``shape`` for sets of different size, ``too-few-rays``, or
        ``degenerate-points`` for repeated pairs; also for rays that are not finite.
    """
    rays_1, rays_2 = with_noise(rays_1), with_noise(rays_2)
    count = len(rays_1.origins)
    if count != len(rays_2.origins):
        raise CalibrationError(
            f"motion: found {count} and {len(rays_2.origins)} rays; give equal numbers",
            code="shape",
        )
    if count < fewest:
        raise CalibrationError(
            f"motion: found {count} pairs of rays; give {fewest} or more",
            code="too-few-rays",
        )
    different = _different(rays_1, rays_2)
    if different < min(count, fewest + 1):
        raise CalibrationError(
            f"motion: found {different} distinct of {count} pairs of rays; give more "
            f"than {fewest} distinct ones",
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
    if spread <= COINCIDENCE_TOL * reach:
        spread = 0.0
    return MatchedRays(rays_1.moved(centre), rays_2.moved(centre), centre, spread)


def _different(rays_1, rays_2):
    """Number of distinct pairs."""
    pairs = np.column_stack([*rays_1[:2], *rays_2[:2]])
    return len(np.unique(pairs, axis=0))


def checked_motion(T_2_1: ArrayLike) -> NDArray[np.float64]:
    """Motion (4, 4) as floats; CalibrationError for an invalid one."""
    T = np.asarray(T_2_1, float)
    if T.shape != (4, 4) or not are_rotations(T[:3, :3]):
        raise CalibrationError(
            f"motion: start: found no rigid motion ({T.shape}); give a rotation and a "
            "translation, (4, 4)",
            code="shape",
        )
    return T


def are_rotations(R):
    """Whether matrices (..., 3, 3) are finite, and rotations within rounding."""
    R = np.asarray(R, float)
    if not np.isfinite(R).all():
        return False
    errors = np.abs(R @ np.swapaxes(R, -1, -2) - np.eye(3)).max(initial=0)
    return bool(errors < ORTHOGONALITY_TOL and np.all(np.linalg.det(R) > 0))


def gaps(
    R: NDArray[np.float64], u: NDArray[np.float64], pairs: MatchedRays
) -> NDArray[np.float64]:
    """Return by how many standard deviations the rays of each pair miss each other.

    Parameters
    ----------
    R : ndarray of shape (3, 3)
        Rotation of the motion.
    u : ndarray of shape (3,)
        Shift of the rays' centre, mm.
    pairs : MatchedRays
        N pairs of rays.

    Returns
    -------
    ndarray of shape (N,)
        Residuals g / s with sign (Sampson error).

    References
    ----------
    Thesis (5.30).
    """
    return _Gap(R, u, pairs).residuals


def gap_system(R, u, pairs):
    """`gaps` (N,) and their Jacobian (N, 6).

    The motion changes as in `moved_motion`: exp([w]x) R about the centre, u + v;
    columns w, v.
    """
    gap = _Gap(R, u, pairs)
    return gap.residuals, gap.jacobian()


def moved_motion(state, step):
    """Motion (R, u) after a step (6,): exp([w]x) R, and u + v."""
    R, u = state
    return rotation_from_vector(step[:3]) @ R, u + step[3:]


def along_sphere(u):
    """Steps of a motion with a constant length of u: D (6, 5), step = D y."""
    D = np.zeros((6, 5))
    D[:3, :3] = np.eye(3)
    D[3:, 3:] = tangent_bases((u / np.linalg.norm(u))[None])[0]
    return D


def depths_of_pairs(R, u, pairs):
    """Closest points of matched rays: depths (N, 2), mm from their origins.

    Negative behind the origins, infinite or NaN for parallel rays.
    """
    (p_1, d_1, _), (p_2, d, _) = pairs.rays_1, pairs.rays_2
    q, b = d_1 @ R.T, p_1 @ R.T + u - p_2
    cosine = np.einsum("ni,ni->n", q, d)
    qb, db = np.einsum("ni,ni->n", q, b), np.einsum("ni,ni->n", d, b)
    with np.errstate(divide="ignore", invalid="ignore"):
        sine = np.einsum("ni,ni->n", *2 * [_cross(q, d)])
        return np.stack([cosine * db - qb, db - cosine * qb], axis=1) / sine[:, None]


def share_ahead(R, u, pairs):
    """Share of the pairs whose closest points are in front of both origins."""
    if not len(pairs.rays_1.origins):
        return 0.0
    return float(np.mean(np.all(depths_of_pairs(R, u, pairs) > 0, axis=1)))


class _Gap:
    """Gaps of one motion; derivatives are triple products of the stored terms."""

    def __init__(self, R, u, pairs):
        (p_1, d_1, C_1), (p_2, self.d, C_2) = pairs.rays_1, pairs.rays_2
        self.q, self.arm = d_1 @ R.T, p_1 @ R.T
        self.b = self.arm + u - p_2
        self.n = _cross(self.q, self.d)
        self.m_1, self.m_2 = _cross(self.d, self.b), _cross(self.b, self.q)
        self.g = np.einsum("ni,ni->n", self.n, self.b)
        # Derivatives of g by each ray's (origin, direction), and C times these.
        by_1 = np.concatenate([self.n @ R, self.m_1 @ R], axis=1)
        by_2 = np.concatenate([-self.n, self.m_2], axis=1)
        self.h_1, self.h_2 = (
            np.einsum("nij,nj->ni", C, by) for C, by in ((C_1, by_1), (C_2, by_2))
        )
        variance = np.einsum("ni,ni->n", by_1, self.h_1)
        variance += np.einsum("ni,ni->n", by_2, self.h_2)
        self.variance = np.maximum(variance, MIN_VARIANCE)
        self.residuals = self.g / np.sqrt(self.variance)
        self.R = R

    def jacobian(self):
        """(N, 6), of residuals by (w, v)."""
        q, d, b = self.q, self.d, self.b
        o_1, t_1 = self.h_1[:, :3] @ self.R.T, self.h_1[:, 3:] @ self.R.T
        o_2, t_2 = self.h_2[:, :3], self.h_2[:, 3:]
        # Half the variance by q and by b, and by the rotation of the first noise.
        by_q = _cross(d, o_1 - o_2) + _cross(t_2, b)
        by_b = _cross(t_1, d) + _cross(q, t_2)
        turn = _cross(o_1, self.n) + _cross(t_1, self.m_1)
        half = self._by_motion(by_q, by_b)
        half[:, :3] += turn
        by_g = self._by_motion(self.m_1, self.n)
        s = np.sqrt(self.variance)[:, None]
        return by_g / s - (self.g[:, None] / s**3) * half

    def _by_motion(self, by_q, by_b):
        """Derivatives (N, 6) by (w, v) of a quantity with these ones by q and b."""
        w = _cross(self.q, by_q) + _cross(self.arm, by_b)
        return np.concatenate([w, by_b], axis=1)


def _cross(a, b):
    # Rows are short: numpy's cross product handles axes for longer than it computes.
    return a[:, [1, 2, 0]] * b[:, [2, 0, 1]] - a[:, [2, 0, 1]] * b[:, [1, 2, 0]]
