"""Tests of the claims of section 4.1.5, as the registry states them."""

from itertools import product

import numpy as np

from chapters.ch04_central_generic.s1_5_simulated.results import (
    QUANTITIES,
    WORDS,
    NoiseCase,
)
from chapters.ch04_central_generic.s1_5_simulated.trials import LEVELS
from repro.judge.statistics import HOLDS, all_of, bootstrap, ratio_of, wins
from repro.run.experiment import claim, numbers
from repro.run.outcomes import Reading, Value

REDRAWN, FIXED = "fig_4_2_redrawn", "fig_4_2_fixed"
SWEEP = ("fig_4_2_redrawn",)
BOTH_SWEEPS = ("fig_4_2_redrawn", "fig_4_2_fixed")
STATISTIC = "statistic_of_trials"
ALL = ("noise", "standard_method", "statistic_of_trials")
POSES = ("noise", "standard_method", "translation_error", "statistic_of_trials")
SPREAD = ("noise", "standard_method", "translation_error", "ray_point")
SWEEPS = (
    "noise",
    "standard_method",
    "translation_error",
    "ray_point",
    "statistic_of_trials",
)
MIN_GAIN, HALF, MIN_SPREAD = 0.8, 0.5, 3.0
LINEAR, ADJUSTED = ("standard", "linear"), ("standard", "ba")
ABOUT_TRUE_CENTRE, CGSP = ("standard", "ba_true_centre"), ("cgsp", "linear")


def _ahead(results, options, better, worse, quantities=QUANTITIES):
    """wins(better < worse) for each quantity at every level.

    Returns the decision, the least ratio of the medians or means, and where that is,
    in words.
    """
    case, compared = NoiseCase(options), {}
    for quantity in quantities:
        pairs = [
            tuple(
                case.trials(results[REDRAWN], *which, quantity, level)
                for which in (better, worse)
            )
            for level in LEVELS
        ]
        won = wins(pairs, case[STATISTIC])
        compared |= zip(product([quantity], LEVELS), won, strict=True)
    at = min(compared, key=lambda key: compared[key].ratio.value)
    held = sum(found.decision == HOLDS for found in compared.values())
    words = WORDS.get(at[0], "moved points")
    return (
        all_of([found.decision for found in compared.values()]),
        compared[at].ratio,
        f"least ratio of the {case[STATISTIC]}s: {words} at {at[1]:g}; ahead in {held} "
        f"of {len(compared)} comparisons",
    )


def _judged_ahead(*given, **named):
    decision, least, words = _ahead(*given, **named)
    return Reading.of(decision, least, reason=words)


@claim("c4_cgsp_beats_std_ba", needs=SWEEP, evidence="synthetic", readings=SWEEPS)
def judge_beats_adjusted(results, options):
    """Unadjusted CGSP against the adjusted standard method."""
    return _judged_ahead(results, options, CGSP, ADJUSTED)


@claim("c4_cgsp_beats_std", needs=SWEEP, evidence="synthetic", readings=SWEEPS)
def judge_beats_linear(results, options):
    """CGSP against the standard method, both unadjusted."""
    return _judged_ahead(results, options, CGSP, LINEAR)


@claim("c4_ba_points_better", needs=SWEEP, evidence="synthetic", readings=ALL)
def judge_points_better(results, options):
    """The adjusted poses put the points closer to their true positions."""
    return _judged_ahead(results, options, ADJUSTED, LINEAR, ("point_mm",))


def _pose_ratios(results, options, over, under):
    """Ratio of the pose errors of two stages: (quantity, level) -> Estimate."""
    case, result = NoiseCase(options), results[REDRAWN]
    return {
        (quantity, level): ratio_of(
            case[STATISTIC],
            case.trials(result, *over, quantity, level),
            case.trials(result, *under, quantity, level),
            paired=True,
        )
        for quantity, level in product(QUANTITIES[1:5], LEVELS)
    }


@claim("c4_ba_little_gain", needs=SWEEP, evidence="synthetic", readings=SWEEPS)
def judge_little_gain(results, options):
    """Ray-point error falls; no pose error by more than 20 %."""
    falls, fall, _ = _ahead(results, options, ADJUSTED, LINEAR, ("ray",))
    left = _pose_ratios(results, options, ADJUSTED, LINEAR)
    at = min(left, key=lambda key: left[key].value)
    return Reading.of(
        all_of([falls, *(found.above(MIN_GAIN) for found in left.values())]),
        left[at],
        reason=f"least ratio after / before: {WORDS[at[0]]} at {at[1]:g}; "
        f"ray-point error before / after at least {fall.value:.2f}",
    )


@claim("c4_ba_centre_cause", needs=SWEEP, evidence="synthetic", readings=POSES)
def judge_centre_cause(results, options):
    """About the true centre, the adjusted pose errors are half or less."""
    left = _pose_ratios(results, options, ABOUT_TRUE_CENTRE, ADJUSTED)
    at = max(left, key=lambda key: left[key].value)
    return Reading.of(
        all_of([found.below(HALF) for found in left.values()]),
        left[at],
        reason=f"largest ratio true / estimated centre: {WORDS[at[0]]} at {at[1]:g}",
    )


@claim("c4_ba_rotation_worse", needs=SWEEP, evidence="synthetic", readings=ALL)
def judge_rotation_worse(results, options):
    """The rotation error grows at most levels.

    That of the median by the sign test. In means, which depend on how much a trial
    grows, by the interval of their ratio.
    """
    case, worse, ratios = NoiseCase(options), 0, []
    of_means = case[STATISTIC] == "mean"
    for level in LEVELS:
        before, after = (
            np.concatenate(
                [
                    case.trials(results[REDRAWN], *stage, quantity, level)
                    for quantity in ("r2", "r3")
                ]
            )
            for stage in (LINEAR, ADJUSTED)
        )
        ratios.append(ratio_of(case[STATISTIC], after, before, paired=of_means))
        if of_means:
            worse += ratios[-1].above(1.0) == HOLDS
        else:
            worse += ratios[-1].value > 1 and _grows_by_sign(before, after)
    by = "the interval of the means' ratio" if of_means else "the sign test"
    middle = sorted(ratios, key=lambda found: found.value)[len(ratios) // 2]
    return Reading.of(
        worse > len(LEVELS) / 2,
        middle,
        reason=f"after / before at the middle level of that ratio; larger, by "
        f"{by}, at {worse} of {len(LEVELS)} levels",
    )


def _grows_by_sign(before, after):
    """Whether more trials grow than shrink, p < 0.05 by the sign test."""
    from scipy.stats import binomtest

    up, down = np.sum(after > before), np.sum(after < before)
    p = binomtest(int(up), int(up + down), alternative="greater").pvalue
    return p < 0.05


@claim("c4_sd_smaller", needs=BOTH_SWEEPS, evidence="synthetic", readings=SPREAD)
def judge_sd_smaller(results, options):
    """Scatter of the standard method at least three times that of CGSP."""
    case = NoiseCase(options)
    found = {
        (name, quantity, level): bootstrap(
            lambda a, b: _scatter(a) / _scatter(b),
            case.trials(results[name], *LINEAR, quantity, level),
            case.trials(results[name], *CGSP, quantity, level),
            paired=True,
        )
        for name, quantity, level in product((REDRAWN, FIXED), QUANTITIES, LEVELS)
    }
    decisions = [one.above(MIN_SPREAD) for one in found.values()]
    at = min(found, key=lambda key: found[key].value)
    where = "poses redrawn" if at[0] == REDRAWN else "one configuration"
    return Reading.of(
        all_of(decisions),
        found[at],
        reason=f"least ratio of the median absolute deviations: {WORDS[at[1]]} "
        f"at {at[2]:g}, {where}; at least {MIN_SPREAD:g} in "
        f"{decisions.count(HOLDS)} of {len(found)}",
    )


def _scatter(trials):
    """Median absolute deviation along the last axis; failures count as far off."""
    middle = np.median(trials, axis=-1, keepdims=True)
    with np.errstate(invalid="ignore"):
        return np.median(np.abs(trials - middle), axis=-1)


@numbers("fig_4_2", needs=SWEEP, evidence="synthetic")
def settings_of_fig_4_2(results):
    """The settings that the text states, as they were run."""
    result = results[REDRAWN]
    x, y, z = result.settings["centre_mm"]
    return {
        "fig4_2_cx": Value(x, unit="mm"),
        "fig4_2_cy": Value(y, unit="mm"),
        "fig4_2_cz": Value(z, unit="mm"),
        "fig4_2_fov": Value(result.settings["fov_deg"], unit="deg"),
        "fig4_2_trials": Value(result.trials_per_condition, unit="count"),
    }
