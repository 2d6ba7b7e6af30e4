"""The judgements of this page's claims."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_repeatability.experiment import (
    DEFLECTIONS_MM,
    STEPS_MM,
)
from chapters.ch05_flexible_mirror.s3_3_repeatability.report import (
    ARMS,
    BACK,
    JUDGED,
    MAX_DIFFERENT,
    MAX_GROWTH,
    MAX_SD,
    MAX_WORSE,
    METRIC,
    MIN_REDUCTION,
    MIN_SD_MM,
    PANELS,
    PLACED,
    STARTED,
    STEPS,
    THERE,
    LoopRuns,
    LoopSights,
    ReliefRuns,
    below_at_the_edge,
    better_conditioned,
    decision_of,
    edge_ratios,
    error_growth,
    in_places,
    loop_closes,
    loop_ratio,
    pooled_sd,
    reduction,
    refused,
    scatter_of_starts,
    single_difference,
    steps_agree,
    while_both_go_on,
    without_less_metric,
)
from chapters.shared.mirror import (
    READINGS,
    counterpart_over_the_sweep,
    on_completed,
    over_completed,
    over_the_sweep,
)
from repro.run import (
    HOLDS,
    SIGNIFICANCE,
    UNDECIDED,
    Case,
    Reading,
    all_of,
    claim,
    median_interval,
    wins,
)

# The claims about repeated deflections, tested as the registry words them.


# Questions of the registry.
OPEN = ("mirror_bench", "swinging_ends")
LEVELS = ("mirror_bench",)


def _case(options):
    return Case(READINGS, options)


@claim("c5_convex_concave", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_equivalent_steps(results, options):
    """Test that equivalent steps agree within 6 %."""
    return LoopRuns.judged_by_seed(results, options, steps_agree)


@claim("c5_hysteresis", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_loop(results, options):
    """Test that the sums of steps out and back agree within 0.3 mm."""
    return LoopRuns.judged_by_seed(results, options, loop_closes)


@claim("c5_single_equals_staged", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_single_step(results, options):
    """Test that the single step is within 1 % of the three: the median over runs."""

    def differences(bench):
        return single_difference(LoopRuns(results, options, bench))

    def middle(bench, seeds):
        return median_interval(differences(bench)[seeds])

    def reading_of(bench, seeds):
        found = middle(bench, seeds)
        decision = found.below(np.nextafter(MAX_DIFFERENT, 2))
        return Reading.of(decision, found, "%", "difference without sign")

    return over_completed(
        _case(options),
        lambda bench: np.isfinite(differences(bench)),
        reading_of,
        lambda bench, seeds: middle(bench, seeds).value <= MAX_DIFFERENT,
    )


@claim("c5_single_worse_bp", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_single_back_projection(results, options):
    """wins(staged < single) in back-projection at stage 0, as the thesis has it."""
    return _judged_wins(
        results, options, (f"step{BACK[-1]}", "single"), "single over staged"
    )


@claim("c5_some_increase", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_increase(results, options):
    """Back-projection at stage 0 after six steps over that of the primary stage."""
    return _judged_wins(
        results,
        options,
        ("start", f"step{STEPS[-1]}"),
        "after six steps over before",
        least=1.0,
    )


def _judged_wins(results, options, places, words, least=None):
    """The Reading of wins(first < second) in back-projection at two places of the loop.

    least: a ratio above which the interval has to lie, in place of what `wins` asks.
    """

    def pair_of(bench, name="back_mm"):
        runs = LoopRuns(results, options, bench)
        return [runs.of(place, name) for place in places]

    def won(bench, seeds, name="back_mm"):
        return wins([tuple(one[seeds] for one in pair_of(bench, name))])[0]

    def reading_of(bench, seeds):
        found = won(bench, seeds)
        decision = found.decision
        if least is not None:
            decision = found.ratio.above(least)
            if decision == HOLDS and not found.p < SIGNIFICANCE:
                decision = UNDECIDED
        true = won(bench, seeds, "back_true_mm").ratio.value
        reason = f"{words}; p = {found.p:.1g}; on the board's true pose {true:.2f}"
        return Reading.of(decision, found.ratio, "x", reason)

    return over_completed(
        _case(options),
        lambda bench: np.isfinite(pair_of(bench)).all(axis=0),
        reading_of,
        lambda bench, seeds: won(bench, seeds).ratio.value > 1,
    )


def _completed(results, options):
    """bench -> which runs (seeds,) completed all six steps."""
    return lambda bench: LoopRuns(results, options, bench).completed


@claim("c5_no_accumulation", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_accumulation(results, options):
    """Slope of the back-projection error over the six steps, at most 5 % a step."""

    def growth(bench, seeds, name="back_mm"):
        return error_growth(LoopRuns(results, options, bench), name, seeds)

    def reading_of(bench, seeds):
        found, true = (growth(bench, seeds, n) for n in ("back_mm", "back_true_mm"))
        return Reading.of(
            found.below(np.nextafter(MAX_GROWTH, 9)),
            found,
            "%",
            f"rise of the medians for each of {len(STEPS)} steps, of the line's first "
            f"value; on the board's true pose {true.value:.1f} ({true.low:.1f} to "
            f"{true.high:.1f}) %",
        )

    return over_completed(
        _case(options),
        _completed(results, options),
        reading_of,
        lambda bench, seeds: growth(bench, seeds).value <= MAX_GROWTH,
    )


@claim("c5_concave_harmless", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_concave_steps(results, options):
    """Back-projection after the three steps back, at most 1.2 times that before."""

    def ratio(bench, seeds, name="back_mm"):
        runs = LoopRuns(results, options, bench)
        after, before = runs.at(name, (BACK[-1], BACK[0] - 1))[:, seeds]
        return loop_ratio(after, before)

    def reading_of(bench, seeds):
        found, true = (ratio(bench, seeds, n) for n in ("back_mm", "back_true_mm"))
        return Reading.of(
            found.below(np.nextafter(MAX_WORSE, 2)),
            found,
            "x",
            "after six steps over after three; on the board's true pose "
            f"{true.value:.2f}",
        )

    return over_completed(
        _case(options),
        _completed(results, options),
        reading_of,
        lambda bench, seeds: ratio(bench, seeds).value <= MAX_WORSE,
    )


def _refused_places(result, bench):
    """Number of rejected calibrations, in words."""
    lost = {
        pitch: int(np.nansum(result.column(f"{bench}.refused_{pitch}")))
        for pitch in ("coarse", "dense")
    }
    whole = in_places(result, bench, "coarse").size
    return f"rejected of {whole}: {lost['coarse']}, with half the pitch {lost['dense']}"


@claim(
    "c5_t55_better_t51",
    needs=("exp_c5_dense_grid",),
    evidence="rendered",
    readings=LEVELS,
)
def judge_placement(results, options):
    """SD of the first step's deflection between poses of the board alone."""
    result = results[PLACED]

    def reading_at(bench):
        found = pooled_sd(result, bench)
        return Reading.of(
            found.above(np.nextafter(MIN_SD_MM, 0)),
            found,
            "mm",
            f"SD between places, all else held; {_refused_places(result, bench)}",
        )

    def on_side(bench):
        return pooled_sd(result, bench).value >= MIN_SD_MM

    return over_the_sweep(_case(options), reading_at, on_side)


@claim(
    "c5_dense_grid", needs=("exp_c5_dense_grid",), evidence="rendered", readings=LEVELS
)
def judge_dense_grid(results, options):
    """Test that half the pitch removes a fifth of the SD between board poses."""
    result = results[PLACED]

    def reading_at(bench):
        found = reduction(result, bench)
        return Reading.of(
            found.above(np.nextafter(MIN_REDUCTION, 0)),
            found,
            "%",
            f"less SD between places; {_refused_places(result, bench)}",
        )

    def on_side(bench):
        return reduction(result, bench).value >= MIN_REDUCTION

    return over_the_sweep(_case(options), reading_at, on_side)


@claim(
    "c5_not_sensitive_init",
    needs=("exp_c5_not_sensitive_init",),
    evidence="rendered",
    readings=LEVELS,
)
def judge_starts(results, options):
    """SD of the results of perturbed starts, 1 % of the deflection in both steps."""
    result = results[STARTED]

    def of_starts(bench):
        return {
            step: scatter_of_starts(result, bench, step, mm)
            for step, mm in STEPS_MM.items()
        }

    def middles(bench, seeds):
        return {s: median_interval(sd[seeds]) for s, sd in of_starts(bench).items()}

    def reading_of(bench, seeds):
        found = middles(bench, seeds)
        bound = np.nextafter(MAX_SD, 2)
        said = ", ".join(f"{step} mm {one.value:.2g} %" for step, one in found.items())
        return Reading.of(
            all_of([one.below(bound) for one in found.values()]),
            max(found.values(), key=lambda one: one.value),
            "%",
            f"SD of the deflection, the larger of two steps: {said}",
        )

    return over_completed(
        _case(options),
        lambda bench: np.isfinite([*of_starts(bench).values()]).all(axis=0),
        reading_of,
        lambda bench, seeds: all(
            one.value <= MAX_SD for one in middles(bench, seeds).values()
        ),
    )


@claim("c5_feature_loss", needs=("exp_c5_feature_loss",), evidence="synthetic")
def judge_lost_features(results):
    """Going back, the mean number of common corners falls with every deflection."""
    found = results["exp_c5_feature_loss"]
    back, out = (np.mean(found.arrays(way), axis=0) for way in ("back", "out"))
    least = -np.diff(back).max()
    numbers = ", ".join(f"{count:.0f}" for count in back)
    return Reading.of(
        bool(least > 0),
        float(least),
        "count",
        "least loss from one deflection to the next on the way back from stage 3, of "
        f"means over {found.trials_per_condition} places of the board: {numbers} "
        "common corners after "
        + ", ".join(f"{mm:g}" for mm in DEFLECTIONS_MM)
        + f" mm; out, where the view widens, {out[0]:.0f} to {out[-1]:.0f}",
    )


# Claims about the vectors of Fig. 5.13: causes and countermeasures.


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
        seen = LoopSights(results, options, bench)
        better, least, unit, said = better_conditioned(seen)
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
    result = results[METRIC]
    differences = without_less_metric(result)
    angle = while_both_go_on(result, "angle_deg")
    lost = {arm: refused(result, arm) for arm in ARMS}

    def judge(seeds):
        # Rejected in both arms: no difference.
        found = np.where(np.isnan(differences), 0.0, differences)[seeds]
        decision, middle, p = decision_of(found)
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
