"""Homographies between planes: linear, streaming, robust and refined estimates.

A homography H (3, 3) maps `target ~ H (source, 1)`. Points are (N, 2) in any unit.
Estimates have Frobenius norm 1 and the sign that makes the third homogeneous
coordinate positive at the centroid of the source points.
Source of the method: Hartley 1997, doi:10.1109/34.601246 (normalisation); Hartley and
Zisserman 2004, doi:10.1017/CBO9780511811685, chapter 4.
"""

from __future__ import annotations

import math
from collections.abc import Callable

import numpy as np
from numpy.typing import ArrayLike, NDArray

from raxel.errors import InputError

# Random sample consensus with a truncated cost: one loop for every model. Sources:
# Fischler and Bolles 1981, doi:10.1145/358669.358692; Torr and Zisserman 2000,
# doi:10.1006/cviu.1999.0832 (truncated cost).


def best_hypothesis(
    propose, squared_errors, limit, *, sample_size, confidence, most_trials, batch
):
    """The hypothesis with the least truncated squared error, or None if none came.

    propose(count): stack (m, ...) of hypotheses from ``count`` samples, m may differ
    from count. squared_errors(hypotheses): (m, N), NaN counts as an outlier. limit:
    squared error from which on a pair is an outlier.

    Samples are drawn in batches until, at the inlier fraction of the best hypothesis so
    far, a sample of ``sample_size`` inliers has been drawn with probability
    ``confidence``; at most ``most_trials``, rounded up to a batch.
    """
    best, best_cost, drawn, needed = None, math.inf, 0, most_trials
    while drawn < needed:
        hypotheses = propose(batch)
        drawn += batch
        if len(hypotheses) == 0:
            continue
        squared = squared_errors(hypotheses)
        right = squared < limit
        cost = np.where(right, squared, limit).sum(axis=1)
        i = int(np.argmin(cost))
        if cost[i] < best_cost:
            best, best_cost = hypotheses[i], cost[i]
            trials = trials_needed(np.mean(right[i]), sample_size, confidence)
            needed = min(most_trials, trials)
    return best


def trials_needed(share, sample_size, confidence):
    """Number of samples until one contains inliers only, at a share of inliers."""
    miss = 1 - share**sample_size
    if miss <= 0:
        return 0
    return math.log(1 - confidence) / math.log(miss) if miss < 1 else math.inf


def checked_generator(model, rng):
    """Reject an rng that is no numpy Generator; model: its name, for errors."""
    if not isinstance(rng, np.random.Generator):
        raise InputError(
            f"{model}: rng: found {type(rng).__name__}; give "
            "numpy.random.default_rng(seed)"
        )


BLOCK = 1 << 16


def apply_homography(H: ArrayLike, points: ArrayLike) -> NDArray[np.float64]:
    """Map points by a homography.

    Points on the line that H sends to infinity become NaN.

    Parameters
    ----------
    H : array_like, shape (3, 3) or (n, 3, 3)
        Homography, or a stack of them.
    points : array_like, shape (N, 2)
        Points in the source frame.

    Returns
    -------
    ndarray, shape (N, 2) or (n, N, 2)
        Points in the target frame.

    Examples
    --------
    >>> from raxel.geometry import apply_homography
    >>> H = [[2, 0, 1], [0, 2, 0], [0, 0, 1]]
    >>> apply_homography(H, [[0, 0], [3, 4]])
    array([[1., 0.],
           [7., 8.]])
    """
    H, points = np.asarray(H, float), np.asarray(points, float)
    Ht = np.swapaxes(H, -1, -2)
    mapped = points @ Ht[..., :2, :] + Ht[..., 2:, :]
    w = mapped[..., 2:]
    return mapped[..., :2] / np.where(w != 0, w, np.nan)


def homography_dlt(
    source: ArrayLike, target: ArrayLike, weights: ArrayLike | None = None
) -> NDArray[np.float64]:
    """Estimate a homography by the normalised direct linear transform.

    Both point sets are moved to weighted mean zero and root mean square distance
    sqrt(2) first. So the result does not depend on a similarity of either frame.
    Memory is 18 numbers per point: for millions of points use `fit_homography`.

    Parameters
    ----------
    source, target : array_like, shape (N, 2)
        Pairs of points, N >= 4, in any unit.
    weights : array_like, shape (N,), optional
        Weights, not negative. Each multiplies the two algebraic equations of its
        point.

    Returns
    -------
    ndarray, shape (3, 3)
        Homography of Frobenius norm 1 with `target ~ H (source, 1)`.

    Raises
    ------
    InputError
        Fewer than four points, values that are not finite, or points that leave H
        undetermined (three of four, or all, on one line).

    Examples
    --------
    >>> from raxel.geometry import apply_homography, homography_dlt
    >>> source = [[0, 0], [1, 0], [1, 1], [0, 1]]
    >>> target = [[10, 20], [30, 20], [30, 40], [10, 40]]
    >>> H = homography_dlt(source, target)
    >>> apply_homography(H, [[0.5, 0.5]]).round(6)
    array([[20., 30.]])
    """
    source, target, w = _checked(source, target, weights)
    scale = w**2
    T_s = normalising(source, scale)
    T_t = normalising(target, scale)
    s = _homogeneous(apply_homography(T_s, source)) * w[:, None]
    t = apply_homography(T_t, target)
    A = np.zeros((2, len(s), 9))
    A[0, :, :3] = A[1, :, 3:6] = s
    A[:, :, 6:] = -t.T[:, :, None] * s
    A = A.reshape(-1, 9)  # type: ignore[assignment]
    _, values, Vt = np.linalg.svd(np.linalg.qr(A, mode="r"))
    H = Vt[8].reshape(3, 3)
    _check_degenerate(values[7] / values[0], H, 1e-12)
    return _denormalised(H, T_s, T_t)


def homography_ransac(
    source: ArrayLike,
    target: ArrayLike,
    threshold: float,
    rng: np.random.Generator,
    *,
    squared_errors: Callable[[NDArray[np.float64]], NDArray[np.float64]] | None = None,
    confidence: float = 0.999,
    most_trials: int = 2000,
) -> tuple[NDArray[np.float64], NDArray[np.bool_]]:
    """Estimate a homography in the presence of wrong pairs.

    Samples of four pairs are drawn, and the one with the least truncated squared
    distance is kept. Linear fits to its inliers follow until they no longer change.
    Any four points agree with some H: judge the number of inliers, not only their
    share.

    Parameters
    ----------
    source, target : array_like, shape (N, 2)
        Pairs of points, N >= 4.
    threshold : float
        Largest distance in the target frame, in its unit, of a pair that counts as
        right.
    rng : numpy.random.Generator
        Source of the random samples.
    squared_errors : callable, optional
        Compared with `threshold`**2 in place of the squared distances: a function of
        homographies (m, 3, 3) that gives (m, N).
    confidence : float
        Sampling ends when one sample of right pairs has been met with this
        probability, at the share of right pairs found so far.
    most_trials : int
        Largest number of samples.

    Returns
    -------
    H : ndarray, shape (3, 3)
        Homography with `target ~ H (source, 1)`.
    inliers : ndarray of bool, shape (N,)
        Pairs within the threshold.

    Raises
    ------
    InputError
        The input is rejected as in `homography_dlt`, or no sample determines H.

    References
    ----------
    See `raxel.geometry.homography`.
    """
    source, target, w = _checked(source, target, None)
    checked_generator("homography", rng)
    T_s = normalising(source, w)
    T_t = normalising(target, w)
    s, t = apply_homography(T_s, source), apply_homography(T_t, target)
    batch = int(np.clip(BLOCK // len(s), 1, 64))
    back = np.linalg.inv(T_t)

    def propose(count):
        return four_point_homographies(s, t, random_samples(rng, len(s), count))

    if squared_errors is None:
        limit = (threshold * T_t[0, 0]) ** 2

        def judge(H):
            return np.sum((apply_homography(H, s) - t) ** 2, axis=-1)

        def within(H):
            return _within(H, source, target, threshold)
    else:
        limit = threshold**2

        def judge(H):
            return squared_errors(back @ H @ T_s)

        def within(H):
            return squared_errors(H[None])[0] < limit

    best = best_hypothesis(
        propose,
        judge,
        limit,
        sample_size=4,
        confidence=confidence,
        most_trials=most_trials,
        batch=batch,
    )
    if best is None:
        raise InputError(
            "homography: no four points are in general position (collinear or "
            "repeated); add other points"
        )
    return refit_to_inliers(back @ best @ T_s, source, target, within)


def refit_to_inliers(H, source, target, within):
    """Linear fits to the inliers of H, and of each fit, until they no longer change.

    H: (3, 3) start; source, target: (N, 2); within: function of H that returns the
    inliers (N,) bool. Returns H and inliers of the last fit. Raises InputError as
    `homography_dlt`.
    """
    inliers = within(H)
    for _ in range(20):
        H = homography_dlt(source[inliers], target[inliers])
        now = within(H)
        if np.array_equal(now, inliers) or np.count_nonzero(now) < 4:
            break
        inliers = now
    return H, inliers


def transfer_jacobian(H, points):
    """Derivatives (N, 2, 9) of the mapped points by the entries of H, row by row.

    H: (3, 3); points: (N, 2) in the source frame.
    """
    s = _homogeneous(np.asarray(points, float))
    mapped = apply_homography(H, points)
    s = s / (s @ np.asarray(H, float)[2])[:, None]
    J = np.zeros((len(s), 2, 9))
    J[:, 0, :3] = s
    J[:, 1, 3:6] = s
    J[:, :, 6:] = -mapped[:, :, None] * s[:, None, :]
    return J


def refine_homography(
    H: ArrayLike, source: ArrayLike, target: ArrayLike, weights: ArrayLike | None = None
) -> NDArray[np.float64]:
    """Return the homography that minimises the distances in the target frame.

    This is the maximum likelihood estimate for isotropic Gaussian noise of the target
    points alone. Levenberg-Marquardt acts on the eight directions that change H.

    Parameters
    ----------
    H : array_like, shape (3, 3)
        Start, such as the result of `homography_dlt`.
    source, target : array_like, shape (N, 2)
        Pairs of points, N >= 4.
    weights : array_like, shape (N,), optional
        Each multiplies the distance of its pair.

    Returns
    -------
    ndarray, shape (3, 3)
        Homography of Frobenius norm 1.

    Raises
    ------
    InputError
        As `homography_dlt`.
    """
    from scipy.optimize import leastsq

    source, target, w = _checked(source, target, weights)
    T_s = normalising(source, w**2)
    T_t = normalising(target, w**2)
    s, t = apply_homography(T_s, source), apply_homography(T_t, target)
    h = (T_t @ np.asarray(H, float) @ np.linalg.inv(T_s)).ravel()
    h = h / np.linalg.norm(h)
    # The rows 1..8 of this complete basis are perpendicular to h.
    tangent = np.linalg.svd(h[None, :])[2][1:]

    def residual(x):
        moved = apply_homography((h + x @ tangent).reshape(3, 3), s)
        return ((moved - t) * w[:, None]).ravel()

    def jacobian(x):
        J = transfer_jacobian((h + x @ tangent).reshape(3, 3), s)
        return (J * w[:, None, None]).reshape(-1, 9) @ tangent.T

    # The full output suppresses a warning for points without residuals.
    x, *_ = leastsq(
        residual,
        np.zeros(8),
        Dfun=jacobian,
        full_output=True,
        xtol=1e-12,
        ftol=1e-12,
        gtol=1e-8,
        maxfev=800,
    )
    return _denormalised((h + x @ tangent).reshape(3, 3), T_s, T_t)


def _homogeneous(points):
    return np.concatenate([points, np.ones((*points.shape[:-1], 1))], axis=-1)


def _checked(
    source: ArrayLike, target: ArrayLike, weights: ArrayLike | None, fewest: int = 4
) -> tuple[NDArray[np.float64], NDArray[np.float64], NDArray[np.float64]]:
    source, target = np.asarray(source, float), np.asarray(target, float)
    if source.ndim != 2 or source.shape[1] != 2 or source.shape != target.shape:
        raise InputError(
            f"homography: found points {source.shape} and {target.shape}; give two "
            "equal arrays (N, 2)"
        )
    w = np.ones(len(source)) if weights is None else np.asarray(weights, float)
    if w.shape != (len(source),) or not np.all((w >= 0) & np.isfinite(w)):
        raise InputError(
            f"homography: weights: found shape {w.shape}; give {len(source)} finite "
            "numbers of 0 or more"
        )
    bad = int(np.count_nonzero(~np.isfinite(source + target).all(axis=1)))
    if bad:
        raise InputError(
            f"homography: {bad} of {len(source)} points are not finite; remove them"
        )
    if np.count_nonzero(w) < fewest:
        raise InputError(
            f"homography: found {np.count_nonzero(w)} points; give at least {fewest}"
        )
    return source, target, w


def normalising(
    points: NDArray[np.float64], weights: NDArray[np.float64] | None = None
) -> NDArray[np.float64]:
    """Return the similarity that normalises points.

    It moves them to weighted mean zero and root mean square distance sqrt(2).

    Parameters
    ----------
    points : ndarray, shape (N, 2)
        Points in any unit.
    weights : ndarray, shape (N,), optional
        Weights of the mean; all equal if omitted.

    Returns
    -------
    ndarray, shape (3, 3)
        Similarity, to be applied to (x, y, 1).

    Raises
    ------
    InputError
        All points are the same.
    """
    w = np.ones(len(points)) if weights is None else weights
    w = w / w.sum()
    centre = w @ points
    spread = w @ np.sum((points - centre) ** 2, axis=1)
    return normalising_of(centre, spread + centre @ centre)


def normalising_of(centre, square):
    """The same from the mean (2,) and the mean squared length of the points."""
    spread = square - centre @ centre
    if not spread > 1e-14 * square:
        raise InputError("homography: all points are equal; give distinct points")
    return _similarity(math.sqrt(2 / spread), centre)


def _similarity(scale, centre):
    T = np.diag([scale, scale, 1.0])
    T[:2, 2] = -scale * np.asarray(centre)
    return T


def _denormalised(H, T_s, T_t):
    # Normalised source points have mean zero: the sign of the last entry is the sign
    # of the third coordinate at the centroid, in any frame.
    if H[2, 2] < 0:
        H = -H
    H = np.linalg.solve(T_t, H @ T_s)
    return H / np.linalg.norm(H)


def _check_degenerate(ratio, H, floor):
    """Reject a larger null space, and the singular H of collinear target points."""
    values = np.linalg.svd(H, compute_uv=False)
    if not (ratio > floor and values[2] > floor * values[0]):
        raise InputError(
            "homography: the points do not determine it (collinear or repeated); give "
            "at least four in general position"
        )


def random_samples(rng, count, size):
    """Index sets (size, 4), each without repetition, from range(count)."""
    picks = rng.integers(0, count - np.arange(4), size=(size, 4))
    for k in range(1, 4):
        # Skipping used indices, in rising order, keeps the draw uniform.
        for taken in np.sort(picks[:, :k], axis=1).T:
            picks[:, k] += picks[:, k] >= taken
    return picks


def four_point_homographies(source, target, picks):
    """Exact H (m, 3, 3) for each sample (k, 4) of pairs in general position; m <= k.

    source, target: (N, 2), of about unit size, the unit of the degeneracy test.
    """
    s, t = _homogeneous(source)[picks], _homogeneous(target)[picks]

    def basis(p):
        rows = np.cross(p[:, [1, 2, 0]], p[:, [2, 0, 1]])
        fourth = np.einsum("nij,nj->ni", rows, p[:, 3])
        volume = np.sum(rows[:, 0] * p[:, 0], axis=-1)
        least = np.minimum(np.abs(fourth).min(axis=1), np.abs(volume))
        return rows, fourth, least

    rows, weight_s, least_s = basis(s)
    _, weight_t, least_t = basis(t)
    good = np.minimum(least_s, least_t) > 1e-6
    ratio = weight_t[good] / weight_s[good]
    return np.einsum("ni,nij,nik->njk", ratio, t[good, :3], rows[good])


def _within(H, source, target, threshold):
    gap = np.linalg.norm(apply_homography(H, source) - target, axis=1)
    return gap < threshold


# Initial homography with outliers, and threshold for their rejection.


OUTLIER_SIGMAS = 5.0  # standard deviations
N_SCORING_PAIRS = 2000  # pairs that score the samples
# Lower quartile of distances at unit standard deviation per axis.
RAYLEIGH_QUARTILE = 0.7585
ROUNDING_TOL = 1e-9  # minimum threshold, over the spread of the target


def robust_start(
    source: NDArray[np.float64],
    target: NDArray[np.float64],
    rng: np.random.Generator,
    sigma: float | None = None,
) -> tuple[NDArray[np.float64], float]:
    """Return a homography that most pairs agree on, and the limit of agreement.

    There are as many samples of four pairs as meet one of right pairs with
    probability 0.999 while half of the pairs are wrong. The best sample has the
    smallest lower quartile of distances. That quartile holds whatever the other three
    quarters are, so the number of wrong pairs reveals a wrong majority. Rounds of
    linear fits to the pairs that agree follow.

    Parameters
    ----------
    source, target : ndarray, shape (N, 2)
        Pairs of points, N >= 4.
    rng : numpy.random.Generator
        Source of the random samples.
    sigma : float, optional
        Standard deviation of a pair's distance per axis, in the target frame. None
        takes it from the data.

    Returns
    -------
    H : ndarray, shape (3, 3)
        Homography with `target ~ H (source, 1)`.
    limit : float
        Distance in the target frame from which on pairs do not agree.

    Raises
    ------
    InputError
        No four points in general position, or the input is rejected as in
        `homography_dlt`.

    References
    ----------
    Least quantile of squares: Rousseeuw 1984, doi:10.1080/01621459.1984.10477105.
    """
    trials = int(np.ceil(trials_needed(0.5, 4, 0.999)))
    picks = random_samples(rng, len(source), trials)
    judges = rng.permutation(len(source))[:N_SCORING_PAIRS]
    T_s, T_t = normalising(source), normalising(target)
    hypotheses = four_point_homographies(
        apply_homography(T_s, source), apply_homography(T_t, target), picks
    )
    hypotheses = np.linalg.inv(T_t) @ hypotheses @ T_s
    if len(hypotheses) == 0:
        raise InputError(
            "homography: no four points are in general position (collinear or "
            "repeated); add other points"
        )
    gaps = _distances(hypotheses, source[judges], target[judges])
    H = hypotheses[np.argmin(np.quantile(gaps, 0.25, axis=1))]
    least = ROUNDING_TOL * np.sqrt(np.mean((target - np.median(target, axis=0)) ** 2))
    for _ in range(5):
        gap = _distances(H, source, target)
        noise = np.quantile(gap, 0.25) / RAYLEIGH_QUARTILE if sigma is None else sigma
        limit = max(OUTLIER_SIGMAS * noise, least)
        right = gap < limit
        if np.count_nonzero(right) < 4:
            break
        H = homography_dlt(source[right], target[right])
    return H, limit


def _distances(H, source, target):
    u, v, w = np.moveaxis(H @ np.vstack([source.T, np.ones(len(source))]), -2, 0)
    with np.errstate(divide="ignore", invalid="ignore"):
        gap = np.sqrt((u / w - target[:, 0]) ** 2 + (v / w - target[:, 1]) ** 2)
    return np.where(np.isfinite(gap), gap, np.inf)
