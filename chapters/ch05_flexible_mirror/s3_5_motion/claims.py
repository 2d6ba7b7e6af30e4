"""Claims about motion and shape in 5.3.5, tested as registered."""

from dataclasses import replace

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_motion.experiment import moved_cylinder, seen_by
from chapters.ch05_flexible_mirror.s3_5_motion.report import (
    JUDGED,
    MotionRuns,
    follows,
    markers_meet,
    mostly_meet,
    radius_found,
    scale_right,
    scale_tells,
    scaled,
)
from chapters.shared.mirror import (
    ABERRATION_UM,
    READINGS,
    STAGES_MM,
    mirror_rig,
    mostly,
    of_completed,
    over_completed,
    over_the_sweep,
)
from raxel.cameras import Rays, centrality
from raxel.geometry import pluecker_of_rays, side_products
from repro.run import NOT_COMPARABLE, Case, Reading, claim

LEVELS = ("mirror_bench",)
MIN_SPREAD_MM, MAX_PRODUCT_MM = 0.5, 1e-6
SCENE_SEED = 0


@claim(
    "c5_sfm",
    needs=("table_5_7_runs", "table_5_7_swept", "table_5_7_longer"),
    evidence="rendered",
    readings=("mirror_bench", "mirror_geometry"),
)
def judge_motion(results, options):
    """Magnitudes within 5 % at every step, the last shift within 8 mm.

    Where it does not hold with the true mirror either, the geometry decides and not the
    calibration: not comparable.
    """

    def reading_at(level):
        runs = MotionRuns(results, options, level)
        found = of_completed(*follows(runs))
        true = of_completed(*follows(runs, "true"))
        reason = f"{found.reason}; with the true mirror: {true.verdict}, {true.reason}"
        alone = true.verdict == "differs"
        verdict = NOT_COMPARABLE if alone else found.verdict
        return replace(found, verdict=verdict, reason=reason)

    def side_at(level):
        return mostly(*follows(MotionRuns(results, options, level))[:2])

    return over_the_sweep(Case(READINGS, options), reading_at, side_at)


@claim("c5_cylinder", needs=JUDGED, evidence="rendered", readings=LEVELS)
def judge_cylinder(results, options):
    """Scaled radius within 10 %, unscaled within 20 %."""
    return MotionRuns.judged_by_seed(results, options, radius_found)


@claim("c5_points_on_cyl", needs=JUDGED, evidence="rendered", readings=LEVELS)
def judge_markers(results, options):
    """One of 25 markers misses the cylinder at most, median over runs."""

    def on(level):
        return MotionRuns(results, options, level)

    return over_completed(
        Case(READINGS, options),
        lambda level: np.isfinite(on(level).of("missed")),
        lambda level, seeds: markers_meet(on(level), seeds),
        lambda level, seeds: mostly_meet(on(level), seeds),
    )


@claim("c5_scale_unreliable", needs=JUDGED, evidence="rendered", readings=LEVELS)
def judge_scale(results, options):
    """The scatter of log scale falls with deflection; the scale is right at the most.

    Fixed before the run: the scale is the mean of five steps, pair by pair, over the
    true one, with the camera of the published calibration, at stages 0 to 3. Runs
    without one count as a factor of 100, and so do those that are off by more. The
    sweep has stage 3 alone, and there the median is held against the claim.
    """

    def on(level):
        return MotionRuns(results, options, level)

    return over_completed(
        Case(READINGS, options),
        lambda level: scaled(on(level), level),
        lambda level, seeds: scale_tells(on(level), seeds),
        lambda level, seeds: scale_right(on(level), seeds),
    )


@claim("c5_gen_essential_needed", needs=(), evidence="analytic")
def judge_congruence(results):
    """Distance of stage 3's rays from the point next to them, and L_2^T G L_1.

    Fixed: rig A, an even mirror and one as uneven as at the primary level, the
    rays of one
    cylinder's marks in all six places; zero is below a millionth of a mm.
    """
    spreads, products = [], []
    for uneven in (0.0, ABERRATION_UM):
        camera = mirror_rig("A").camera(STAGES_MM[-1], uneven, SCENE_SEED)
        scene = moved_cylinder(camera, np.random.default_rng(SCENE_SEED))
        rays = seen_by(camera, scene.pixels).rays
        o, d = (
            np.concatenate([getattr(one, name) for one in rays])
            for name in ("origins", "directions")
        )
        spreads.append(centrality(Rays(o, d, np.ones(len(o), bool))))
        lines = [pluecker_of_rays(one.origins, one.directions) for one in rays]
        for k, L in enumerate(lines[1:], 1):
            products.append(np.abs(side_products(lines[0], L, scene.T[k])).max())
    return Reading.of(
        bool(min(spreads) > MIN_SPREAD_MM and max(products) < MAX_PRODUCT_MM),
        float(min(spreads)),
        "mm",
        "RMS distance of the rays from one point, even mirror and uneven: "
        f"{spreads[0]:.3g} and {spreads[1]:.3g} mm; largest product of matched lines "
        f"without noise {max(products):.0e} mm",
    )
