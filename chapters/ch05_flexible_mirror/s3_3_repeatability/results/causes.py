"""Causes of error growth: what the steps see, and the board's known metric."""

import numpy as np
from scipy.stats import wilcoxon

from chapters.ch05_flexible_mirror.s3_3_repeatability.results.runs import (
    BACK,
    STEPS,
    THERE,
)
from chapters.ch05_flexible_mirror.s3_3_repeatability.trials.metric import ARMS
from chapters.shared.mirror_sweep import BenchRuns
from repro.judge.statistics import HOLDS, UNDECIDED, median_interval, with_worst

CONDITIONED = ("exp_c5_concave_conditioning", "exp_c5_concave_conditioning_swept")
METRIC = "exp_c5_metric_fit_helps"
MEASURES = ("covered", "reciprocal")
MAX_P = 0.05


class LoopSights(BenchRuns):
    """Measures of what the steps of a loop see, at one error level."""

    EXPERIMENTS = CONDITIONED
    SWINGS = tuple(f"step{step}" for step in STEPS)

    def of_steps(self, name):
        """A measure (steps, seeds) of all steps, nan from the rejected one on."""
        return np.array([self.at_place(place, name) for place in self.SWINGS])

    def back_over_out(self, name):
        """Mean of a measure over the steps back, over that of the steps out,
        (seeds,)."""
        found = self.of_steps(name)
        out, back = (
            found[np.subtract(steps, 1)].mean(axis=0) for steps in (THERE, BACK)
        )
        return back / out


def better_conditioned(seen):
    """Whether steps back cover more and are better conditioned, run by run, as
    `counterpart` uses it."""
    least = np.min([seen.back_over_out(name) for name in MEASURES], axis=0)
    with np.errstate(invalid="ignore"):
        return least > 1, least, "x", "steps back over steps out, the lesser of both"


def errors_of(result, arm, name="back_mm"):
    """Errors (steps, seeds) of one arm, nan from the step on that was rejected."""
    return np.array([result.column(f"{arm}.step{k}.{name}") for k in STEPS])


def rates(errors):
    """Slopes (seeds,) of errors (steps, seeds) on the step's number, per step."""
    x = np.arange(len(errors)) - (len(errors) - 1) / 2
    return x @ errors / (x @ x)


def without_less_metric(result, name="back_mm"):
    """Growth without the metric less that with it, (seeds,), per step; infinite where
    only that without was rejected, minus infinite where only the other was, nan where
    both were."""
    metric, without = (with_worst(rates(errors_of(result, arm, name))) for arm in ARMS)
    with np.errstate(invalid="ignore"):
        return without - metric


def while_both_go_on(result, name="back_mm"):
    """The same over the steps that both arms reach, of runs with two or more."""
    metric, without = (errors_of(result, arm, name) for arm in ARMS)
    reached = np.isfinite(metric + without).sum(axis=0)
    return np.array(
        [
            rates(without[:n, seed]) - rates(metric[:n, seed])
            for seed, n in enumerate(reached)
            if n >= 2
        ]
    )


def p_larger(differences):
    """One-sided p (Wilcoxon's signed ranks) that differences (n,) are above 0; infinite
    ones outrank all others."""
    finite = np.abs(differences[np.isfinite(differences)])
    largest = 1 + finite.max(initial=0)
    ranked = np.clip(differences, -largest, largest)
    return float(wilcoxon(ranked, alternative="greater").pvalue) if ranked.any() else 1


def decision_of(differences):
    """(decision, Estimate of the median, p): larger, if p and the median's interval
    support it."""
    middle, p = median_interval(differences), p_larger(differences)
    decision = middle.above(0.0)
    return (UNDECIDED if decision == HOLDS and p >= MAX_P else decision), middle, p


def refused(result, arm):
    """Number of runs of an arm that ended before the sixth step."""
    return sum(text is not None for text in result.texts(f"{arm}.refused"))
