"""Statistics over trials: medians with intervals, comparisons, trends.

The rules are those at the head of `claims.yaml`: medians over trials with a 95 %
interval; a failed trial (nan) counts as the worst; a comparison requires a significant
test *and* a median ratio whose interval is on the right side; an interval that crosses
a boundary is undecided. The interval of a median is exact, other intervals are from a
bootstrap with a fixed seed: the same trials always give the same interval.
"""

from __future__ import annotations

from collections.abc import Callable, Sequence
from functools import cache
from typing import NamedTuple

import numpy as np

HOLDS, FAILS, UNDECIDED = "holds", "fails", "undecided"
RESAMPLES = 2000
SIGNIFICANCE = 0.01
MIN_RATIO = 1.05
MIN_N_TRIALS = 50


class Estimate(NamedTuple):
    """A statistic with its 95 % interval. failed: trials that counted as worst."""

    value: float
    low: float
    high: float
    failed: int = 0

    def times(self, factor: float) -> Estimate:
        """Return the estimate in another unit, such as 100 for percent."""
        ends = (factor * self.value, factor * self.low, factor * self.high)
        return Estimate(*ends, self.failed)

    def above(self, bound: float) -> str:
        """Decide whether the whole interval is above ``bound``."""
        if self.low > bound:
            return HOLDS
        return FAILS if self.high <= bound else UNDECIDED

    def below(self, bound: float) -> str:
        """Decide whether the whole interval is below ``bound``."""
        if self.high < bound:
            return HOLDS
        return FAILS if self.low >= bound else UNDECIDED

    def within(self, low: float, high: float) -> str:
        """Decide whether the whole interval is between ``low`` and ``high``."""
        return all_of([self.above(low), self.below(high)])


class Comparison(NamedTuple):
    """Outcome of `wins` at one level: corrected p, ratio b / a, decision."""

    p: float
    ratio: Estimate
    decision: str


def all_of(decisions: Sequence[str]) -> str:
    """Return holds if all hold, fails if one fails, undecided otherwise."""
    if FAILS in decisions:
        return FAILS
    return HOLDS if all(d == HOLDS for d in decisions) else UNDECIDED


def with_worst(values: np.ndarray, worst: float = np.inf) -> np.ndarray:
    """Return trials (n,) with the failed ones (nan) set to ``worst``."""
    values = np.asarray(values, float)
    return np.where(np.isnan(values), worst, values)


def bootstrap(
    statistic: Callable[..., np.ndarray],
    *samples: np.ndarray,
    paired: bool = False,
    level: float = 0.95,
    seed: int = 0,
) -> Estimate:
    """Percentile bootstrap of a statistic of one or more samples.

    statistic: takes arrays (..., n) and returns (...), reducing the last axis. samples:
    (n,) each; ``paired`` resamples them with the same indices. Returns Estimate.
    """
    samples = [np.asarray(s, float) for s in samples]
    rng = np.random.default_rng(seed)
    picks, index = [], None
    for sample in samples:
        if index is None or not paired:
            index = rng.integers(0, len(sample), (RESAMPLES, len(sample)))
        picks.append(sample[index])
    with np.errstate(invalid="ignore"):
        value = float(statistic(*samples))
        drawn = statistic(*picks)
    return Estimate(value, *_percentiles(drawn, level))


def proportion(trials: np.ndarray, level: float = 0.95) -> Estimate:
    """Share of trials (n,) that succeeded (1, the others 0): Estimate.

    The interval is exact (Clopper and Pearson). Unlike that of a bootstrap, it has a
    width if all trials or none succeed, and a few trials are undecided.
    """
    from scipy.stats import binomtest

    trials = np.asarray(trials)
    test = binomtest(int(trials.sum()), len(trials))
    low, high = test.proportion_ci(level, method="exact")
    return Estimate(float(trials.mean()), float(low), float(high))


def paired_gain(better: np.ndarray, worse: np.ndarray) -> Estimate:
    """Difference of the shares of successes of paired trials (n,), 1 or 0: Estimate.

    From the exact intervals of the two kinds of pairs that differ, by recovering their
    variances (after Newcombe, "Improved confidence intervals for the difference between
    binomial proportions based on paired data", Statistics in Medicine 17, 1998). Unlike
    that of a bootstrap, the interval has a width if no pair differs.
    """
    won, lost = (
        proportion(np.asarray(a) > np.asarray(b))
        for a, b in ((better, worse), (worse, better))
    )
    value = won.value - lost.value
    down = np.hypot(won.value - won.low, lost.high - lost.value)
    up = np.hypot(won.high - won.value, lost.value - lost.low)
    return Estimate(value, float(value - down), float(value + up))


def share_gain(better: np.ndarray, worse: np.ndarray) -> Estimate:
    """Difference of the shares of successes of independent trials (n,), (m,), 1 or 0.

    From the exact intervals of both shares, as in `paired_gain`: it has a width if all
    trials of one succeed and none of the other. Returns Estimate.
    """
    a, b = proportion(better), proportion(worse)
    value = a.value - b.value
    down = np.hypot(a.value - a.low, b.high - b.value)
    up = np.hypot(a.high - a.value, b.value - b.low)
    return Estimate(value, float(value - down), float(value + up))


def _percentiles(drawn: np.ndarray, level: float) -> tuple[float, float]:
    """Order statistics, so that an infinite worst value stays infinite.

    A resample without a value (ratio of two failures) is undetermined: it widens the
    interval on both sides.
    """
    unknown = np.isnan(drawn)
    tail, last = (1 - level) / 2, len(drawn) - 1
    low = np.sort(np.where(unknown, -np.inf, drawn))[int(np.floor(tail * last))]
    high = np.sort(np.where(unknown, np.inf, drawn))[int(np.ceil((1 - tail) * last))]
    return float(low), float(high)


def median_and_range(found: np.ndarray) -> Estimate:
    """Return median and range of the seeds (n,) that have a value; nan without any."""
    found = np.asarray(found, float)
    known = found[np.isfinite(found)]
    if not len(known):
        return Estimate(np.nan, np.nan, np.nan, len(found))
    ends = float(known.min()), float(known.max())
    return Estimate(float(np.median(known)), *ends, len(found) - len(known))


def median_interval(values: np.ndarray, *, worst: float = np.inf) -> Estimate:
    """Median of trials (n,) with its 95 % interval; nan counts as ``worst``.

    The ends are two order statistics whose binomial tails contain at most 2.5 % each.
    The interval has at least the nominal coverage for any distribution, without random
    numbers. A bootstrap of the median only approximates this, and its coverage is too
    low for few trials. Failed trials are last in the order: enough of them make the end
    of the interval ``worst``. Below 6 trials no interval has this coverage; then it is
    the whole range, with a coverage of 1 - 2^(1 - n).
    """
    values = np.asarray(values, float)
    ordered = np.sort(with_worst(values, worst))
    rank = _median_rank(len(ordered))
    low, high = ordered[max(rank, 1) - 1], ordered[-max(rank, 1)]
    failed = int(np.isnan(values).sum())
    return Estimate(float(_median(ordered)), float(low), float(high), failed)


@cache
def _median_rank(n: int) -> int:
    """Largest r with P(B < r) <= 2.5 % for B binomial (n, 1/2); 0 for none. Exact."""
    rank, term, tail = 0, 1, 0
    while 40 * (tail + term) <= 2**n:
        tail += term
        rank += 1
        term = term * (n - rank + 1) // rank
    return rank


def median_ratio(
    numerator: np.ndarray, denominator: np.ndarray, *, paired: bool = False
) -> Estimate:
    """Return the ratio of the medians of two samples of positive trials."""
    return ratio_of("median", numerator, denominator, paired=paired)


def ratio_of(
    statistic: str,
    numerator: np.ndarray,
    denominator: np.ndarray,
    *,
    paired: bool = False,
) -> Estimate:
    """Ratio of the medians or the means of two samples of positive trials.

    statistic: 'median' or 'mean'. A failed trial counts as the worst: as infinite in a
    median, and in a mean as the worst trial of either sample that has a value.
    """
    over_trials = OVER_TRIALS[statistic]
    samples = [with_worst(numerator), with_worst(denominator)]
    if statistic == "mean":
        trials = np.concatenate(samples)
        worst = np.max(trials, where=np.isfinite(trials), initial=0.0)
        samples = [np.minimum(sample, worst) for sample in samples]
    return bootstrap(
        lambda a, b: over_trials(a) / over_trials(b), *samples, paired=paired
    )


def spread_of_medians(*trials: np.ndarray) -> np.ndarray:
    """Return largest / smallest median of arrays (..., trials): (...)."""
    return spread_of("median", *trials)


def spread_of(statistic: str, *trials: np.ndarray) -> np.ndarray:
    """Return largest / smallest median or mean of arrays (..., trials): (...)."""
    found = [OVER_TRIALS[statistic](t) for t in trials]
    return np.max(found, axis=0) / np.min(found, axis=0)


def _median(values: np.ndarray) -> np.ndarray:
    return np.median(values, axis=-1)


def _mean(values: np.ndarray) -> np.ndarray:
    return np.mean(values, axis=-1)


OVER_TRIALS = {"median": _median, "mean": _mean}
"""Statistic over the trials of a level: arrays (..., trials) to (...)."""


def wins(
    levels: Sequence[tuple[np.ndarray, np.ndarray]], statistic: str = "median"
) -> list[Comparison]:
    """wins(a < b) at every level given as a pair of trials (a, b), paired by trial.

    One-sided Wilcoxon signed-rank test with p < 0.01 after Holm's correction over the
    levels, and a ratio b / a of the medians, or of the means, of at least 1.05 with its
    interval on that side. Fewer than 50 trials at a level decide nothing in favour.
    """
    from scipy.stats import wilcoxon

    pairs = [(with_worst(a), with_worst(b)) for a, b in levels]
    raw = []
    for a, b in pairs:
        difference = _difference(b, a)
        if not difference.any():
            raw.append(1.0)
        else:
            raw.append(float(wilcoxon(difference, alternative="greater").pvalue))
    found = []
    for p, (a, b) in zip(holm(raw), pairs, strict=True):
        ratio = ratio_of(statistic, b, a, paired=True)
        decision = ratio.above(np.nextafter(MIN_RATIO, 0))
        if decision == HOLDS and (p >= SIGNIFICANCE or len(a) < MIN_N_TRIALS):
            decision = UNDECIDED
        found.append(Comparison(p, ratio, decision))
    return found


def _difference(b: np.ndarray, a: np.ndarray) -> np.ndarray:
    """b - a; two failures tie, and one failure outranks every finite difference."""
    finite = np.isfinite(a) & np.isfinite(b)
    difference = np.subtract(b, a, out=np.zeros(len(a)), where=finite)
    largest = np.abs(difference).max() + 1
    difference[np.isinf(b) & np.isfinite(a)] = largest
    difference[np.isinf(a) & np.isfinite(b)] = -largest
    return difference


def mcnemar(a: np.ndarray, b: np.ndarray) -> float:
    """Return the exact two-sided p-value that paired trials (N,) bool succeed equally
    often.

    Each pair that differs is a fair coin toss; the p-value is 1 if none differs.
    """
    from scipy.stats import binomtest

    a, b = np.asarray(a, bool), np.asarray(b, bool)
    gained, lost = int((b & ~a).sum()), int((a & ~b).sum())
    if not gained + lost:
        return 1.0
    return float(binomtest(gained, gained + lost, 0.5).pvalue)


def holm(p_values: Sequence[float]) -> list[float]:
    """Holm's step-down correction of p values, in the order given."""
    p = np.asarray(p_values, float)
    order = np.argsort(p)
    steps = p[order] * (len(p) - np.arange(len(p)))
    corrected = np.empty(len(p))
    corrected[order] = np.minimum(np.maximum.accumulate(steps), 1.0)
    return corrected.tolist()


def welch_less(a: np.ndarray, b: np.ndarray) -> float:
    """Return the one-sided p-value of Welch's test that the mean of ``a`` is below
    ``b``'s.

    Failed trials count as the worst finite trial of either sample. If both samples have
    no scatter (or no success), the means decide.
    """
    from scipy.stats import ttest_ind_from_stats

    samples = [np.asarray(a, float), np.asarray(b, float)]
    worst = np.nanmax(np.concatenate([*samples, [-np.inf]]))
    if np.isinf(worst):
        return 1.0
    a, b = (with_worst(sample, worst) for sample in samples)
    if np.ptp(a) == np.ptp(b) == 0:
        return float(a[0] >= b[0])
    moments = [(v.mean(), v.std(ddof=1), len(v)) for v in (a, b)]
    found = ttest_ind_from_stats(
        *moments[0], *moments[1], equal_var=False, alternative="less"
    )
    return float(found.pvalue)


class Line(NamedTuple):
    """A weighted straight-line fit: slope, intercept, R2."""

    slope: float
    intercept: float
    r2: float


def weighted_line(x: np.ndarray, y: np.ndarray, weights: np.ndarray) -> Line:
    """Least-squares line through (x, y), weights inverse variances, and its R2."""
    x, y, w = (np.asarray(v, float) for v in (x, y, weights))
    w = w / w.sum()
    mean_x, mean_y = w @ x, w @ y
    slope = (w @ ((x - mean_x) * (y - mean_y))) / (w @ (x - mean_x) ** 2)
    intercept = mean_y - slope * mean_x
    left = w @ (y - slope * x - intercept) ** 2
    return Line(
        float(slope), float(intercept), float(1 - left / (w @ (y - mean_y) ** 2))
    )


def trend(
    x: np.ndarray,
    trials: Sequence[np.ndarray],
    fit: Callable,
    *,
    statistic: str = "median",
    seed: int = 0,
) -> Estimate:
    """Bootstrap of a fit over a sweep: trials are resampled within every level.

    x: (levels,); trials: one array of trials per level (nan counts as the level's worst
    finite trial); fit(x, medians) -> float, with medians (levels,), or means if that is
    the ``statistic``. A level at which every trial failed leaves the fit undetermined:
    nan, from -inf to inf.
    """
    rng = np.random.default_rng(seed)
    failed = int(sum(np.isnan(t).sum() for t in trials))
    if any(np.isnan(t).all() for t in trials):
        return Estimate(np.nan, -np.inf, np.inf, failed)
    filled = [with_worst(t, np.nanmax(t)) for t in trials]
    over_trials = OVER_TRIALS[statistic]
    drawn = np.stack(
        [
            over_trials(t[rng.integers(0, len(t), (RESAMPLES // 4, len(t)))])
            for t in filled
        ],
        axis=1,
    )
    value = fit(x, np.array([over_trials(t) for t in filled]))
    low, high = _percentiles(np.array([fit(x, row) for row in drawn]), 0.95)
    return Estimate(float(value), low, high, failed)


def loglog_slope(x: np.ndarray, y: np.ndarray) -> float:
    """Slope of log y over log x, least squares."""
    return float(np.polyfit(np.log(x), np.log(y), 1)[0])
