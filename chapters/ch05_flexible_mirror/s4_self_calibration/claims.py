"""Claims about self-calibration, tested as registered.

Fixed before the run: features cluster in the middle fifth of the mirror's height, and
near ones, 1.2 m away, lie where the flat mirror shows nothing; pushes of 5 mm are
self-calibrated in two steps, since over one no far feature is left in the last knot
interval. Rejected runs are counted separately.

Each function of `Courses` at an error level returns whether the claim holds (runs,),
the measured value (runs,), its unit, and words. It is nan where a run was rejected.
"""

import numpy as np

from chapters.ch05_flexible_mirror.s4_self_calibration.experiment import STEPS
from chapters.ch05_flexible_mirror.s4_self_calibration.report import (
    OBJECTS,
    STAGE_NAMES,
    STEP_MM,
    THESIS_SCENE,
    Courses,
)
from chapters.shared.mirror import READINGS, middle, over_the_sweep
from repro.run import OVER_TRIALS, Case, Reading, bootstrap, claim, proportion

LEVELS = ("mirror_bench",)
JUDGED = ("table_5_9_runs", "table_5_9_swept")
MAJORITY = 0.5
MAX_SLOPE = 2.0  # % for a step
# Fraction of the largest curvature: less of the other sign is no inflexion.
MIN_INFLEXION_RATIO = 0.1
POLYNOMIAL = 5  # degree of the polynomial that is differentiated


def bends_back(heights):
    """Whether a profile (n,), evenly spaced, has an inflexion.

    A tenth or more of its largest curvature has the other sign, in its middle eight
    tenths. False for a profile that the spline does not cover everywhere.
    """
    if not np.isfinite(heights).all():
        return False
    x = np.linspace(-1, 1, len(heights))
    bend = np.polynomial.Polynomial.fit(x, heights, POLYNOMIAL).deriv(2)(0.8 * x)
    return bool(min(-bend.min(), bend.max()) > MIN_INFLEXION_RATIO * np.abs(bend).max())


def inflected(runs, way):
    """Whether the profile has an inflexion (stages 2 and 3, runs).

    False where a run ended before.
    """
    came = np.isfinite(runs.of(way, "angle_deg"))[1:]
    back = np.zeros(came.shape, bool)
    for row, some, stage in zip(back, came, STAGE_NAMES[1:], strict=True):
        row[some] = [bends_back(z) for z in runs.arrays(way, stage, "profile_mm")]
    return back


LINEAR_TOL = 0.1
MAX_SAG_RATIO = 0.25
MIN_BASELINE_RATIO, MAX_TREND = 5.0, -0.8
MIN_SPREAD = 0.2
MIN_GROWTH, MIN_REFINED_RATIO = 1.5, 3.0


def by_stage(values):
    return ", ".join(middle(one) for one in values)


def better_early(runs):
    """Estimates of stages 1 and 2 are nearer to 5 mm than the linear ones of boards."""
    own, near = runs.of(THESIS_SCENE, "deflection_mm"), runs.of("board", "linear_mm")
    off, was = np.abs(own - STEP_MM), np.abs(near - STEP_MM)
    even = np.abs(runs.of("even", "deflection_mm") - STEP_MM) < was
    return (
        np.all(off[:2] < was[:2], axis=0),
        (off / was)[:2].max(axis=0),
        "",
        f"error over that of the near scene, larger of two; found {by_stage(own)} mm, "
        f"near {by_stage(near)} mm; with evenly spread far features true in "
        f"{100 * np.mean(even[:2].all(axis=0)):.0f} % of the seeds",
    )


def degrades(runs):
    """Smaller from stage to stage, the last within 10 % of the near linear estimate."""
    own, near = (
        runs.of(THESIS_SCENE, "deflection_mm"),
        runs.of("board", "linear_mm")[-1],
    )
    falls = np.all(np.diff(own, axis=0) < 0, axis=0)
    ratio = own[-1] / near
    return (
        falls & (np.abs(ratio - 1) <= LINEAR_TOL),
        ratio,
        "",
        f"stage 3 over the near scene's; falling in {100 * np.mean(falls):.0f} % of "
        f"the seeds; found {by_stage(own)} mm",
    )


def vertical(runs):
    """Sag at the load rises over the stages; even features have at most a quarter."""
    sag, even = (
        np.abs(runs.of("clustered", "sag_mm")),
        np.abs(runs.of("even", "sag_mm")),
    )
    share = even[-1] / sag[-1]
    return (
        np.all(np.diff(sag, axis=0) > 0, axis=0) & (share <= MAX_SAG_RATIO),
        share,
        "",
        f"sag of even over clustered features, stage 3; clustered {by_stage(sag)} mm, "
        f"even {by_stage(even)} mm",
    )


def inflexion(runs):
    """An inflexion at stages 2 and 3 with near features, and at neither without."""
    near = inflected(runs, "near").all(axis=0)
    without = inflected(runs, "even").any(axis=0)
    thesis = inflected(runs, THESIS_SCENE).all(axis=0)
    came = np.isfinite(runs.of("even", "deflection_mm")).all(axis=0)
    both = came & np.isfinite(runs.of("near", "deflection_mm")).all(axis=0)
    return (
        near & ~without,
        np.where(both, near, np.nan),
        "",
        f"with near features at both in {100 * near.mean():.0f} % of the seeds, "
        f"without at one or both in {100 * without.mean():.0f} %, where features are "
        f"spread evenly; as in 5.4 {100 * thesis.mean():.0f} %; without near ones "
        f"{came.sum()} of {runs.seeds} came to stage 3",
    )


def large_error(runs):
    """Depth errors between bent states are at least five times those from 100 mm."""
    ratio, true = (
        runs.column("stereo", name, "deflected")
        / runs.column("stereo", name, "baseline")
        for name in ("found", "true")
    )
    return (
        ratio >= MIN_BASELINE_RATIO,
        ratio,
        "x",
        "median relative error of depths in the far scene, over that of 100 mm; with "
        f"the true mirror {middle(true)}; boards are off by "
        f"{middle(100 * runs.column('stereo.found.board'))} %",
    )


def edge_times(runs):
    """SD of a depth in the strip at the clamp over that at the free end, (seeds,)."""
    sd = runs.arrays("stereo.sd_mm")
    # A quick build has no sweep, and so no strips of it.
    return np.array([one[0] / one[-1] for one in sd] or [np.nan])


def fixed_edge(runs):
    """The SD of a depth falls from the clamp on."""
    trend = runs.column("stereo.trend")
    return (
        trend <= MAX_TREND,
        trend,
        "",
        "Spearman's rank correlation of the SD with the distance from the clamp; in "
        f"the strip at the clamp the SD is {middle(edge_times(runs))} times that at "
        "the free end; that there is no depth at all at the clamp is not tested",
    )


def _multi(runs, name, cameras="found"):
    return runs.column("multi", cameras, OBJECTS, name)


def spread_of_runs(runs):
    """A fifth of the depth or more, and more for the wall than for the plane."""
    plane, _, wall = _multi(runs, "spread_mm")
    true = _multi(runs, "spread_mm", "true")
    share = np.minimum(plane / 3980, wall / 5000)
    return (
        (share >= MIN_SPREAD) & (wall > plane),
        share,
        "",
        f"smaller share of the depth; plane {middle(plane)} mm, wall {middle(wall)} "
        f"mm; with the true mirror {middle(true[0])} and {middle(true[2])} mm",
    )


def order(runs):
    """Plane, object and wall in this order by their centroids."""
    plane, thing, wall = _multi(runs, "centroid_mm")
    return (
        (plane < thing) & (thing < wall),
        wall - plane,
        "mm",
        f"wall behind the plane; centroids {middle(plane)}, {middle(thing)}, "
        f"{middle(wall)} mm",
    )


def under(runs):
    """All three centroids are nearer than the true ones."""
    ratio = _multi(runs, "ratio")
    return (
        np.all(ratio < 1, axis=0),
        ratio.max(axis=0),
        "",
        f"largest of the three ratios; plane, object, wall {by_stage(ratio)}; with "
        f"the true mirror {by_stage(_multi(runs, 'ratio', 'true'))}",
    )


def impractical(runs):
    """Back-projection errors grow by half, and end at three times those of boards.

    A self-calibration that is rejected where boards are not supports the claim. Where
    boards are rejected as well, there is nothing to compare with.
    """
    own, board = runs.of(THESIS_SCENE, "back_mm"), runs.of("board", "back_mm")
    even, over = runs.of("even", "back_mm"), own[-1] / board[-1]
    rejected = np.isnan(own[-1]) & np.isfinite(board[-1])
    grows = (own[-1] >= MIN_GROWTH * own[0]) & (over >= MIN_REFINED_RATIO)
    return (
        grows | rejected,
        np.where(rejected, np.inf, over),
        "x",
        f"over the refined method, stage 3; {by_stage(own)} mm; boards "
        f"{by_stage(board)} mm; even features {by_stage(even)} mm; "
        f"{rejected.sum()} self-calibrations were rejected where the boards' were not",
    )


def slopes(result, way):
    """Slopes (runs,) of the error, % of its mean per step.

    The mean at each of both deflections is 100 %. A rejected run counts as the worst
    of the others.
    """
    steps = tuple(f"step{k}" for k in range(1, STEPS + 1))
    # nan from a rejected step on.
    errors = result.column(way, steps)
    relative = np.empty_like(errors)
    for place in (0, 1):
        mine = errors[place::2]
        relative[place::2] = 100 * mine / np.mean(mine, axis=0)
    step = np.arange(STEPS) - (STEPS - 1) / 2
    # Both deflections have equal means: only the order of the steps gives a slope.
    found = step @ relative / (step @ step)
    return np.where(np.isfinite(found), found, np.nanmax(found))


@claim("c5_selfcal_better_early", needs=JUDGED, evidence="rendered", readings=LEVELS)
def judge_better_early(results, options):
    """As described in 5.4; near: the linear stage of Table 5.1 in the same run."""
    return Courses.judged_by_seed(results, options, better_early)


@claim("c5_selfcal_degrades", needs=JUDGED, evidence="rendered", readings=LEVELS)
def judge_degrades(results, options):
    """Deflections as described in 5.4, and the near scene of the same run."""
    return Courses.judged_by_seed(results, options, degrades)


@claim("c5_selfcal_vertical", needs=JUDGED, evidence="rendered", readings=LEVELS)
def judge_vertical(results, options):
    """Sag at the load: both sides, 40 mm off, less the middle, found less true."""
    return Courses.judged_by_seed(results, options, vertical)


@claim("c5_phantom_inflexion", needs=JUDGED, evidence="rendered", readings=LEVELS)
def judge_inflexion(results, options):
    """The middle line from 5 to 150 mm, a polynomial of degree 5 through it."""
    return Courses.judged_by_seed(results, options, inflexion)


@claim("c5_vbs_large_error", needs=JUDGED, evidence="rendered", readings=LEVELS)
def judge_large_error(results, options):
    """Stages 0 and 1, and stage 0 moved by 100 mm, both calibrated."""
    return Courses.judged_by_seed(results, options, large_error)


@claim("c5_vbs_fixed_edge", needs=JUDGED, evidence="rendered", readings=LEVELS)
def judge_fixed_edge(results, options):
    """First-order SD on the true mirror, in eight strips, stages 0 and 1."""
    return Courses.judged_by_seed(results, options, fixed_edge)


@claim("c5_multi_spread", needs=JUDGED, evidence="rendered", readings=LEVELS)
def judge_spread(results, options):
    """Largest less smallest depth, calibrated mirror, picked by hand."""
    return Courses.judged_by_seed(results, options, spread_of_runs)


@claim("c5_multi_under", needs=JUDGED, evidence="rendered", readings=LEVELS)
def judge_under(results, options):
    """Depths of centroids found over true ones."""
    return Courses.judged_by_seed(results, options, under)


@claim("c5_selfcal_impractical", needs=JUDGED, evidence="rendered", readings=LEVELS)
def judge_impractical(results, options):
    """Own-pose back-projection at 400 mm, as 5.3.3; features as in 5.4."""
    return Courses.judged_by_seed(results, options, impractical)


@claim("c5_multi_order", needs=JUDGED, evidence="rendered", readings=LEVELS)
def judge_order(results, options):
    """So ordered in the majority of the runs: the share, above one half."""

    def share(level):
        holds, *_, reason = order(Courses(results, options, level))
        return proportion(holds.astype(float)), reason

    def reading_at(level):
        found, reason = share(level)
        return Reading.of(found.above(MAJORITY), found, reason=reason)

    return over_the_sweep(
        Case(READINGS, options), reading_at, lambda level: share(level)[0].value > 0.5
    )


@claim("c5_known_scene", needs=("exp_c5_known_scene",), evidence="synthetic")
def judge_known(results):
    """Slope of the ray error on the step number, % of its mean, over the runs.

    Fixed before the run: eight steps to and fro between 5 and 7.5 mm, so that a step is
    as hard as any other; each place's own mean error is 100 %. The mirror of before is
    the spline nearest to the true one.
    """
    result = results["exp_c5_known_scene"]
    known, boards = slopes(result, "known"), slopes(result, "boards")
    mean = bootstrap(OVER_TRIALS["mean"], known)
    return Reading.of(
        mean.below(np.nextafter(MAX_SLOPE, 3)),
        mean,
        "%",
        f"for a step; with boards in found poses {np.mean(boards):.2g} %",
    )
