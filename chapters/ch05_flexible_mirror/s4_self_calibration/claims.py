"""Claims about self-calibration, tested as registered.

Fixed before the run: features cluster in the middle fifth of the mirror's height, and
near ones, 1.2 m away, lie where the flat mirror shows nothing; pushes of 5 mm are
self-calibrated in two steps, since over one no far feature is left in the last knot
interval. Rejected runs are counted separately.
"""

import numpy as np

from chapters.ch05_flexible_mirror.s4_self_calibration.report import (
    Courses,
    better_early,
    degrades,
    fixed_edge,
    impractical,
    inflexion,
    large_error,
    order,
    slopes,
    spread_of_runs,
    under,
    vertical,
)
from chapters.shared.mirror import READINGS, over_the_sweep
from repro.run import OVER_TRIALS, Case, Reading, bootstrap, claim, proportion

BENCHES = ("mirror_bench",)
JUDGED = ("table_5_9_runs", "table_5_9_swept")
MAJORITY = 0.5
MAX_SLOPE = 2.0  # % for a step


@claim("c5_selfcal_better_early", needs=JUDGED, evidence="rendered", readings=BENCHES)
def judge_better_early(results, options):
    """As told in 5.4; near: the linear stage of Table 5.1 in the same seed."""
    return Courses.judged_by_seed(results, options, better_early)


@claim("c5_selfcal_degrades", needs=JUDGED, evidence="rendered", readings=BENCHES)
def judge_degrades(results, options):
    """Deflections as told in 5.4, and the near scene of the same seed."""
    return Courses.judged_by_seed(results, options, degrades)


@claim("c5_selfcal_vertical", needs=JUDGED, evidence="rendered", readings=BENCHES)
def judge_vertical(results, options):
    """Sag at the load: both sides, 40 mm off, less the middle, found less true."""
    return Courses.judged_by_seed(results, options, vertical)


@claim("c5_phantom_inflexion", needs=JUDGED, evidence="rendered", readings=BENCHES)
def judge_inflexion(results, options):
    """The middle line from 5 to 150 mm, a polynomial of degree 5 through it."""
    return Courses.judged_by_seed(results, options, inflexion)


@claim("c5_vbs_large_error", needs=JUDGED, evidence="rendered", readings=BENCHES)
def judge_large_error(results, options):
    """Stages 0 and 1, and stage 0 moved by 100 mm, both calibrated."""
    return Courses.judged_by_seed(results, options, large_error)


@claim("c5_vbs_fixed_edge", needs=JUDGED, evidence="rendered", readings=BENCHES)
def judge_fixed_edge(results, options):
    """First-order SD on the true mirror, in eight strips, stages 0 and 1."""
    return Courses.judged_by_seed(results, options, fixed_edge)


@claim("c5_multi_spread", needs=JUDGED, evidence="rendered", readings=BENCHES)
def judge_spread(results, options):
    """Largest less smallest depth, calibrated mirror, picked by hand."""
    return Courses.judged_by_seed(results, options, spread_of_runs)


@claim("c5_multi_under", needs=JUDGED, evidence="rendered", readings=BENCHES)
def judge_under(results, options):
    """Depths of centroids found over true ones."""
    return Courses.judged_by_seed(results, options, under)


@claim("c5_selfcal_impractical", needs=JUDGED, evidence="rendered", readings=BENCHES)
def judge_impractical(results, options):
    """Own-pose back-projection at 400 mm, as 5.3.3; as told in 5.4."""
    return Courses.judged_by_seed(results, options, impractical)


@claim("c5_multi_order", needs=JUDGED, evidence="rendered", readings=BENCHES)
def judge_order(results, options):
    """So ordered in the majority of the seeds: the share, above one half."""

    def share(bench):
        holds, *_, reason = order(Courses(results, options, bench))
        return proportion(holds.astype(float)), reason

    def reading_at(bench):
        found, reason = share(bench)
        return Reading.of(found.above(MAJORITY), found, reason=reason)

    return over_the_sweep(
        Case(READINGS, options), reading_at, lambda bench: share(bench)[0].value > 0.5
    )


@claim("c5_known_scene", needs=("exp_c5_known_scene",), evidence="synthetic")
def judge_known(results):
    """Slope of the ray error on the step number, % of its mean, over the seeds.

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
