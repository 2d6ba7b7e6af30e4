"""Intervals cover, tests keep their level, and failures count as the worst."""

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st
from scipy.stats import binom, ttest_ind

from repro.judge import statistics as stats


def binomial_room(n: int, p: float) -> float:
    """Three standard deviations of a count with probability p."""
    return 3 * np.sqrt(n * p * (1 - p))


def covering(estimates, true):
    """How many of the intervals hold the true value."""
    return sum(found.low <= true <= found.high for found in estimates)


@pytest.mark.parametrize("n", [5, 15, 50, 200])
def test_median_interval_covers_the_median(n):
    rng = np.random.default_rng(n)
    drawn = rng.exponential(size=(2000, n))
    # Exact: at least 95 %, and at most what one rank more on each side leaves out. Of
    # five trials even the whole range misses the median once in sixteen.
    rank = max(stats._median_rank(n), 1)
    exact = 1 - 2 * binom.cdf(rank - 1, n, 0.5)
    assert exact == 1 - 2**-4 if n == 5 else 0.95 <= exact < 0.985
    covered = covering(map(stats.median_interval, drawn), np.log(2))
    assert abs(covered - exact * 2000) <= binomial_room(2000, exact)


def test_median_interval_ranks_match_binomial_tails():
    for n in range(1, 400):
        rank = stats._median_rank(n)
        assert rank == 0 or binom.cdf(rank - 1, n, 0.5) <= 0.025
        assert binom.cdf(rank, n, 0.5) > 0.025


def test_failed_trials_count_as_worst():
    good = np.arange(1.0, 11.0)
    failed = np.where(good > 4, np.nan, good)
    found = stats.median_interval(failed)
    assert found == (np.inf, 2.0, np.inf, 6)
    assert stats.median_interval(good) == (5.5, 2.0, 9.0, 0)
    assert stats.median_interval(failed, worst=-1.0).value == -1.0


def test_proportion_interval_has_coverage_and_width():
    rng = np.random.default_rng(4)
    drawn = rng.random((400, 40)) < 0.9
    covered = covering(map(stats.proportion, drawn), 0.9)
    assert covered >= 0.95 * 400 - binomial_room(400, 0.95)
    # All of n: the lower end is the p at which that happens in one run of forty.
    whole = stats.proportion(np.ones(25))
    assert (whole.value, whole.high) == (1.0, 1.0)
    assert whole.low == pytest.approx(0.025 ** (1 / 25))
    assert whole.above(0.9) == stats.UNDECIDED


def test_paired_gain_interval_has_coverage_and_width():
    rng = np.random.default_rng(5)
    # 20 % are won, 10 % lost, the others alike: a gain of 0.1.
    kind = rng.choice([1, -1, 0], (400, 60), p=[0.2, 0.1, 0.7])
    base = np.where(kind == 0, rng.integers(0, 2, (400, 60)), kind < 0)
    covered = covering(map(stats.paired_gain, base + kind, base), 0.1)
    assert covered >= 0.95 * 400 - binomial_room(400, 0.95)
    alike = stats.paired_gain(np.ones(40), np.ones(40))
    assert (alike.value, alike.within(-0.05, 0.05)) == (0, stats.UNDECIDED)
    assert alike.high == -alike.low == pytest.approx(1 - 0.025 ** (1 / 40))


def test_share_gain_interval_has_coverage_and_width():
    rng = np.random.default_rng(6)
    a, b = rng.random((200, 50)) < 0.9, rng.random((200, 40)) < 0.6
    covered = covering(map(stats.share_gain, a, b), 0.3)
    assert covered >= 0.95 * 200 - binomial_room(200, 0.95)
    whole = stats.share_gain(np.ones(50), np.zeros(50))
    assert (whole.value, whole.high) == (1, 1)
    assert whole.low == pytest.approx(1 - np.sqrt(2) * (1 - 0.025 ** (1 / 50)))


def check_tails(found, drawn):
    """An interval leaves out a fortieth of the drawn values at each side. Its ends are
    draws themselves: the next one outwards would leave out too little."""
    drawn = np.concatenate([np.atleast_1d(d) for d in drawn])
    share = np.array([np.mean(drawn < found.low), np.mean(drawn > found.high)])
    assert np.all((share <= 0.025) & (share + 1 / len(drawn) >= 0.025))


def test_bootstrap_interval_excludes_tails():
    drawn = []

    def mean(values):
        drawn.append(values.mean(axis=-1))
        return drawn[-1]

    found = stats.bootstrap(mean, np.random.default_rng(11).normal(size=50))
    assert drawn[0] == found.value
    assert len(drawn[1]) == stats.RESAMPLES
    check_tails(found, drawn[1:])


def test_trend_interval_excludes_tails():
    rng = np.random.default_rng(12)
    x = np.array([0.1, 0.5, 2.0])
    trials = [v * rng.lognormal(sigma=0.3, size=51) for v in x]
    drawn = []

    def slope(x, medians):
        drawn.append(stats.loglog_slope(x, medians))
        return drawn[-1]

    found = stats.trend(x, trials, slope)
    assert drawn[0] == found.value
    check_tails(found, drawn[1:])


def test_bootstrap_is_reproducible():
    values = np.random.default_rng(2).normal(size=40)
    assert stats.median_interval(values) == stats.median_interval(values.copy())


@pytest.mark.parametrize(
    ("low", "high", "above", "below"),
    [
        (1.1, 1.3, "holds", "fails"),
        (0.8, 0.9, "fails", "holds"),
        (0.9, 1.1, "undecided", "undecided"),
        (0.9, 1.0, "fails", "undecided"),
        (1.0, 1.1, "undecided", "fails"),
    ],
)
def test_decisions_require_whole_interval(low, high, above, below):
    estimate = stats.Estimate((low + high) / 2, low, high)
    assert (estimate.above(1.0), estimate.below(1.0)) == (above, below)


@pytest.mark.parametrize(
    ("estimate", "decision"),
    [
        ((1.0, 0.95, 1.05), "holds"),
        ((1.0, 0.85, 1.05), "undecided"),
        ((1.3, 1.2, 1.4), "fails"),
    ],
)
def test_within_requires_both_sides(estimate, decision):
    assert stats.Estimate(*estimate).within(0.9, 1.1) == decision


def pairs(rng, factor, n=50, levels=3):
    base = [rng.lognormal(sigma=0.2, size=n) for _ in range(levels)]
    noise = [rng.lognormal(sigma=0.1, size=n) for _ in range(levels)]
    return [(a, factor * a * e) for a, e in zip(base, noise, strict=True)]


def test_wins_detects_clear_difference_only():
    rng = np.random.default_rng(3)
    decisions = {
        factor: [
            stats.all_of([c.decision for c in stats.wins(pairs(rng, factor))])
            for _ in range(15)
        ]
        for factor in (0.9, 1.0, 1.3)
    }
    assert (decisions[1.3], decisions[0.9]) == (15 * ["holds"], 15 * ["fails"])
    assert "holds" not in decisions[1.0]


def test_wins_rejects_small_significant_difference():
    rng = np.random.default_rng(4)
    a = rng.lognormal(sigma=0.2, size=400)
    (found,) = stats.wins([(a, 1.02 * a)])
    assert found.p < 1e-6
    assert found.decision == "fails"


def test_wins_is_one_sided():
    a = np.array([1.0, 2.1, 3.3, 4.6])
    (found,) = stats.wins([(a, 2 * a)])
    # Four fair coins that all show the same, named side.
    assert found.p == pytest.approx(2**-4)
    (reverse,) = stats.wins([(2 * a, a)])
    assert reverse.p == pytest.approx(1)


def test_wins_corrects_for_number_of_levels():
    levels = pairs(np.random.default_rng(15), 1.03, n=12)
    alone = [stats.wins([level])[0].p for level in levels]
    together = [found.p for found in stats.wins(levels)]
    assert together == pytest.approx(stats.holm(alone))
    assert together != pytest.approx(alone)


def test_wins_is_undecided_without_significance():
    """Forty pairs gain a tenth, ten lose all but a little."""
    a = np.linspace(1, 1.001, 50)
    b = np.where(np.arange(50) < 40, 1.1 * a, 0.01 * a)
    (found,) = stats.wins([(a, b)])
    assert found.ratio.above(stats.MIN_RATIO) == "holds"
    assert 0.01 < found.p < 0.1
    assert found.decision == "undecided"


def test_wins_counts_one_sided_failures():
    a = np.linspace(1, 2, 60)
    b = np.where(np.arange(60) % 2, np.nan, a)
    (found,) = stats.wins([(a, b)])
    assert found.p < 0.01
    (reverse,) = stats.wins([(b, a)])
    assert reverse.decision != "holds"


@given(st.lists(st.floats(0, 1), min_size=1, max_size=8))
def test_holm_is_between_raw_and_bonferroni(p):
    corrected = np.array(stats.holm(p))
    raw = np.array(p)
    assert np.all(corrected >= raw)
    assert np.all(corrected <= np.minimum(1, len(p) * raw.max()))
    assert corrected.min() == min(1, len(p) * raw.min())
    order = np.argsort(raw)
    assert np.all(np.diff(corrected[order]) >= 0)


def test_holm_matches_manual_example():
    assert stats.holm([0.01, 0.04, 0.03]) == pytest.approx([0.03, 0.06, 0.06])


def test_weighted_line_recovers_line_and_r2():
    x = np.array([0.02, 0.1, 0.25, 0.5, 1.0, 2.0])
    line = stats.weighted_line(x, 3 * x + 1, 1 / x)
    assert (line.slope, line.intercept, line.r2) == pytest.approx((3, 1, 1))
    bent = stats.weighted_line(x, x**2, np.ones(6))
    assert bent.r2 < 0.98


def test_weighted_line_follows_heavy_points():
    x = np.array([0.0, 1.0, 2.0, 3.0])
    y = np.array([0.0, 1.0, 2.0, 9.0])
    line = stats.weighted_line(x, y, np.array([1, 1, 1, 1e-9]))
    assert line.slope == pytest.approx(1, abs=1e-6)


def test_trend_covers_power_law_exponent():
    rng = np.random.default_rng(6)
    x = np.array([0.1, 0.25, 0.5, 1.0, 2.0])
    trials = 2 * x[:, None] ** 1.1 * rng.lognormal(sigma=0.3, size=(40, len(x), 50))
    found = (
        stats.trend(x, [*levels], stats.loglog_slope, seed=seed)
        for seed, levels in enumerate(trials)
    )
    assert covering(found, 1.1) >= 0.93 * 40 - binomial_room(40, 0.93)


def test_median_ratio_and_welch_agree_in_sign():
    rng = np.random.default_rng(7)
    small, large = rng.normal(1, 0.1, 50), rng.normal(2, 0.1, 50)
    ratio = stats.median_ratio(large, small)
    assert ratio.low < 2 < ratio.high
    assert stats.welch_less(small, large) < 1e-6
    assert stats.welch_less(large, small) > 0.99


@pytest.mark.parametrize("statistic", ["median", "mean"])
def test_median_ratio_resamples_pairs(statistic):
    """What both trials of a pair share is no scatter of their ratio."""
    trials = np.random.default_rng(3).lognormal(0, 1, 60)
    both = stats.ratio_of(statistic, 1.2 * trials, trials, paired=True)
    assert (both.low, both.high) == pytest.approx((1.2, 1.2))
    apart = stats.ratio_of(statistic, 1.2 * trials, trials)
    assert apart.low < 1 < 1.4 < apart.high


FAILED = np.full(50, np.nan)
GOOD = np.linspace(1.0, 2.0, 50)
MOSTLY_FAILED = np.where(np.arange(50) < 30, np.nan, GOOD)


def test_median_ratio_of_two_failures_is_undetermined():
    for trials in (FAILED, MOSTLY_FAILED):
        ratio = stats.median_ratio(trials, trials)
        assert ratio.above(1.0) == ratio.below(1.0) == "undecided"
    assert stats.median_ratio(FAILED, GOOD).above(1.0) == "holds"
    assert stats.median_ratio(GOOD, FAILED).below(1.0) == "holds"


def test_wins_treats_common_failures_as_ties():
    few = np.where(np.arange(50) < 10, np.nan, GOOD)
    (found,) = stats.wins([(few, 2 * few)])
    assert (found.ratio.value, found.decision) == (pytest.approx(2), "holds")
    (found,) = stats.wins([(FAILED, FAILED)])
    assert (found.p, found.decision) == (1.0, "undecided")


def test_wins_requires_fifty_trials():
    assert stats.wins([(GOOD, 2 * GOOD)])[0].decision == "holds"
    assert stats.wins([(GOOD[:49], 2 * GOOD[:49])])[0].decision == "undecided"
    assert stats.wins([(2 * GOOD[:49], GOOD[:49])])[0].decision == "fails"


def test_trend_failure_equals_worst_of_level():
    x = np.array([1.0, 2.0, 3.0])
    failing = np.where(np.arange(50) % 3, GOOD, np.nan)
    as_worst = np.where(np.isnan(failing), np.nanmax(failing), failing)
    found, same = (
        stats.trend(x, [GOOD, t, 2 * GOOD], stats.loglog_slope)
        for t in (failing, as_worst)
    )
    assert found == same._replace(failed=17)


def test_trend_resamples_levels_independently():
    found = stats.trend(np.array([1.0, 2.0]), [GOOD, GOOD], stats.loglog_slope)
    assert found.value == pytest.approx(0, abs=1e-12)
    assert found.low < -0.05 < 0.05 < found.high


def test_trend_without_success_is_undetermined():
    found = stats.trend(
        np.array([1.0, 2.0, 3.0]), [GOOD, FAILED, GOOD], stats.loglog_slope
    )
    assert (found.within(0.85, 1.15), found.failed) == ("undecided", 50)


def test_welch_handles_no_success_and_no_scatter():
    assert stats.welch_less(FAILED, FAILED) == 1.0
    assert stats.welch_less(GOOD, FAILED) < 1e-6
    assert stats.welch_less(FAILED, GOOD) > 0.99
    constant = np.ones(50)
    assert stats.welch_less(constant, 2 * constant) == 0.0
    assert stats.welch_less(constant, constant) == 1.0


def test_welch_matches_scipy():
    rng = np.random.default_rng(14)
    a, b = rng.normal(1.0, 1.0, 6), rng.normal(1.6, 2.0, 9)
    theirs = ttest_ind(a, b, equal_var=False, alternative="less").pvalue
    assert stats.welch_less(a, b) == pytest.approx(theirs, rel=1e-12)


@pytest.mark.parametrize(
    ("test", "first", "second", "seed", "runs", "level"),
    [
        (lambda a, b: stats.wins([(a, b)])[0].p, (9, 1), (9, 1), 5, 100, 0.05),
        (stats.welch_less, (0, 1), (0, 3), 8, 400, 0.01),
    ],
    ids=["wins", "welch"],
)
def test_false_positive_rate_is_near_level(test, first, second, seed, runs, level):
    rng = np.random.default_rng(seed)
    p = [test(rng.normal(*first, 50), rng.normal(*second, 50)) for _ in range(runs)]
    assert np.sum(np.array(p) < level) <= level * runs + binomial_room(runs, level)


def test_mcnemar_uses_discordant_trials_only():
    a = np.array([True] * 5 + [False] * 10 + [True] * 30)
    b = np.array([True] * 4 + [False] + [True] * 9 + [False] + [True] * 30)
    # One lost, nine gained: twice the tail of ten fair coins.
    assert stats.mcnemar(a, b) == pytest.approx(2 * (1 + 10) / 1024)
    assert stats.mcnemar(a, a) == 1.0


def test_mcnemar_matches_binomial():
    only, rest = np.ones(6, bool), np.zeros(6, bool)
    assert stats.mcnemar(only, rest) == pytest.approx(2 / 2**6)
    published = stats.mcnemar(
        np.arange(60) < 27, (np.arange(60) >= 27) & (np.arange(60) < 29)
    )
    assert published == pytest.approx(2 * (1 + 29 + 406) / 2**29)
