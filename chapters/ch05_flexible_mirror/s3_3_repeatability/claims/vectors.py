"""Claims about the vectors of Fig. 5.13: causes and countermeasures."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_repeatability.results import causes
from chapters.ch05_flexible_mirror.s3_3_repeatability.results.relief import ReliefRuns
from chapters.ch05_flexible_mirror.s3_3_repeatability.results.runs import (
    BACK,
    PANELS,
    THERE,
    LoopRuns,
)
from chapters.ch05_flexible_mirror.s3_3_repeatability.results.vectors import (
    below_at_the_edge,
    edge_ratios,
)
from chapters.shared.mirror_sweep import (
    READINGS,
    counterpart_over_the_sweep,
    on_completed,
)
from repro.judge.statistics import all_of
from repro.run.experiment import claim
from repro.run.outcomes import Reading
from repro.run.readings import Case

MIN_REMOVED = 50.0


@claim(
    "c5_fixed_edge_low",
    needs=("table_5_5_runs", "table_5_5_swept"),
    evidence="rendered",
    readings=("mirror_bench", "swinging_ends"),
)
def judge_fixed_edge(results, options):
    """Mean error at the board's edge next to the clamp, below that of all corners.

    Judged run by run: below in all four panels. Fixed before: the edge is, in each
    row of the board, the visible corner nearest to the clamp; errors are those of
    the figure, in the fitted pose.
    """
    case = Case(READINGS, options)

    def found_at(bench):
        runs = LoopRuns(results, options, bench)
        below, worst, unit, said = below_at_the_edge(runs)
        panels = []
        for place in PANELS:
            ratios = edge_ratios(runs, place)
            known = ratios[np.isfinite(ratios)]
            panels.append(f"{place} {np.count_nonzero(known < 1)} of {len(known)}")
        said += f"; below in each panel, of the seeds with it: {', '.join(panels)}"
        return below, worst, unit, said

    return counterpart_over_the_sweep(case, found_at)


@claim(
    "c5_concave_conditioning",
    needs=("exp_c5_concave_conditioning", "exp_c5_concave_conditioning_swept"),
    evidence="rendered",
    readings=("mirror_bench", "swinging_ends"),
)
def judge_conditioning(results, options):
    """Covered mirror and reciprocal condition number, larger for the steps back.

    Judged run by run, on means over the three steps each way; both must be larger.
    Fixed before: the covered share is that of the convex hull of the common corners on
    the sheet after the step; the matrix is the linear stage's, equilibrated, in the
    clamp's subspace.
    """

    def found_at(bench):
        seen = causes.LoopSights(results, options, bench)
        better, least, unit, said = causes.better_conditioned(seen)
        said += "; medians out and back: " + "; ".join(
            f"{words} {_middle(seen, name, THERE):.2g} and "
            f"{_middle(seen, name, BACK):.2g}, larger in "
            f"{np.sum(seen.back_over_out(name) > 1)}"
            for name, words in (("covered", "share"), ("reciprocal", "reciprocal"))
        )
        return better, least, unit, said

    return counterpart_over_the_sweep(Case(READINGS, options), found_at)


def _middle(seen, name, steps):
    """Median over runs of a measure's mean over some steps, of those that have it."""
    found = seen.of_steps(name)[np.subtract(steps, 1)].mean(axis=0)
    known = found[np.isfinite(found)]
    return float(np.median(known)) if len(known) else np.nan


@claim("c5_metric_fit_helps", needs=("exp_c5_metric_fit_helps",), evidence="rendered")
def judge_metric(results):
    """Growth of the back-projection error over six steps, without the metric and with.

    The rate is the slope of the line through the means of the six steps, in the pose
    that the calibration finds, as `c5_no_accumulation` uses it, and of each run that
    both arms complete.
    """
    result = results[causes.METRIC]
    differences = causes.without_less_metric(result)
    angle = causes.while_both_go_on(result, "angle_deg")
    lost = {arm: causes.refused(result, arm) for arm in causes.ARMS}

    def judge(seeds):
        # Rejected in both arms: no difference.
        found = np.where(np.isnan(differences), 0.0, differences)[seeds]
        decision, middle, p = causes.decision_of(found)
        return Reading.of(
            decision,
            middle,
            "mm",
            f"growth for each step without the metric, less that with it; p = {p:.1g}; "
            f"rejected without the metric {lost['without']}, with it "
            f"{lost['metric']}; over the steps that both reach, of the rays, "
            f"{_median(angle):.2g} degrees a step",
        )

    return on_completed(np.isfinite(differences), judge)


def _median(values):
    return float(np.median(values)) if len(values) else np.nan


@claim("c5_high_order", needs=("exp_c5_high_order",), evidence="rendered")
def judge_high_order(results):
    """Relief raises the residual at stage 0, and more functions take half of that away.

    Fixed before: the residual is that of Fig. 5.13(a), the mean back-projection error
    on a board at 400 mm in the pose that the calibration finds; relief is that of the
    first solved level; the removed share is that of the rise over a smooth mirror,
    which keeps its own residual with either number of functions.
    """
    relief = ReliefRuns.of(results)
    rise, removed = relief.rise(), relief.removed()
    other = relief.rise("residual_mm"), relief.removed("residual_mm")
    return Reading.of(
        all_of([rise.above(1.0), removed.above(np.nextafter(MIN_REMOVED, 0))]),
        removed,
        "%",
        f"of the rise by relief; with few functions it is {rise.value:.2f} times the "
        f"smooth mirror's ({rise.low:.2f} to {rise.high:.2f}); of the refinement's own "
        f"distances {other[1].value:.0f} %, raised {other[0].value:.2f} times; of the "
        f"angles to the true rays {relief.removed('angle_deg').value:.0f} %",
    )
