"""A homography to start from where some pairs are wrong, and where to cut them off."""

import numpy as np

from raxel.errors import InputError
from raxel.geometry.consensus import trials_needed
from raxel.geometry.homography import (
    apply_homography,
    four_point_homographies,
    homography_dlt,
    normalising,
    random_samples,
)

CUT = 5.0  # standard deviations
JUDGES = 2000  # pairs that judge the samples
QUARTER = 0.7585  # lower quartile of distances, noise of standard deviation 1 per axis
ROUNDING = 1e-9  # of the spread of the target: no pair is cut for less


def robust_start(source, target, rng, sigma=None):
    """H (3, 3) that most pairs agree on, and the distance from which on they do not.

    source, target: (N, 2), N >= 4; rng: numpy Generator; sigma: standard deviation of a
    pair's distance per axis, in the target frame; None takes it from the data.

    Samples of four pairs, as many as meet one of right pairs with probability 0.999
    while half of the pairs are wrong. The best has the smallest lower quartile of
    distances: it holds whatever the other three quarters are, so a wrong majority is
    seen by its number. Rounds of linear fits to what agrees follow.
    Least quantile of squares: Rousseeuw 1984, doi:10.1080/01621459.1984.10477105.
    """
    trials = int(np.ceil(trials_needed(0.5, 4, 0.999)))
    picks = random_samples(rng, len(source), trials)
    judges = rng.permutation(len(source))[:JUDGES]
    T_s, T_t = normalising(source), normalising(target)
    hypotheses = four_point_homographies(
        apply_homography(T_s, source), apply_homography(T_t, target), picks
    )
    hypotheses = np.linalg.inv(T_t) @ hypotheses @ T_s
    if len(hypotheses) == 0:
        raise InputError(
            "homography: no four points in general position found; the points lie on "
            "one line or are repeated"
        )
    gaps = _distances(hypotheses, source[judges], target[judges])
    H = hypotheses[np.argmin(np.quantile(gaps, 0.25, axis=1))]
    least = ROUNDING * np.sqrt(np.mean((target - np.median(target, axis=0)) ** 2))
    for _ in range(5):
        gap = _distances(H, source, target)
        noise = np.quantile(gap, 0.25) / QUARTER if sigma is None else sigma
        limit = max(CUT * noise, least)
        right = gap < limit
        if np.count_nonzero(right) < 4:
            break
        H = homography_dlt(source[right], target[right])
    return H, limit


def _distances(H, source, target):
    mapped = apply_homography(H, source)
    gap = np.hypot(*np.moveaxis(mapped - target, -1, 0))
    return np.where(np.isfinite(gap), gap, np.inf)
