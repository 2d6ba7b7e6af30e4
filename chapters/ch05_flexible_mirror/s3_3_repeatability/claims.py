"""The claims about repeated deflections, tested as the registry words them.

A claim that is judged run by run returns whether it is true (runs,), the measured value
(runs,), its unit, and words; nan where a run was rejected.
"""

from functools import lru_cache

import numpy as np
from scipy.stats import wilcoxon

from chapters.ch05_flexible_mirror.s3_3_repeatability.experiment import (
    ARMS,
    DEFLECTIONS_MM,
    FEW,
    MANY,
    OUT,
    STEPS_MM,
)
from chapters.ch05_flexible_mirror.s3_3_repeatability.report import (
    JUDGED,
    METRIC,
    PANELS,
    STEP_NAMES,
    STEPS,
    LoopRuns,
    disagreement,
    loop_error,
    single_difference,
)
from chapters.shared.mirror import (
    BACK_PROJECTION_MM,
    READINGS,
    BenchRuns,
    mirror_rig,
    on_completed,
    over_completed,
    over_the_sweep,
    shape_name,
)
from raxel.geometry import inverse_pose, transform
from repro.run import (
    HOLDS,
    OVER_TRIALS,
    SIGNIFICANCE,
    UNDECIDED,
    Case,
    Reading,
    all_of,
    bootstrap,
    claim,
    median_interval,
    ratio_of,
    wins,
    with_worst,
)

# Questions of the registry.
OPEN = ("mirror_bench", "swinging_ends")
LEVELS = ("mirror_bench",)
MAX_APART, MAX_OPEN_MM = 6.0, 0.3
MAX_DIFFERENT, MAX_GROWTH = 1.0, 5.0
MAX_WORSE = 1.2
MIN_SD_MM, MIN_REDUCTION = 0.05, 20.0
MAX_SD = 1.0
MAX_P = 0.05
MIN_REMOVED = 50.0
SAME_ROW_MM = 1e-6
median = OVER_TRIALS["median"]


@claim("c5_convex_concave", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_equivalent_steps(results, options):
    """Equivalent steps agree within 6 %."""

    def found_by(runs):
        apart = disagreement(runs)
        words = "largest difference of equivalent steps"
        return apart <= MAX_APART, apart, "%", words

    return LoopRuns.judged_by_seed(results, options, found_by)


@claim("c5_hysteresis", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_loop(results, options):
    """The sums of steps out and back agree within 0.3 mm."""

    def found_by(runs):
        off = loop_error(runs)
        return off <= MAX_OPEN_MM, off, "mm", "sum of the steps out less that back"

    return LoopRuns.judged_by_seed(results, options, found_by)


@claim("c5_single_equals_staged", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_single_step(results, options):
    """The single step is within 1 % of the three: the median over runs."""

    def differences(level):
        return single_difference(LoopRuns(results, options, level))

    def reading_of(level, some):
        found = median_interval(differences(level)[some])
        decision = found.below(np.nextafter(MAX_DIFFERENT, 2))
        return Reading.of(decision, found, "%", "difference without sign")

    return over_completed(
        Case(READINGS, options),
        lambda level: np.isfinite(differences(level)),
        reading_of,
        lambda level, some: (
            median_interval(differences(level)[some]).value <= MAX_DIFFERENT
        ),
    )


@claim("c5_single_worse_bp", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_single_back_projection(results, options):
    """wins(staged < single) in back-projection at stage 0, as the thesis has it."""
    return _judged_wins(
        results, options, (STEP_NAMES[-1], "single"), "single over staged"
    )


@claim("c5_some_increase", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_increase(results, options):
    """Back-projection at stage 0 after six steps over that of the primary stage."""
    return _judged_wins(
        results,
        options,
        ("start", STEP_NAMES[-1]),
        "after six steps over before",
        bound=1.0,
    )


def _judged_wins(results, options, places, words, bound=None):
    """The Reading of wins(first < second) in back-projection at two places of the loop.

    bound: a ratio above which the interval has to lie, in place of the rule of `wins`.
    """

    def pair_of(level, name="back_mm"):
        runs = LoopRuns(results, options, level)
        return [runs.at_place(place, name) for place in places]

    def won(level, some, name="back_mm"):
        return wins([tuple(one[some] for one in pair_of(level, name))])[0]

    def reading_of(level, some):
        found = won(level, some)
        decision = found.decision
        if bound is not None:
            decision = found.ratio.above(bound)
            if decision == HOLDS and not found.p < SIGNIFICANCE:
                decision = UNDECIDED
        true = won(level, some, "back_true_mm").ratio.value
        reason = f"{words}; p = {found.p:.1g}; on the board's true pose {true:.2f}"
        return Reading.of(decision, found.ratio, "x", reason)

    return over_completed(
        Case(READINGS, options),
        lambda level: np.isfinite(pair_of(level)).all(axis=0),
        reading_of,
        lambda level, some: won(level, some).ratio.value > 1,
    )


def error_growth(errors):
    """Slope of errors (steps, runs) on the step's number, % of the fitted line's value
    at the first step, Estimate; a draw is one of whole sequences, and a rejected run
    counts as the worst."""
    x = np.arange(len(errors)) - (len(errors) - 1) / 2

    def slope(*rows):
        y = np.stack([median(row) for row in rows])
        rise = np.tensordot(x, y, 1) / (x @ x)
        return 100 * rise / (y.mean(axis=0) + x[0] * rise)

    return bootstrap(slope, *with_worst(errors), paired=True)


def _judged_loop(results, options, measure, bound, unit, words):
    """The Reading of a measure (errors (steps, runs)) -> Estimate of back-projection
    that is at most `bound`; words(Estimate on the true pose)."""

    def found_by(level, some, name="back_mm"):
        return measure(LoopRuns(results, options, level).at(name)[:, some])

    def reading_of(level, some):
        found = found_by(level, some)
        reason = words(found_by(level, some, "back_true_mm"))
        return Reading.of(found.below(np.nextafter(bound, 9)), found, unit, reason)

    return over_completed(
        Case(READINGS, options),
        lambda level: LoopRuns(results, options, level).completed,
        reading_of,
        lambda level, some: found_by(level, some).value <= bound,
    )


@claim("c5_no_accumulation", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_accumulation(results, options):
    """Slope of the back-projection error over the six steps, at most 5 % a step."""
    return _judged_loop(
        results,
        options,
        error_growth,
        MAX_GROWTH,
        "%",
        lambda true: (
            f"rise of the medians for each of {len(STEPS)} steps, of the line's first "
            f"value; on the board's true pose {true.value:.1f} ({true.low:.1f} to "
            f"{true.high:.1f}) %"
        ),
    )


@claim("c5_concave_harmless", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_concave_steps(results, options):
    """Back-projection after the three steps back, at most 1.2 times that before."""
    return _judged_loop(
        results,
        options,
        lambda errors: ratio_of("median", errors[-1], errors[OUT - 1], paired=True),
        MAX_WORSE,
        "x",
        lambda true: (
            "after six steps over after three; on the board's true pose "
            f"{true.value:.2f}"
        ),
    )


def in_places(result, level, pitch):
    """Deflections (runs, places) mm of one pitch, nan where rejected."""
    return np.array(result.arrays(level, pitch))


def between_places(*found):
    """SD of deflections between places, mm, (runs,) for each array (runs, places).

    Of the places in which none was rejected; nan where fewer than two are left.
    """
    known = np.all(np.isfinite(found), axis=0)
    enough = known.sum(axis=1) > 1
    spread = np.full((len(found), len(known)), np.nan)
    for row, mm in zip(spread, found, strict=True):
        row[enough] = np.nanstd(np.where(known, mm, np.nan)[enough], axis=1, ddof=1)
    return spread[:, enough]


def pooled_sd(result, level):
    """SD between places over all runs, mm, Estimate; runs are resampled."""
    return bootstrap(_rms, *between_places(in_places(result, level, "coarse")))


def reduction(result, level):
    """Reduction of the SD between places by half the pitch, %, Estimate."""
    pitches = (in_places(result, level, pitch) for pitch in ("coarse", "dense"))
    return bootstrap(
        lambda a, b: 100 * (1 - _rms(b) / _rms(a)),
        *between_places(*pitches),
        paired=True,
    )


def _rms(spread):
    return np.sqrt(np.mean(spread**2, axis=-1))


def _judged_places(results, options, measure, bound, unit, words):
    """The Reading of a measure (result, level) -> Estimate that is at least `bound`."""
    result = results["exp_c5_dense_grid"]

    def reading_at(level):
        found = measure(result, level)
        coarse, dense = np.nansum(
            result.column(level, ("refused_coarse", "refused_dense")), axis=1
        )
        return Reading.of(
            found.above(np.nextafter(bound, 0)),
            found,
            unit,
            f"{words}; rejected of {in_places(result, level, 'coarse').size}: "
            f"{coarse:.0f}, with half the pitch {dense:.0f}",
        )

    return over_the_sweep(
        Case(READINGS, options),
        reading_at,
        lambda level: measure(result, level).value >= bound,
    )


@claim(
    "c5_t55_better_t51",
    needs=("exp_c5_dense_grid",),
    evidence="rendered",
    readings=LEVELS,
)
def judge_placement(results, options):
    """SD of the first step's deflection between poses of the board alone."""
    words = "SD between places, all else held"
    return _judged_places(results, options, pooled_sd, MIN_SD_MM, "mm", words)


@claim(
    "c5_dense_grid", needs=("exp_c5_dense_grid",), evidence="rendered", readings=LEVELS
)
def judge_dense_grid(results, options):
    """Half the pitch removes a fifth of the SD between board poses."""
    words = "less SD between places"
    return _judged_places(results, options, reduction, MIN_REDUCTION, "%", words)


@claim(
    "c5_not_sensitive_init",
    needs=("exp_c5_not_sensitive_init",),
    evidence="rendered",
    readings=LEVELS,
)
def judge_starts(results, options):
    """SD of the results of perturbed starts, 1 % of the deflection in both steps."""
    steps = tuple(STEPS_MM)

    def scatter(level):
        """SD (steps, runs), %; nan where a start or the whole stage was rejected."""
        sd = results["exp_c5_not_sensitive_init"].column(level, steps, "sd_mm")
        return 100 * sd / np.array([*STEPS_MM.values()])[:, None]

    def reading_of(level, some):
        found = [median_interval(sd[some]) for sd in scatter(level)]
        bound = np.nextafter(MAX_SD, 2)
        words = ", ".join(
            f"{step} mm {one.value:.2g} %"
            for step, one in zip(steps, found, strict=True)
        )
        return Reading.of(
            all_of([one.below(bound) for one in found]),
            max(found, key=lambda one: one.value),
            "%",
            f"SD of the deflection, the larger of two steps: {words}",
        )

    return over_completed(
        Case(READINGS, options),
        lambda level: np.isfinite(scatter(level)).all(axis=0),
        reading_of,
        lambda level, some: all(
            median_interval(sd[some]).value <= MAX_SD for sd in scatter(level)
        ),
    )


@claim("c5_feature_loss", needs=("exp_c5_feature_loss",), evidence="synthetic")
def judge_lost_features(results):
    """Going back, the mean number of common corners falls with every deflection."""
    found = results["exp_c5_feature_loss"]
    back, out = (np.mean(found.arrays(way), axis=0) for way in ("back", "out"))
    lowest = -np.diff(back).max()
    numbers = ", ".join(f"{count:.0f}" for count in back)
    deflections = ", ".join(f"{mm:g}" for mm in DEFLECTIONS_MM)
    return Reading.of(
        bool(lowest > 0),
        float(lowest),
        "count",
        "least loss from one deflection to the next on the way back from stage 3, of "
        f"means over {found.trials_per_condition} places of the board: {numbers} "
        f"common corners after {deflections} mm; out, where the view widens, "
        f"{out[0]:.0f} to {out[-1]:.0f}",
    )


# Claims about the vectors of Fig. 5.13: causes and countermeasures.


def next_to_clamp(board, visible, way):
    """Indices of the edge's corners: board (N, 2) mm, visible (N,), way: see
    `way_to_clamp`."""
    indices = np.flatnonzero(visible)
    rows = np.round(board[indices, 1] / SAME_ROW_MM)
    return np.array(
        [
            indices[rows == row][np.argmax(way * board[indices[rows == row], 0])]
            for row in np.unique(rows)
        ]
    )


@lru_cache(maxsize=1)
def way_to_clamp():
    """1 or -1: the sense of the board's x axis that the mirror shows towards its clamp,
    of boards held in front of rig A."""
    rig = mirror_rig("A")
    T = rig.board_pose(np.random.default_rng(0), BACK_PROJECTION_MM)
    camera, board = rig.camera(0.0), rig.board.points()
    pixels, visible = rig.corners(camera, T)
    mirror = transform(
        inverse_pose(camera.T_viewer_mirror), camera.rays(pixels).origins
    )
    along = np.corrcoef(board[visible, 0], mirror[visible, 0])[0, 1]
    return -int(np.sign(along))


def edge_ratios(runs, place):
    """Mean error at the edge next to the clamp over the mean of all corners, (runs,).

    The edge: in each row of the board the visible corner nearest to the clamp.
    """
    found = np.full(runs.seeds, np.nan)
    for run, own in zip(*runs.vectors(place), strict=True):
        size = np.linalg.norm(own, axis=1)
        known = np.isfinite(size)
        edge = next_to_clamp(runs.board_mm, known, way_to_clamp())
        found[run] = size[edge].mean() / size[known].mean()
    return np.where(runs.goes_on(place), found, np.nan)


@claim("c5_fixed_edge_low", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_fixed_edge(results, options):
    """Mean error at the board's edge next to the clamp, below that of all corners.

    Judged run by run: below in all four panels. Fixed before: the edge is, in each
    row of the board, the visible corner nearest to the clamp; errors are those of
    the figure, in the fitted pose.
    """

    def found_by(runs):
        ratios = np.array([edge_ratios(runs, place) for place in PANELS])
        worst = ratios.max(axis=0)
        panels = ", ".join(
            f"{place} {np.count_nonzero(row < 1)} of {np.isfinite(row).sum()}"
            for place, row in zip(PANELS, ratios, strict=True)
        )
        words = (
            "edge over all, the largest of four panels; below in each panel, of the "
            f"simulated runs with it: {panels}"
        )
        return worst < 1, worst, "x", words

    return LoopRuns.judged_by_seed(results, options, found_by)


CONDITIONED = ("exp_c5_concave_conditioning", "exp_c5_concave_conditioning_swept")


class Views(BenchRuns):
    """What the steps of a loop see, at one error level."""

    EXPERIMENTS = CONDITIONED
    SWINGS = STEP_NAMES


@claim(
    "c5_concave_conditioning",
    needs=CONDITIONED,
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

    def found_by(views):
        words, ratios = [], []
        for name, measure in (("covered", "share"), ("reciprocal", "reciprocal")):
            found = np.array([views.at_place(step, name) for step in STEP_NAMES])
            out, back = found[:OUT].mean(axis=0), found[OUT:].mean(axis=0)
            ratios.append(back / out)
            words.append(
                f"{measure} {np.nanmedian(out):.2g} and {np.nanmedian(back):.2g}, "
                f"larger in {np.sum(ratios[-1] > 1)}"
            )
        lesser = np.min(ratios, axis=0)
        reason = "steps back over steps out, the lesser of both; medians out and back: "
        return lesser > 1, lesser, "x", reason + "; ".join(words)

    return Views.judged_by_seed(results, options, found_by)


def rates(errors):
    """Slopes (runs,) of errors (steps, runs) on the step's number, per step."""
    x = np.arange(len(errors)) - (len(errors) - 1) / 2
    return x @ errors / (x @ x)


def without_less_metric(result):
    """Growth without the metric less that with it, (runs,), per step; infinite where
    only that without was rejected, minus infinite where only the other was, nan where
    both were."""
    metric, without = map(rates, result.column(ARMS, STEP_NAMES, "back_mm"))
    with np.errstate(invalid="ignore"):
        return with_worst(without) - with_worst(metric)


def while_both_go_on(result, name="back_mm"):
    """The same over the steps that both arms reach, of runs with two or more."""
    metric, without = result.column(ARMS, STEP_NAMES, name)
    reached = np.isfinite(metric + without).sum(axis=0)
    return np.array(
        [
            rates(without[:n, run]) - rates(metric[:n, run])
            for run, n in enumerate(reached)
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
    middle_angle = np.median(angle) if len(angle) else np.nan
    metric, without = (
        sum(text is not None for text in result.texts(arm, "refused")) for arm in ARMS
    )

    def judge(some):
        # Rejected in both arms: no difference.
        found = np.where(np.isnan(differences), 0.0, differences)[some]
        interval, p = median_interval(found), p_larger(found)
        decision = interval.above(0.0)
        return Reading.of(
            UNDECIDED if decision == HOLDS and p >= MAX_P else decision,
            interval,
            "mm",
            f"growth for each step without the metric, less that with it; p = {p:.1g}; "
            f"rejected without the metric {without}, with it {metric}; over the steps "
            f"that both reach, of the rays, {middle_angle:.2g} degrees a step",
        )

    return on_completed(np.isfinite(differences), judge)


def rise_by_relief(trials, name="back_mm"):
    """Relief over smooth mirror with the fewest functions, ratio of medians, Estimate;
    and the share of the rise that the most functions remove, %, Estimate."""
    few, many = (
        with_worst(trials.column(("relief", "smooth"), shape_name(shape), name))
        for shape in (FEW, MANY)
    )

    def share_removed(rough, smooth, rough_left, smooth_left):
        left = median(rough_left) - median(smooth_left)
        return 100 * (1 - left / (median(rough) - median(smooth)))

    with np.errstate(invalid="ignore"):
        removed = bootstrap(share_removed, *few, *many, paired=True)
    return ratio_of("median", *few, paired=True), removed


@claim("c5_high_order", needs=("exp_c5_high_order",), evidence="rendered")
def judge_high_order(results):
    """Relief raises the residual at stage 0, and more functions take half of that away.

    Fixed before: the residual is that of Fig. 5.13(a), the mean back-projection error
    on a board at 400 mm in the pose that the calibration finds; relief is that of the
    first solved level; the removed share is that of the rise over a smooth mirror,
    which keeps its own residual with either number of functions.
    """
    trials = results["exp_c5_high_order"].select(geometry="A")
    rise, removed = rise_by_relief(trials)
    rise_left, removed_left = rise_by_relief(trials, "residual_mm")
    _, removed_angle = rise_by_relief(trials, "angle_deg")
    return Reading.of(
        all_of([rise.above(1.0), removed.above(np.nextafter(MIN_REMOVED, 0))]),
        removed,
        "%",
        f"of the rise by relief; with few functions it is {rise.value:.2f} times the "
        f"smooth mirror's ({rise.low:.2f} to {rise.high:.2f}); of the refinement's own "
        f"distances {removed_left.value:.0f} %, raised {rise_left.value:.2f} times; of "
        f"the angles to the true rays {removed_angle.value:.0f} %",
    )
