"""Motion of a general camera from matched rays, least squares, with its length.

The residuals are the gaps between the rays of each pair, in standard deviations. Rays
that miss their common centre determine the length of the motion (thesis 5.3.5), with
the uncertainty `GeneralisedPose.scale_sd`. Otherwise the length must be given.

T_2_1 maps points of view 1 to view 2, X_2 = R X_1 + t, both in the frame of the camera;
mm.

Source: Pless 2003, doi:10.1109/CVPR.2003.1211520 (motion of rays without a centre).
"""

from __future__ import annotations

from math import comb
from typing import NamedTuple

import numpy as np
from numpy.typing import ArrayLike, NDArray
from scipy.special import bdtrc

from raxel.cameras.core.base import Rays
from raxel.errors import CalibrationError
from raxel.geometry.homography import best_hypothesis, checked_generator
from raxel.geometry.least_squares import descend, gauss_newton
from raxel.geometry.poses import tangent_bases
from raxel.multiview.motion_samples import (
    SAMPLE_SIZE,
    best_turn,
    sampled_motions,
    settled,
    squared_gaps,
    turning_pairs,
)
from raxel.multiview.ray_noise import (
    COINCIDENCE_TOL,
    MIN_N_POSE_PAIRS,
    NoisyRays,
    along_sphere,
    checked_motion,
    depths_of_pairs,
    gap_system,
    gaps,
    matched_rays,
    moved_motion,
    share_ahead,
)

# Information of matched rays on a motion: rotation, direction, and length. Rays through
# one point do not determine the length. The nearer a camera is to central, the less
# they do. The Fisher information of the rays predicts the precision before any
# estimate, as the lower bound of the standard deviations of unbiased methods. The six
# parameters are a rotation w (3) about the rays' centre, a rotation of the direction in
# which the centre moves (2), and the logarithm of its distance (1): all radians or
# relative values, so that their eigenvalues are comparable.


# Smaller eigenvalues, relative to the largest, count as zero; this limits the standard
# deviations.
MIN_EIGENVALUE_RATIO = 1e-15
# Maximum standard deviation of the inverse length, over that value, of a determined
# length: three standard deviations.
MAX_SCALE_SD_RATIO = 1 / 3


class MotionInformation(NamedTuple):
    """Fisher information of matched rays about a motion.

    Attributes
    ----------
    information : ndarray of shape (6, 6)
        Information about (w, direction, log length).
    baseline : float
        Distance by which the centre of the rays moves, mm.
    centre : ndarray of shape (3,)
        Centre of the rays, frame of view 1, mm.
    spread : float
        RMS distance of the rays from the centre, mm.
    """

    information: np.ndarray
    baseline: float
    centre: np.ndarray
    spread: float

    @property
    def covariance(self) -> NDArray[np.float64]:
        """Cramer-Rao bound, shape (6, 6), all six parameters unknown."""
        return inverse_information(self.information)

    @property
    def rotation_sd(self) -> float:
        """Root of the summed variances of the three rotations, rad."""
        return _root(self.covariance, slice(0, 3))

    @property
    def direction_sd(self) -> float:
        """Standard deviation of the direction of motion, both axes together, rad."""
        return _root(self.covariance, slice(3, 5))

    @property
    def scale_sd(self) -> float:
        """Standard deviation of the length of the motion, as a share of that length."""
        return _root(self.covariance, slice(5, 6))

    @property
    def scale_determined(self) -> bool:
        """Whether the rays determine the length to better than a third of itself."""
        return self.scale_sd < MAX_SCALE_SD_RATIO

    def __str__(self):
        length = "determined" if self.scale_determined else "undetermined"
        return (
            f"rotation to {np.degrees(self.rotation_sd):.2g} deg, direction to"
            f" {np.degrees(self.direction_sd):.2g} deg, length {length}: to"
            f" {100 * self.scale_sd:.2g} % of {self.baseline:.3g} mm"
        )


def motion_information(
    T_2_1: ArrayLike,
    rays_1: NoisyRays | Rays,
    rays_2: NoisyRays | Rays,
    *,
    about: ArrayLike | None = None,
) -> MotionInformation:
    """Return the information of matched rays with noise about a motion.

    Rays of a scene without noise give the precision that any method may expect. The
    noise of different rays is taken as independent: calibration errors are not
    included.

    Parameters
    ----------
    T_2_1 : array_like of shape (4, 4)
        Motion from view 1 to view 2, mm.
    rays_1, rays_2 : NoisyRays or Rays
        Matched rays (N,) with their noise. Rays without noise are treated as by
        `angular_rays`, with a noise of 1 rad.
    about : array_like of shape (3,), optional
        Centre of the rays, mm. None: the point nearest to all rays.

    Returns
    -------
    MotionInformation
        Information and the standard deviations that follow from it.

    Raises
    ------
    CalibrationError
        As `matched_rays`, and with code ``no-translation`` for a stationary centre.
    """
    pairs = matched_rays(rays_1, rays_2, about=about, fewest=1)
    R, u = pairs.about_centre(checked_motion(T_2_1))
    if not np.linalg.norm(u) > COINCIDENCE_TOL * np.abs(pairs.rays_1.origins).max():
        raise CalibrationError(
            "motion: the rays' centre does not move (no direction or length); give "
            "another centre with about=",
            code="no-translation",
        )
    J = gap_system(R, u, pairs)[1]
    D = polar_steps(u)
    return MotionInformation(
        D.T @ (J.T @ J) @ D, float(np.linalg.norm(u)), pairs.centre, pairs.spread
    )


def polar_steps(u):
    """D (6, 6): steps (w, v) of a motion by (w, direction, log length)."""
    length = np.linalg.norm(u)
    D = np.zeros((6, 6))
    D[:3, :3] = np.eye(3)
    D[3:, 3:5] = length * tangent_bases((u / length)[None])[0]
    D[3:, 5] = u
    return D


def inverse_information(information):
    """Its inverse (p, p); undetermined parameters get a very large variance."""
    scale = np.sqrt(np.maximum(np.diag(information), 1e-300))
    values, V = np.linalg.eigh(information / np.outer(scale, scale))
    values = np.maximum(values, MIN_EIGENVALUE_RATIO * values[-1])
    return (V / values) @ V.T / np.outer(scale, scale)


def _root(covariance, which):
    return float(np.sqrt(np.trace(covariance[which, which])))


COST_TOL = 1e-12  # relative decrease of the sum of squares at convergence
ROUNDING_RAD = 1e-15  # residuals of exact pairs


class GeneralisedPose(NamedTuple):
    """Motion between two views of a general camera.

    Attributes
    ----------
    T_2_1 : ndarray of shape (4, 4)
        Motion X_2 = R X_1 + t, mm.
    inliers : ndarray of shape (N,)
        Pairs that the motion was found from, bool.
    rms : float
        RMS of the `gaps` of the inliers, in standard deviations of the rays, or rad if
        these are unknown.
    ahead : float
        Share of the inliers that meet ahead along both rays.
    covariance : ndarray of shape (6, 6)
        Covariance of (w, v): the motion is exp([w]x) R about `centre`, and the shift of
        the centre u + v. It follows from the scatter of the gaps. NaN if there are no
        more pairs than unknowns; zero along u if the length was given.
    centre : ndarray of shape (3,)
        Centre of the rays, mm.
    spread : float
        RMS distance of the rays from the centre, mm.
    """

    T_2_1: np.ndarray
    inliers: np.ndarray
    rms: float
    ahead: float
    covariance: np.ndarray
    centre: np.ndarray
    spread: float

    @property
    def shift(self) -> NDArray[np.float64]:
        """Shift u of the rays' centre, shape (3,), frame of view 2, mm."""
        T = self.T_2_1
        return T[:3, 3] - self.centre + T[:3, :3] @ self.centre

    @property
    def baseline(self) -> float:
        """Distance by which the rays' centre moves, mm."""
        return float(np.linalg.norm(self.shift))

    @property
    def scale_sd(self) -> float:
        """Standard deviation of the length of the motion, as a share of that length.

        It is 0 if the length was given.
        """
        along = self.shift / self.baseline
        variance = max(along @ self.covariance[3:, 3:] @ along, 0.0)
        return float(np.sqrt(variance) / self.baseline)

    @property
    def rotation_sd(self) -> float:
        """Root of the summed variances of the three rotations, rad."""
        return float(np.sqrt(np.trace(self.covariance[:3, :3])))

    @property
    def scale_determined(self) -> bool:
        """Whether the length is determined to better than a third of itself."""
        return self.scale_sd < MAX_SCALE_SD_RATIO


def refine_generalised_pose(
    rays_1: NoisyRays | Rays,
    rays_2: NoisyRays | Rays,
    start: GeneralisedPose | ArrayLike,
    *,
    length: float | None = None,
    most: int = 50,
) -> GeneralisedPose:
    """Find the motion that minimises the sum of squared `gaps`.

    Levenberg-Marquardt on se(3) with an analytic Jacobian.

    Parameters
    ----------
    rays_1, rays_2 : NoisyRays or Rays
        Matched rays (N,) of both views, N >= 6 correct pairs, in the camera frame. Rays
        without noise are treated as by `angular_rays`: residuals are then in rad.
    start : GeneralisedPose or array_like of shape (4, 4)
        Start of T_2_1, mm. Inliers of a GeneralisedPose are used if their number is
        that of the pairs.
    length : float, optional
        Length of the shift of the rays' centre if it is known, mm. Rays that all pass
        through one point require it.
    most : int
        Maximum number of iterations.

    Returns
    -------
    GeneralisedPose
        The motion with its covariance.

    Raises
    ------
    CalibrationError
        As `matched_rays`; code ``no-scale`` for rays through one point without a
        length, ``length`` for an invalid length, ``too-few-rays`` for fewer than six
        inliers.
    """
    pairs = matched_rays(rays_1, rays_2)
    inliers = np.ones(len(pairs.rays_1.origins), bool)
    T = start
    if isinstance(start, GeneralisedPose):
        T = start.T_2_1
        if len(start.inliers) == len(inliers):
            inliers = start.inliers
    R, u = pairs.about_centre(checked_motion(T))  # type: ignore[arg-type]
    return adjusted(pairs, inliers, R, u, length, most)


def adjusted(pairs, inliers, R, u, length=None, most=50):
    """GeneralisedPose from a start R, u about the centre of all MatchedRays."""
    check_length(pairs, length)
    used = pairs.of(inliers)
    if np.count_nonzero(inliers) < MIN_N_POSE_PAIRS:
        raise CalibrationError(
            f"motion: found {np.count_nonzero(inliers)} inliers of {len(inliers)} "
            f"pairs; give {MIN_N_POSE_PAIRS} or more",
            code="too-few-rays",
        )
    if length is not None:
        u = to_length(u, length)

    def steps(state):
        return np.eye(6) if length is None else along_sphere(state[1])

    def evaluate(state):
        residuals, jacobian = gap_system(*state, used)
        return gauss_newton(residuals, lambda: jacobian @ steps(state))

    def move(state, step):
        R, u = moved_motion(state, steps(state) @ step)
        return R, u if length is None else to_length(u, length)

    smallest = min(rays.pivots()[1].min() for rays in (used.rays_1, used.rays_2))
    (R, u), _, _ = descend(
        evaluate,
        move,
        (R, u),
        iterations=most,
        tolerance=COST_TOL,
        rounding=len(used.rays_1.origins) * (ROUNDING_RAD / smallest) ** 2,
    )
    residuals, jacobian = gap_system(R, u, used)
    free = steps((R, u))
    J = jacobian @ free
    freedom = len(residuals) - J.shape[1]
    variance = residuals @ residuals / freedom if freedom > 0 else np.nan
    known = variance * inverse_information(J.T @ J)
    return GeneralisedPose(
        pairs.whole(R, u),
        inliers,
        float(np.sqrt(np.mean(residuals**2))),
        share_ahead(R, u, used),
        free @ known @ free.T,
        pairs.centre,
        pairs.spread,
    )


def check_length(pairs, length):
    """Reject rays through one point without a length, and an invalid length."""
    if length is None and not pairs.spread:
        raise CalibrationError(
            "motion: all rays pass through one point (undetermined length); give the "
            "length, or use raxel.multiview.motion_samples",
            code="no-scale",
        )
    if length is not None and not (np.isfinite(length) and length > 0):
        raise CalibrationError(
            f"motion: length: found {length}; give a value above 0 mm", code="length"
        )


def to_length(u, length):
    """u (3,) scaled to a length; along z if u is zero."""
    norm = np.linalg.norm(u)
    return u * (length / norm) if norm > 0 else np.array([0.0, 0.0, length])


# Motion of a general camera from matched rays with outliers. Small samples give motions
# (`motion_samples`); the best one is refitted to its inliers until they no longer
# change. A sample of eight needs no initial value. Nearly central rays in a small field
# can exchange a rotation for a shift, so the result is refined from other shifts as
# well. Source: Fischler and Bolles 1981, doi:10.1145/358669.358692.


BATCH, MAX_N_ROUNDS = 64, 20
N_HELD_SCALE_STEPS, N_FREE_SCALE_STEPS = 12, 6
MAX_BEHIND_FRACTION = 0.05  # pairs that meet in front of their origins
MAX_N_REMATCHES = 8  # random matchings, for the number of chance inliers


def generalised_pose_ransac(
    rays_1: NoisyRays | Rays,
    rays_2: NoisyRays | Rays,
    rng: np.random.Generator,
    threshold: float,
    *,
    length: float | None = None,
    confidence: float = 0.999,
    most_trials: int = 2000,
) -> GeneralisedPose:
    """Find a motion from matched rays of a general camera, some of them wrong.

    Samples are drawn until one without a wrong pair has been met with probability
    `confidence`. The motion is then refined.

    Parameters
    ----------
    rays_1, rays_2 : NoisyRays or Rays
        Matched rays (N,) of both views, in the camera frame. Rays without noise are
        treated as by `angular_rays`: residuals are then in rad.
    rng : numpy.random.Generator
        Random numbers of the samples.
    threshold : float
        Largest of the `gaps` of a correct pair, in standard deviations of the rays, or
        rad if these are unknown.
    length : float, optional
        Length of the shift of the rays' centre if it is known, mm.
    confidence : float
        Probability of a sample without a wrong pair.
    most_trials : int
        Maximum number of samples.

    Returns
    -------
    GeneralisedPose
        The refined motion and its inliers.

    Raises
    ------
    CalibrationError
        As `matched_rays`; code ``no-scale`` for rays through one point without a
        length. ``too-many-outliers`` for fewer than eight correct pairs, or no more of
        them than arise by chance. ``no-translation`` for pairs that a rotation explains
        as well.

    References
    ----------
    Fischler and Bolles 1981, doi:10.1145/358669.358692.
    """
    checked_generator("motion", rng)
    pairs = matched_rays(rays_1, rays_2, fewest=SAMPLE_SIZE)
    check_length(pairs, length)
    turning = turning_pairs(pairs)

    def propose(batch):
        keys = rng.random((batch, len(pairs.rays_1.origins)))
        picks = np.argpartition(keys, SAMPLE_SIZE - 1, axis=1)[:, :SAMPLE_SIZE]
        return _stacked(
            *sampled_motions(turning.of(picks), pairs.spread, threshold, length)
        )

    def errors(motions):
        return squared_gaps(*_parted(motions), turning, threshold)

    best = best_hypothesis(
        propose,
        errors,
        threshold**2,
        sample_size=SAMPLE_SIZE,
        confidence=confidence,
        most_trials=most_trials,
        batch=BATCH,
    )
    if best is None:
        raise CalibrationError(
            "motion: no sample of pairs agrees with a motion; check the matches, or "
            "increase the threshold",
            code="too-many-outliers",
        )
    right = _check_inliers(errors(best[None])[0] < threshold**2)
    _check_chance(best, turning, right, threshold, most_trials)
    _check_rotation(turning, right, threshold)
    tried = _from_other_shifts(best, turning, right, length)
    cost = np.minimum(errors(tried), threshold**2).sum(axis=1)
    (R,), (u,) = _parted(tried[np.argmin(cost)][None])
    return _with_its_inliers(pairs, turning, R, u, length, threshold)


def _with_its_inliers(pairs, turning, R, u, length, threshold):
    """GeneralisedPose after fits to inliers until they no longer change."""
    right, determined = None, False
    for _ in range(MAX_N_ROUNDS):
        ahead = np.isfinite(squared_gaps(R[None], u[None], turning, threshold)[0])
        now = ahead & (np.abs(gaps(R, u, pairs)) < threshold)
        short = _before_origins(R, u, pairs)
        # With a determined length, few such points are outliers; many would be inliers
        # of a motion that is too short.
        if determined and short[now].sum() < MAX_BEHIND_FRACTION * now.sum():
            now &= ~short
        if np.array_equal(now, right):
            break
        right = _check_inliers(now)
        found = adjusted(pairs, right, R, u, length)
        determined = found.scale_determined
        R, u = pairs.about_centre(found.T_2_1)
    return found


def _before_origins(R, u, pairs):
    """Which pairs (N,) meet between the pivot and the origin of a ray."""
    depths = depths_of_pairs(R, u, pairs)
    back = [
        np.einsum("ni,ni->n", rays.origins - rays.pivots()[0], rays.directions)
        for rays in (pairs.rays_1, pairs.rays_2)
    ]
    return np.any((depths < 0) & (depths > -np.stack(back, axis=1)), axis=1)


def _from_other_shifts(best, turning, right, length):
    """Motions (M, 3, 4): the best one, and those that converge on the inliers (N,) from
    it and from the best pure rotation: with its length, then, for an unknown length,
    with a free one."""
    own = turning.of(np.flatnonzero(right)[None])
    (R,), (u,) = _parted(best[None])
    far = np.linalg.norm(u)
    shifts = np.concatenate([u[None], far * np.eye(3), -far * np.eye(3)])
    turn = best_turn(own.d_1, own.d_2)
    held = settled(
        np.concatenate([R[None], *6 * [turn]]), shifts, own, far, N_HELD_SCALE_STEPS
    )
    found = [best[None], _stacked(*held)]
    if length is None:
        found.append(_stacked(*settled(*held, own, steps=N_FREE_SCALE_STEPS)))
    return np.concatenate(found)


def _check_chance(best, turning, right, threshold, most_trials):
    """Reject a motion that fits randomly rematched pairs nearly as often.

    Source: Moisan and Stival 2004, doi:10.1023/B:VISI.0000013094.38752.54 (number of
    equally good samples under the null hypothesis).
    """
    count, some = len(right), np.count_nonzero(right)
    second = turning._fields[3:]
    agree = [
        squared_gaps(
            *_parted(best[None]),
            turning._replace(
                **{f: np.roll(getattr(turning, f), k, axis=-1) for f in second}
            ),
            threshold,
        )
        < threshold**2
        for k in range(1, min(MAX_N_REMATCHES, count - 1) + 1)
    ]
    by_chance = (np.sum(agree) + 1) / (np.size(agree) + 1)
    samples = min(most_trials, comb(count, SAMPLE_SIZE))
    # Six pairs always fit.
    as_good = bdtrc(some - MIN_N_POSE_PAIRS - 1, count - MIN_N_POSE_PAIRS, by_chance)
    if samples * as_good > 1:
        raise CalibrationError(
            f"motion: {some} of {count} pairs agree with one motion, as many as by "
            "chance; check the matches, or reduce the threshold",
            code="too-many-outliers",
        )


def _check_rotation(turning, right, threshold):
    """Reject a pure rotation about the centre, which determines no shift."""
    own = turning.of(np.flatnonzero(right)[None])
    turn = best_turn(own.d_1, own.d_2)
    errors = np.linalg.norm(np.einsum("mij,jmk->imk", turn, own.d_1) - own.d_2, axis=0)
    if np.all(errors < threshold * np.hypot(own.sd_1, own.sd_2)):
        raise CalibrationError(
            f"motion: a pure rotation explains all {np.count_nonzero(right)} inliers; "
            "use a longer baseline, or a smaller threshold",
            code="no-translation",
        )


def _check_inliers(right):
    if np.count_nonzero(right) < SAMPLE_SIZE:
        raise CalibrationError(
            f"motion: at most {np.count_nonzero(right)} of {len(right)} pairs agree "
            f"with a motion; give {SAMPLE_SIZE} or more correct pairs",
            code="too-many-outliers",
        )
    return right


def _stacked(R, u):
    return np.concatenate([R, u[:, :, None]], axis=2)


def _parted(motions):
    return motions[:, :, :3], motions[:, :, 3]
