"""Motion of a general camera from matched rays of which some are wrong.

Small samples give motions (`motion_samples`), the best is followed by fits to its
inliers until they no longer change. A sample of eight needs no start from outside, but
rays that come near to one point, in a small field, leave it ways out: a turn for a
shift. So the end is tried from other shifts as well.
Source: Fischler and Bolles 1981, doi:10.1145/358669.358692.
"""

from math import comb

import numpy as np
from scipy.special import bdtrc

from raxel.errors import CalibrationError
from raxel.geometry.homography import best_hypothesis, checked_generator
from raxel.multiview.generalised_motion import adjusted, need_length
from raxel.multiview.motion_samples import (
    SAMPLE,
    best_turn,
    sampled_motions,
    settled,
    squared_gaps,
    turning_pairs,
)
from raxel.multiview.ray_gaps import FEWEST, depths_of_pairs, gaps, matched_rays

BATCH, ROUNDS = 64, 20
HELD_STEPS, FREED_STEPS = 12, 6
FEW = 0.05  # share of pairs that meet before their origins
REMATCHED = 8  # times that pairs are matched anew, for what agrees by chance


def generalised_pose_ransac(
    rays_1, rays_2, rng, threshold, *, length=None, confidence=0.999, most_trials=2000
):
    """Motion from matched rays of a general camera, some of them wrong.

    rays: NoisyRays (N,), or as for `angular_rays`; rng: numpy Generator; threshold: the
    largest of `gaps` of a right pair: in standard deviations where the rays know
    theirs, else radians. length: mm, of the shift of the rays' centre where it is
    known. Samples are drawn until one without a wrong pair has been met with
    probability `confidence`. Returns GeneralisedPose, refined. Raises CalibrationError
    for rays as `matched_rays`, rays through one point without a length, fewer than
    eight right pairs, no more of them than chance makes, and right pairs that a turn
    about the centre explains as well.
    """
    checked_generator("motion", rng)
    pairs = matched_rays(rays_1, rays_2, fewest=SAMPLE)
    need_length(pairs, length)
    turning = turning_pairs(pairs)

    def propose(batch):
        keys = rng.random((batch, len(pairs.rays_1.origins)))
        picks = np.argpartition(keys, SAMPLE - 1, axis=1)[:, :SAMPLE]
        return _stacked(
            *sampled_motions(turning.of(picks), pairs.spread, threshold, length)
        )

    def errors(motions):
        return squared_gaps(*_parted(motions), turning, threshold)

    best = best_hypothesis(
        propose,
        errors,
        threshold**2,
        sample_size=SAMPLE,
        confidence=confidence,
        most_trials=most_trials,
        batch=BATCH,
    )
    if best is None:
        raise CalibrationError(
            "motion: no sample of pairs agrees with any motion; the matches are wrong,"
            " or the threshold is too small",
            code="too-many-outliers",
        )
    right = _need_right(errors(best[None])[0] < threshold**2)
    _refuse_chance(best, turning, right, threshold, most_trials)
    _refuse_turn(turning, right, threshold)
    tried = _from_other_shifts(best, turning, right, length)
    cost = np.minimum(errors(tried), threshold**2).sum(axis=1)
    (R,), (u,) = _parted(tried[np.argmin(cost)][None])
    return _with_its_inliers(pairs, turning, R, u, length, threshold)


def _with_its_inliers(pairs, turning, R, u, length, threshold):
    """GeneralisedPose after fits to inliers until they no longer change."""
    right, told = None, False
    for _ in range(ROUNDS):
        ahead = np.isfinite(squared_gaps(R[None], u[None], turning, threshold)[0])
        now = ahead & (np.abs(gaps(R, u, pairs)) < threshold)
        short = _before_origins(R, u, pairs)
        # Where the length is told, few such points are wrong pairs; many would be right
        # ones of a length that is too short.
        if told and short[now].sum() < FEW * now.sum():
            now &= ~short
        if np.array_equal(now, right):
            break
        right = _need_right(now)
        found = adjusted(pairs, right, R, u, length)
        told = found.scale_told
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
    """Motions (M, 3, 4): the best one, and those that settle on right pairs (N,) from
    it and from the turn that leaves the directions least apart: as long as it, then, if
    the length is open, of any length."""
    own = turning.of(np.flatnonzero(right)[None])
    (R,), (u,) = _parted(best[None])
    far = np.linalg.norm(u)
    shifts = np.concatenate([u[None], far * np.eye(3), -far * np.eye(3)])
    turn = best_turn(own.d_1, own.d_2)
    held = settled(np.concatenate([R[None], *6 * [turn]]), shifts, own, far, HELD_STEPS)
    found = [best[None], _stacked(*held)]
    if length is None:
        found.append(_stacked(*settled(*held, own, steps=FREED_STEPS)))
    return np.concatenate(found)


def _refuse_chance(best, turning, right, threshold, most_trials):
    """Where the same motion fits pairs that are matched anew, at random, nearly as
    often, the best of many samples says nothing.

    Source: Moisan and Stival 2004, doi:10.1023/B:VISI.0000013094.38752.54 (the number
    of samples that would be as good by chance).
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
        for k in range(1, min(REMATCHED, count - 1) + 1)
    ]
    by_chance = (np.sum(agree) + 1) / (np.size(agree) + 1)
    samples = min(most_trials, comb(count, SAMPLE))
    # Six pairs are fitted whatever they are.
    as_good = bdtrc(some - FEWEST - 1, count - FEWEST, by_chance)
    if samples * as_good > 1:
        raise CalibrationError(
            f"motion: {some} of {count} pairs agree with one, as many as would by "
            "chance; the matches are wrong, or the threshold is too large",
            code="too-many-outliers",
        )


def _refuse_turn(turning, right, threshold):
    """Where nothing but a turn about the centre happened, no shift can be found."""
    own = turning.of(np.flatnonzero(right)[None])
    turn = best_turn(own.d_1, own.d_2)
    off = np.linalg.norm(np.einsum("mij,jmk->imk", turn, own.d_1) - own.d_2, axis=0)
    if np.all(off < threshold * np.hypot(own.sd_1, own.sd_2)):
        raise CalibrationError(
            f"motion: a rotation alone explains all {np.count_nonzero(right)} right"
            " pairs to within the threshold; the baseline is too short for this noise",
            code="no-translation",
        )


def _need_right(right):
    if np.count_nonzero(right) < SAMPLE:
        raise CalibrationError(
            f"motion: {np.count_nonzero(right)} of {len(right)} pairs agree with any"
            f" motion found; {SAMPLE} or more are needed",
            code="too-many-outliers",
        )
    return right


def _stacked(R, u):
    return np.concatenate([R, u[:, :, None]], axis=2)


def _parted(motions):
    return motions[:, :, :3], motions[:, :, 3]
