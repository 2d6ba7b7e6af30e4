"""The claims about repeated deflections, tested as the ledger words them."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_repeatability.results import predicates
from chapters.ch05_flexible_mirror.s3_3_repeatability.results.runs import (
    BACK,
    JUDGED,
    PLACED,
    STARTED,
    STEPS,
    LoopRuns,
)
from chapters.ch05_flexible_mirror.s3_3_repeatability.trials.losses import (
    DEFLECTIONS_MM,
)
from chapters.ch05_flexible_mirror.s3_3_repeatability.trials.starts import STEPS_MM
from chapters.shared.mirror_sweep import READINGS, over_the_sweep
from repro.judge.statistics import (
    HOLDS,
    SIGNIFICANCE,
    UNDECIDED,
    all_of,
    median_interval,
    wins,
)
from repro.run.experiment import claim
from repro.run.outcomes import Reading
from repro.run.readings import Case

BENCHES = ("mirror_bench",)


def _case(options):
    return Case(READINGS, options)


def _refused(runs):
    loop, single = runs.refused()
    return (
        f"of {runs.seeds} seeds {loop} ended before the sixth step, {single} without "
        "the single one"
    )


@claim("c5_convex_concave", needs=JUDGED, evidence="rendered", readings=BENCHES)
def judge_equivalent_steps(results, options):
    """Each step out and the one that undoes it, within 6 %."""
    return LoopRuns.judged_by_seed(results, options, predicates.steps_agree)


@claim("c5_hysteresis", needs=JUDGED, evidence="rendered", readings=BENCHES)
def judge_loop(results, options):
    """The sums of steps out and back, within 0.3 mm."""
    return LoopRuns.judged_by_seed(results, options, predicates.loop_closes)


@claim("c5_single_equals_staged", needs=JUDGED, evidence="rendered", readings=BENCHES)
def judge_single_step(results, options):
    """The single step within 1 % of the three: the median over seeds."""

    def found_at(bench):
        runs = LoopRuns(results, options, bench)
        return runs, median_interval(predicates.single_difference(runs))

    def reading_at(bench):
        runs, found = found_at(bench)
        decision = found.below(np.nextafter(predicates.MOST_DIFFERENT, 2))
        return Reading.of(
            decision, found, "%", f"difference without sign; {_refused(runs)}"
        )

    def on_side(bench):
        return found_at(bench)[1].value <= predicates.MOST_DIFFERENT

    return over_the_sweep(_case(options), reading_at, on_side)


@claim("c5_single_worse_bp", needs=JUDGED, evidence="rendered", readings=BENCHES)
def judge_single_back_projection(results, options):
    """wins(staged < single) in back-projection at stage 0, as the thesis has it."""

    def wins_of(bench, name):
        runs = LoopRuns(results, options, bench)
        staged, single = runs.of(f"step{BACK[-1]}", name), runs.of("single", name)
        return runs, wins([(staged, single)])[0]

    def reading_at(bench):
        runs, found = wins_of(bench, "back_mm")
        true = wins_of(bench, "back_true_mm")[1]
        return Reading.of(
            found.decision,
            found.ratio,
            "x",
            f"single over staged; p = {found.p:.1g}; on the board's true pose "
            f"{true.ratio.value:.2f}; {_refused(runs)}",
        )

    def on_side(bench):
        return wins_of(bench, "back_mm")[1].ratio.value > 1

    return over_the_sweep(_case(options), reading_at, on_side)


@claim("c5_no_accumulation", needs=JUDGED, evidence="rendered", readings=BENCHES)
def judge_accumulation(results, options):
    """Slope of the back-projection error over the six steps, at most 5 % a step."""

    def found_at(bench, name="back_mm"):
        return predicates.growth(LoopRuns(results, options, bench), name)

    def reading_at(bench):
        found, true = found_at(bench), found_at(bench, "back_true_mm")
        return Reading.of(
            found.below(np.nextafter(predicates.MOST_GROWTH, 9)),
            found,
            "%",
            f"rise of the medians for each of {len(STEPS)} steps, of the line's first "
            f"value; on the board's true pose {true.value:.1f} %; "
            f"{_refused(LoopRuns(results, options, bench))}",
        )

    def on_side(bench):
        return found_at(bench).value <= predicates.MOST_GROWTH

    return over_the_sweep(_case(options), reading_at, on_side)


@claim("c5_some_increase", needs=JUDGED, evidence="rendered", readings=BENCHES)
def judge_increase(results, options):
    """Back-projection at stage 0 after six steps over that of the primary stage."""

    def wins_of(bench, name):
        runs = LoopRuns(results, options, bench)
        start, end = runs.of("start", name), runs.of(f"step{STEPS[-1]}", name)
        return runs, wins([(start, end)])[0]

    def reading_at(bench):
        runs, found = wins_of(bench, "back_mm")
        decision = found.ratio.above(1.0)
        if decision == HOLDS and not found.p < SIGNIFICANCE:
            decision = UNDECIDED
        true = wins_of(bench, "back_true_mm")[1]
        return Reading.of(
            decision,
            found.ratio,
            "x",
            f"after six steps over before; p = {found.p:.1g}; on the board's true pose "
            f"{true.ratio.value:.2f}; {_refused(runs)}",
        )

    def on_side(bench):
        return wins_of(bench, "back_mm")[1].ratio.value > 1

    return over_the_sweep(_case(options), reading_at, on_side)


@claim("c5_concave_harmless", needs=JUDGED, evidence="rendered", readings=BENCHES)
def judge_concave_steps(results, options):
    """Back-projection after the three steps back, at most 1.2 times that before."""

    def found_at(bench, name="back_mm"):
        runs = LoopRuns(results, options, bench)
        ends = runs.at(name, (BACK[-1], BACK[0] - 1))
        return predicates.ratio(*ends)

    def reading_at(bench):
        found, true = found_at(bench), found_at(bench, "back_true_mm")
        return Reading.of(
            found.below(np.nextafter(predicates.MOST_WORSE, 2)),
            found,
            "x",
            f"after six steps over after three; on the board's true pose "
            f"{true.value:.2f}; {_refused(LoopRuns(results, options, bench))}",
        )

    def on_side(bench):
        return found_at(bench).value <= predicates.MOST_WORSE

    return over_the_sweep(_case(options), reading_at, on_side)


def _refused_places(result, bench):
    """How many calibrations were refused, in words."""
    lost = {
        pitch: int(result.column(f"{bench}.refused_{pitch}").sum())
        for pitch in ("coarse", "dense")
    }
    whole = predicates.in_places(result, bench, "coarse").size
    return f"refused of {whole}: {lost['coarse']}, with half the pitch {lost['dense']}"


@claim(
    "c5_t55_better_t51",
    needs=("exp_c5_dense_grid",),
    evidence="rendered",
    readings=BENCHES,
)
def judge_placement(results, options):
    """SD of the first step's deflection between places of the board alone."""
    result = results[PLACED]

    def reading_at(bench):
        found = predicates.pooled_sd(result, bench)
        return Reading.of(
            found.above(np.nextafter(predicates.LEAST_SD_MM, 0)),
            found,
            "mm",
            f"SD between places, all else held; {_refused_places(result, bench)}",
        )

    def on_side(bench):
        return predicates.pooled_sd(result, bench).value >= predicates.LEAST_SD_MM

    return over_the_sweep(_case(options), reading_at, on_side)


@claim(
    "c5_dense_grid", needs=("exp_c5_dense_grid",), evidence="rendered", readings=BENCHES
)
def judge_dense_grid(results, options):
    """Half the pitch takes a fifth of the SD between places."""
    result = results[PLACED]

    def reading_at(bench):
        found = predicates.reduction(result, bench)
        return Reading.of(
            found.above(np.nextafter(predicates.LEAST_REDUCTION, 0)),
            found,
            "%",
            f"less SD between places; {_refused_places(result, bench)}",
        )

    def on_side(bench):
        return predicates.reduction(result, bench).value >= predicates.LEAST_REDUCTION

    return over_the_sweep(_case(options), reading_at, on_side)


@claim(
    "c5_not_sensitive_init",
    needs=("exp_c5_not_sensitive_init",),
    evidence="rendered",
    readings=BENCHES,
)
def judge_starts(results, options):
    """SD of what perturbed starts end at, 1 % of the deflection in both steps."""
    result = results[STARTED]

    def found_at(bench):
        return {
            step: median_interval(predicates.of_starts(result, bench, step, mm))
            for step, mm in STEPS_MM.items()
        }

    def reading_at(bench):
        found = found_at(bench)
        worst = max(found.values(), key=lambda one: one.value)
        bound = np.nextafter(predicates.MOST_SD, 2)
        said = ", ".join(
            f"{step} mm {one.value:.2g} % ({one.failed} of "
            f"{result.trials_per_condition} seeds with a refusal)"
            for step, one in found.items()
        )
        return Reading.of(
            all_of([one.below(bound) for one in found.values()]),
            worst,
            "%",
            f"SD of the deflection, the larger of two steps: {said}",
        )

    def on_side(bench):
        return all(f.value <= predicates.MOST_SD for f in found_at(bench).values())

    return over_the_sweep(_case(options), reading_at, on_side)


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
