"""The claims about three deflections, tested as the registry words them."""

from dataclasses import replace

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_deflections.report import (
    DEFLECTED,
    JUDGED,
    LAST,
    Runs,
    Tips,
    among_sd,
    angles_not_worse,
    angles_spatial,
    below_final,
    by_formula,
    by_stage,
    deflections_found,
    dynamic_removes,
    edge_residuals,
    linear_ratios,
    pose_reflection,
    ray_turns,
    tip_sd,
)
from chapters.shared.mirror import (
    ABERRATION_UM,
    READINGS,
    SECOND,
    STAGES_MM,
    mirror_rig,
    of_completed,
    over_completed,
    over_the_sweep,
)
from repro.run import (
    DECISIONS,
    NOT_COMPARABLE,
    OVER_TRIALS,
    Case,
    Reading,
    all_of,
    bootstrap,
    claim,
    proportion,
    ratio_of,
    with_worst,
)

# Questions of the registry.
OPEN = ("mirror_bench", "swinging_ends", "mirror_geometry")
ANGLES = ("mirror_bench", "swinging_ends", "mirror_geometry", "primary_grids")
BOTH_RIGS = ("table_5_1_runs", "table_5_1_other")
MIN_BELOW, MAX_RATIO = 0.95, 0.9
MAX_GROWTH = 1.1
TIMES = 2.0  # the SD among the corners
MAX_OFF_TWICE = 0.05  # of twice the curvature


@claim(
    "c5_pose_reflection",
    needs=("table_5_1_runs",),
    evidence="rendered",
    readings=("mirror_bench",),
)
def judge_pose_reflection(results, options):
    """The shift within 1.5 mm and the turn within 0.4 degrees at stages 0 to 3.

    At the second solved level the platter's errors, which are put in, determine both.
    """
    runs = Runs(results, options)
    found = of_completed(*pose_reflection(runs))
    if runs.bench != SECOND:
        return found
    reason = f"the platter's errors that are put in determine it; {found.reason}"
    return replace(found, verdict=NOT_COMPARABLE, reason=reason)


@claim("c5_deflection_8pct", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_deflections(results, options):
    """Final deflections within 10 % at every stage."""
    return Runs.judged_by_seed(results, options, deflections_found)


@claim("c5_linear_err_range", needs=BOTH_RIGS, evidence="rendered")
def judge_linear_range(results):
    """Difference of linear and final estimates, which the distances determine.

    The share is 1 - Z/(Z+D), with the distances Z of the board and D of the camera. The
    thesis gives two values of Z and none of D, so that the result follows from the
    choice.
    """
    said = []
    for geometry in "AB":
        below = below_final(Runs(results, geometry=geometry))
        formula = 100 * (1 - by_formula(geometry))
        said.append(f"{geometry} {by_stage(below)} % ({formula:.0f} %)")
    return Reading.of(
        NOT_COMPARABLE,
        ", ".join(said),
        reason="the share is that of the chosen distances of camera, mirror and board, "
        "of which the thesis states none but the board's: by stage, and in brackets "
        "by 1 - Z/(Z+D)",
    )


@claim("c5_angles_not_worse", needs=JUDGED, evidence="rendered", readings=ANGLES)
def judge_angles(results, options):
    """Mean angle to measured rays at stage 3 over that at stage 0."""
    return Runs.judged_by_seed(results, options, angles_not_worse)


@claim("c5_angles_spatial", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_angles_by_place(results, options):
    """Clamped strip < whole mirror < free strips, at every stage."""
    return Runs.judged_by_seed(results, options, angles_spatial)


@claim("c5_dynamic_removes", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_removed(results, options):
    """Back-projection after calibration over that before, at stage 3."""
    return Runs.judged_by_seed(results, options, dynamic_removes)


@claim("c5_edge_residuals", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_edges(results, options):
    """The largest tenth of errors lies at free edges, by a chi-squared test."""
    return Runs.judged_by_seed(results, options, edge_residuals)


@claim("c5_linear_underestimates", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_underestimate(results, options):
    """Too small in 95 % of the linear stages and below 0.9 on the mean, at every stage.

    All linear stages count, also those of stages that were rejected later.
    """

    def ratios_at(bench):
        return linear_ratios(Runs(results, options, bench))

    def decided(ratios):
        below = [proportion((r < 1).astype(float)).above(MIN_BELOW) for r in ratios]
        return all_of(below + [_mean(r).below(MAX_RATIO) for r in ratios])

    def reading_at(bench):
        every = ratios_at(bench)
        ratios = [r[np.isfinite(r)] for r in every]
        if not all(len(r) for r in ratios):
            return Reading("undecided", "nothing", reason="a stage without any")
        means = [_mean(ratio) for ratio in ratios]
        most = max(means, key=lambda mean: mean.value)
        lost = np.count_nonzero(np.isnan(every))
        return Reading.of(
            decided(ratios),
            most,
            reason="largest mean of linear over actual; stages 1 to 3 "
            f"{', '.join(f'{mean.value:.2f}' for mean in means)}; the largest of all "
            f"is {np.nanmax(every):.2f}; Z/(Z+D) is {by_formula():.2f}; {lost} of "
            f"{every.size} stages have no linear estimate, which as misses give: "
            f"{DECISIONS[decided(every)]}",
        )

    def side_at(bench):
        ratios = [r[np.isfinite(r)] for r in ratios_at(bench)]
        return all(
            len(r) and np.mean(r < 1) >= MIN_BELOW and np.mean(r) < MAX_RATIO
            for r in ratios
        )

    return over_the_sweep(Case(READINGS, options), reading_at, side_at)


def _mean(trials):
    """Estimate of the mean of trials (n,); a failed one counts as the worst."""
    if np.isnan(trials).all():
        return bootstrap(OVER_TRIALS["mean"], with_worst(trials))
    return bootstrap(OVER_TRIALS["mean"], with_worst(trials, np.nanmax(trials)))


@claim("c5_bp_constant", needs=JUDGED, evidence="rendered", readings=OPEN)
def judge_constant(results, options):
    """Back-projection and residual grow by 10 % at most from stage 1 to stage 3."""
    measures = {"back-projection": "back_mm", "residual": "residual_mm"}

    def ratios(bench, seeds):
        runs = Runs(results, options, bench)
        return {
            words: ratio_of(
                "median",
                runs.of(LAST, name)[seeds],
                runs.of(DEFLECTED[0], name)[seeds],
                paired=True,
            )
            for words, name in measures.items()
        }

    def reading_of(bench, seeds):
        found = ratios(bench, seeds)
        most = max(found, key=lambda words: found[words].value)
        said = ", ".join(
            f"{words} {one.value:.2f} ({one.low:.2f} to {one.high:.2f})"
            for words, one in found.items()
        )
        within = [one.below(np.nextafter(MAX_GROWTH, 2)) for one in found.values()]
        return Reading.of(
            all_of(within), found[most], reason=f"stage 3 over stage 1: {said}"
        )

    return over_completed(
        Case(READINGS, options),
        lambda bench: np.isfinite(Runs(results, options, bench).of(LAST, "back_mm")),
        reading_of,
        lambda bench, seeds: all(
            one.value <= MAX_GROWTH for one in ratios(bench, seeds).values()
        ),
    )


@claim(
    "c5_extrapolated_tip",
    needs=("exp_c5_extrapolated_tip", "exp_c5_extrapolated_tip_swept"),
    evidence="rendered",
    readings=("mirror_bench",),
)
def judge_tip(results, options):
    """SD of the deflection's error at the load over that among the corners.

    Fixed before the run: the first push of 5 mm, over all runs. The error is that of
    the movement, estimated minus true, so that the position of the whole mirror after
    the primary stage drops out. The ratio for the position after the push is reported.
    Among the corners: a lattice of points in the convex hull of the corners that both
    images show, all runs and points together. Rejected runs have no value.
    """

    def reading_at(bench):
        tips = Tips.on(results, bench)
        if not tips.completed:
            return Reading("undecided", "nothing", reason="all runs were rejected")
        tip, mean, square = tips.moments()
        ratio = tips.ratio()
        return Reading.of(
            ratio.above(TIMES),
            ratio,
            "x",
            f"SD {tip_sd(tip):.3g} mm at the load, {among_sd(mean, square):.3g} mm "
            f"among the corners; of where the mirror is, {tips.ratio(True).value:.2f} "
            f"times; the load is {np.median(tips.of('beyond_mm')):.0f} mm beyond the "
            f"last corner (median); {tips.refused} of "
            f"{tips.result.trials_per_condition} seeds rejected",
        )

    def side_at(bench):
        tips = Tips.on(results, bench)
        return bool(tips.completed) and tips.ratio().value > TIMES

    return over_the_sweep(Case(READINGS, options), reading_at, side_at)


@claim("c5_curvature_rotation", needs=(), evidence="analytic")
def judge_curvature(results):
    """Turn of the scene ray for a shift of its reflection point, at stage 3.

    Fixed: geometry A, a smooth mirror and one as uneven as at the primary level; the
    direction of the viewing ray is kept, so that the mirror alone rotates the ray;
    points on the middle line with a tenth of the largest curvature or more. The
    rotation with each point's own viewing ray is reported. Both had been known when
    this was fixed.
    """
    turns = [
        ray_turns(mirror_rig("A").camera(STAGES_MM[-1], uneven, 0))
        for uneven in (0.0, ABERRATION_UM)
    ]
    off = max(np.abs(t.over_twice(t.mirror) - 1).max() for t in turns)
    whole = turns[0].over_twice(turns[0].whole)
    return Reading.of(
        bool(off <= MAX_OFF_TWICE),
        float(100 * off),
        "%",
        f"largest difference from twice the curvature at "
        f"{sum(np.count_nonzero(t.curved) for t in turns)} places; with the viewing "
        f"ray of each place, {whole.min():.1f} to {whole.max():.1f} times that",
    )
