"""The claims of section 4.1.5, tested as the ledger words them."""

from __future__ import annotations

import numpy as np

from chapters.ch04_central_generic.s1_5_simulated.results import (
    QUANTITIES,
    WORDS,
    cases,
)
from chapters.ch04_central_generic.s1_5_simulated.trials import LEVELS
from chapters.shared.synthetic_readings import readings_of
from repro.judge.statistics import FAILS, HOLDS, all_of, bootstrap, median_ratio, wins
from repro.run.experiment import claim, numbers
from repro.run.outcomes import Value

REDRAWN, FIXED = "fig_4_2_redrawn", "fig_4_2_fixed"
SWEEP = ("fig_4_2_redrawn",)
BOTH_SWEEPS = ("fig_4_2_redrawn", "fig_4_2_fixed")
ALL = ("noise", "standard_method")
SWEEPS = (*ALL, "translation_error", "ray_point")
POSES = (*ALL, "translation_error")
LEAST_GAIN, HALF, LEAST_SPREAD = 0.8, 0.5, 3.0


def _ahead(result, case, better, worse, quantities):
    """wins(better < worse) for each quantity at every level.

    Returns the decision, the least ratio of medians with its interval, and where that
    is, in words.
    """
    compared = {
        (quantity, level): found
        for quantity in quantities
        for level, found in zip(
            LEVELS,
            wins(
                [
                    tuple(
                        case.trials(result, *which, quantity, level)
                        for which in (better, worse)
                    )
                    for level in LEVELS
                ]
            ),
            strict=True,
        )
    }
    at = min(compared, key=lambda key: compared[key].ratio.value)
    least = compared[at].ratio
    held = sum(found.decision == HOLDS for found in compared.values())
    words = WORDS.get(at[0], "moved points")
    return (
        all_of([found.decision for found in compared.values()]),
        least.value,
        (least.low, least.high),
        f"least ratio of the medians: {words} at {at[1]:g}; ahead in {held} "
        f"of {len(compared)} comparisons",
    )


@claim("c4_cgsp_beats_std_ba", needs=SWEEP, evidence="synthetic")
def judge_beats_adjusted(results):
    """CGSP as it comes out against the adjusted standard method."""
    return readings_of(
        cases(*SWEEPS),
        lambda case: _ahead(
            results[REDRAWN], case, ("cgsp", "linear"), ("standard", "ba"),
            QUANTITIES,
        ),
    )  # fmt: skip


@claim("c4_cgsp_beats_std", needs=SWEEP, evidence="synthetic")
def judge_beats_linear(results):
    """CGSP against the standard method, both as they come out."""
    return readings_of(
        cases(*SWEEPS),
        lambda case: _ahead(
            results[REDRAWN], case, ("cgsp", "linear"),
            ("standard", "linear"), QUANTITIES,
        ),
    )  # fmt: skip


@claim("c4_ba_little_gain", needs=SWEEP, evidence="synthetic")
def judge_little_gain(results):
    """Ray-point error falls; no pose error by more than 20 %."""
    result = results[REDRAWN]

    def judge(case):
        linear, adjusted = ("standard", "linear"), ("standard", "ba")
        fall = _ahead(result, case, adjusted, linear, ("ray",))
        left = {
            (quantity, level): bootstrap(
                _ratio_of_medians,
                case.trials(result, *adjusted, quantity, level),
                case.trials(result, *linear, quantity, level),
                paired=True,
            )
            for quantity in QUANTITIES[1:5]
            for level in LEVELS
        }
        at = min(left, key=lambda key: left[key].value)
        least = left[at]
        little = all_of([found.above(LEAST_GAIN) for found in left.values()])
        return (
            all_of([fall[0], little]),
            least.value,
            (least.low, least.high),
            f"least ratio after / before: {WORDS[at[0]]} at {at[1]:g}; "
            f"ray-point error before / after at least {fall[1]:.2f}",
        )

    return readings_of(cases(*SWEEPS), judge)


def _ratio_of_medians(a, b):
    return np.median(a, axis=-1) / np.median(b, axis=-1)


@claim("c4_ba_rotation_worse", needs=SWEEP, evidence="synthetic")
def judge_rotation_worse(results):
    """Median rotation error grows at most levels, by the sign test."""
    from scipy.stats import binomtest

    result = results[REDRAWN]

    def judge(case):
        worse, ratios = 0, []
        for level in LEVELS:
            before, after = (
                np.concatenate(
                    [
                        case.trials(result, "standard", stage, q, level)
                        for q in ("r2", "r3")
                    ]
                )
                for stage in ("linear", "ba")
            )
            up, down = np.sum(after > before), np.sum(after < before)
            p = binomtest(int(up), int(up + down), alternative="greater").pvalue
            ratio = median_ratio(after, before)
            ratios.append(ratio)
            worse += ratio.value > 1 and p < 0.05
        middle = sorted(ratios, key=lambda found: found.value)[len(ratios) // 2]
        return (
            HOLDS if worse > len(LEVELS) / 2 else FAILS,
            middle.value,
            (middle.low, middle.high),
            f"after / before at the middle level of that ratio; larger, by "
            f"the sign test, at {worse} of {len(LEVELS)} levels",
        )

    return readings_of(cases(*ALL), judge)


@claim("c4_ba_points_better", needs=SWEEP, evidence="synthetic")
def judge_points_better(results):
    """The adjusted poses put the points nearer to where they are."""
    return readings_of(
        cases(*ALL),
        lambda case: _ahead(
            results[REDRAWN], case, ("standard", "ba"),
            ("standard", "linear"), ("point_mm",),
        ),
    )  # fmt: skip


@claim("c4_ba_centre_cause", needs=SWEEP, evidence="synthetic")
def judge_centre_cause(results):
    """About the true centre, the adjusted pose errors are half or less."""
    result = results[REDRAWN]

    def judge(case):
        left = {
            (quantity, level): bootstrap(
                _ratio_of_medians,
                case.trials(result, "standard", "ba_true_centre", quantity, level),
                case.trials(result, "standard", "ba", quantity, level),
                paired=True,
            )
            for quantity in QUANTITIES[1:5]
            for level in LEVELS
        }
        at = max(left, key=lambda key: left[key].value)
        most = left[at]
        return (
            all_of([found.below(HALF) for found in left.values()]),
            most.value,
            (most.low, most.high),
            f"largest ratio true / estimated centre: {WORDS[at[0]]} at {at[1]:g}",
        )

    return readings_of(cases(*POSES), judge)


@claim("c4_sd_smaller", needs=BOTH_SWEEPS, evidence="synthetic")
def judge_sd_smaller(results):
    """Scatter of the standard method at least three times that of CGSP."""

    def judge(case):
        found = {
            (name, quantity, level): bootstrap(
                lambda a, b: _scatter(a) / _scatter(b),
                case.trials(results[name], "standard", "linear", quantity, level),
                case.trials(results[name], "cgsp", "linear", quantity, level),
                paired=True,
            )
            for name in (REDRAWN, FIXED)
            for quantity in QUANTITIES
            for level in LEVELS
        }
        at = min(found, key=lambda key: found[key].value)
        least = found[at]
        where = "poses redrawn" if at[0] == REDRAWN else "one configuration"
        held = sum(one.above(LEAST_SPREAD) == HOLDS for one in found.values())
        return (
            all_of([one.above(LEAST_SPREAD) for one in found.values()]),
            least.value,
            (least.low, least.high),
            f"least ratio of the median absolute deviations: {WORDS[at[1]]} "
            f"at {at[2]:g}, {where}; at least {LEAST_SPREAD:g} in {held} of "
            f"{len(found)}",
        )

    return readings_of(cases(*SWEEPS), judge)


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
