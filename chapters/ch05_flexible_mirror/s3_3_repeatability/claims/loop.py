"""The claims about repeated deflections, tested as the registry words them."""

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
from chapters.shared.mirror_sweep import READINGS, over_completed, over_the_sweep
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

# Questions of the registry.
OPEN = ("mirror_bench", "swinging_ends")
LEVELS = ("mirror_bench",)


def _case(options):
    return Case(READINGS, options)


@claim("c5_convex_concave", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_equivalent_steps(results, options):
    """Test that equivalent steps agree within 6 %."""
    return LoopRuns.judged_by_seed(results, options, predicates.steps_agree)


@claim("c5_hysteresis", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_loop(results, options):
    """Test that the sums of steps out and back agree within 0.3 mm."""
    return LoopRuns.judged_by_seed(results, options, predicates.loop_closes)


@claim("c5_single_equals_staged", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_single_step(results, options):
    """Test that the single step is within 1 % of the three: the median over runs."""

    def differences(bench):
        return predicates.single_difference(LoopRuns(results, options, bench))

    def middle(bench, seeds):
        return median_interval(differences(bench)[seeds])

    def reading_of(bench, seeds):
        found = middle(bench, seeds)
        decision = found.below(np.nextafter(predicates.MAX_DIFFERENT, 2))
        return Reading.of(decision, found, "%", "difference without sign")

    return over_completed(
        _case(options),
        lambda bench: np.isfinite(differences(bench)),
        reading_of,
        lambda bench, seeds: middle(bench, seeds).value <= predicates.MAX_DIFFERENT,
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
        return predicates.error_growth(LoopRuns(results, options, bench), name, seeds)

    def reading_of(bench, seeds):
        found, true = (growth(bench, seeds, n) for n in ("back_mm", "back_true_mm"))
        return Reading.of(
            found.below(np.nextafter(predicates.MAX_GROWTH, 9)),
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
        lambda bench, seeds: growth(bench, seeds).value <= predicates.MAX_GROWTH,
    )


@claim("c5_concave_harmless", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_concave_steps(results, options):
    """Back-projection after the three steps back, at most 1.2 times that before."""

    def ratio(bench, seeds, name="back_mm"):
        runs = LoopRuns(results, options, bench)
        after, before = runs.at(name, (BACK[-1], BACK[0] - 1))[:, seeds]
        return predicates.loop_ratio(after, before)

    def reading_of(bench, seeds):
        found, true = (ratio(bench, seeds, n) for n in ("back_mm", "back_true_mm"))
        return Reading.of(
            found.below(np.nextafter(predicates.MAX_WORSE, 2)),
            found,
            "x",
            "after six steps over after three; on the board's true pose "
            f"{true.value:.2f}",
        )

    return over_completed(
        _case(options),
        _completed(results, options),
        reading_of,
        lambda bench, seeds: ratio(bench, seeds).value <= predicates.MAX_WORSE,
    )


def _refused_places(result, bench):
    """Number of rejected calibrations, in words."""
    lost = {
        pitch: int(np.nansum(result.column(f"{bench}.refused_{pitch}")))
        for pitch in ("coarse", "dense")
    }
    whole = predicates.in_places(result, bench, "coarse").size
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
        found = predicates.pooled_sd(result, bench)
        return Reading.of(
            found.above(np.nextafter(predicates.MIN_SD_MM, 0)),
            found,
            "mm",
            f"SD between places, all else held; {_refused_places(result, bench)}",
        )

    def on_side(bench):
        return predicates.pooled_sd(result, bench).value >= predicates.MIN_SD_MM

    return over_the_sweep(_case(options), reading_at, on_side)


@claim(
    "c5_dense_grid", needs=("exp_c5_dense_grid",), evidence="rendered", readings=LEVELS
)
def judge_dense_grid(results, options):
    """Test that half the pitch removes a fifth of the SD between board poses."""
    result = results[PLACED]

    def reading_at(bench):
        found = predicates.reduction(result, bench)
        return Reading.of(
            found.above(np.nextafter(predicates.MIN_REDUCTION, 0)),
            found,
            "%",
            f"less SD between places; {_refused_places(result, bench)}",
        )

    def on_side(bench):
        return predicates.reduction(result, bench).value >= predicates.MIN_REDUCTION

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
            step: predicates.scatter_of_starts(result, bench, step, mm)
            for step, mm in STEPS_MM.items()
        }

    def middles(bench, seeds):
        return {s: median_interval(sd[seeds]) for s, sd in of_starts(bench).items()}

    def reading_of(bench, seeds):
        found = middles(bench, seeds)
        bound = np.nextafter(predicates.MAX_SD, 2)
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
            one.value <= predicates.MAX_SD for one in middles(bench, seeds).values()
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
