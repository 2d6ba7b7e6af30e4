"""The numbers that the page quotes: medians over the seeds that came so far."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_deflections.results.curvature import ray_turns
from chapters.ch05_flexible_mirror.s3_3_deflections.results.geometry import (
    by_formula,
    camera_mm,
    depth_for,
)
from chapters.ch05_flexible_mirror.s3_3_deflections.results.predicates import (
    angles_by_place,
    deflection_errors,
    deflections_found,
    edge_residuals,
    linear_ratios,
)
from chapters.ch05_flexible_mirror.s3_3_deflections.results.predicates import (
    middle as words,
)
from chapters.ch05_flexible_mirror.s3_3_deflections.results.runs import (
    LAST,
    OTHER,
    RUNS,
    SHIFT_MM,
    STAGES,
    TIPS,
    TIPS_SWEPT,
    Runs,
)
from chapters.ch05_flexible_mirror.s3_3_deflections.results.tips import (
    Tips,
    among_sd,
    tip_sd,
)
from chapters.shared.mirror_bench import BENCH, SWEPT
from chapters.shared.mirror_rigs import STAGES_MM, mirror_rig
from repro.judge.statistics import median_and_range
from repro.page.reader import value

SHORT = {"bench": "", "laboratory": "lab."}
# What a refusal says of an end that swings.
SWINGS = "rays would turn"
MEASURES = {
    "angle": "angle_deg",
    "measured": "measured_deg",
    "back": "back_mm",
    "true": "back_true_mm",
    "residual": "residual_mm",
}
SHARES = {"deflections": deflections_found, "edges": edge_residuals}


def middle(found):
    """Median of the trials that have a value, nan without any."""
    return median_and_range(found).value


def name_values(open_results):
    """Name the numbers of the prose."""
    results = {name: open_results(name) for name in (RUNS, OTHER)}
    for bench, short in SHORT.items():
        for name, number in quoted(Runs(results, bench=bench)).items():
            value(f"{short}{name}", number)
    for bench, short in SHORT.items():
        of_b = Runs(results, bench=bench, geometry="B")
        # Words, since a few seeds may all be refused there.
        value(f"b.{short}angle.3", words(of_b.of(LAST, "angle_deg")))
    of_b = Runs(results, geometry="B")
    value("b.linear.1", middle(linear_ratios(of_b)[0]))
    value("b.refused", refusals(of_b))
    value("b.swinging", swings(of_b))
    value("b.seeds", of_b.seeds)
    for geometry, short in (("A", ""), ("B", "b.")):
        value(f"{short}formula", by_formula(geometry))
        value(f"{short}camera", camera_mm(geometry))
    value("depth.low", depth_for(0.54))
    value("depth.high", depth_for(0.65))
    value("ratio.low", depth_for(0.54) / camera_mm())
    value("ratio.high", depth_for(0.65) / camera_mm())
    name_tip_values(open_results)


def name_tip_values(open_results):
    """Name the numbers about the tip, and about turns of rays at stage 3."""
    results = {name: open_results(name) for name in (TIPS, TIPS_SWEPT)}
    tips = Tips.on(results, BENCH)
    tip, mean, square = tips.moments()
    value("tip.load", 1000 * float(tip_sd(tip)))
    value("tip.among", 1000 * float(among_sd(mean, square)))
    value("tip.beyond", middle(tips.of("beyond_mm")))
    value("tip.ratio", tips.ratio().value)
    value("tip.surface", tips.ratio(of_surface=True).value)
    value("lab.tip.ratio", Tips.on(results, "laboratory").ratio().value)
    ends = [Tips.on(results, end).ratio().value for end in SWEPT]
    value("tip.least", min(ends))
    value("tip.most", max(ends))
    turns = ray_turns(mirror_rig("A").camera(STAGES_MM[-1]))
    whole = turns.over_twice(turns.whole)
    value("curved.least", float(whole.min()))
    value("curved.most", float(whole.max()))


def refusals(runs):
    """How many seeds ended early."""
    return sum(reason is not None for reason in runs.refused())


def swings(runs):
    """How many seeds ended since the spline would swing at an end of the mirror."""
    return sum(SWINGS in (reason or "") for reason in runs.refused())


def quoted(runs):
    """{name: number} of one bench and geometry."""
    found = {
        f"{short}.{stage}": middle(runs.of(stage, name))
        for short, name in MEASURES.items()
        for stage in (0, 1, LAST)
        if (short, stage) != ("residual", 0)
    }
    for stage, ratios, off in zip(
        (1, 2, 3), linear_ratios(runs), deflection_errors(runs), strict=True
    ):
        found[f"linear.{stage}"] = middle(ratios)
        found[f"off.{stage}"] = middle(off)
    found["linear.most"] = float(np.nanmax(linear_ratios(runs)))
    found["worst"] = middle(np.abs(deflection_errors(runs)).max(axis=0))
    found["left"] = middle(runs.of(LAST, "back_mm") / runs.of(LAST, "stale_mm"))
    found["growth"] = found["angle.3"] / found["angle.0"]
    clamped, _, free = angles_by_place(runs)[:, LAST]
    found |= {"clamped": middle(clamped), "free": middle(free)}
    for name, predicate in SHARES.items():
        found[f"share.{name}"] = 100 * float(np.mean(predicate(runs)[0]))
    found["shift.most"] = middle(
        np.abs(runs.at("shift_mm", STAGES) - SHIFT_MM).max(axis=0)
    )
    found["turn.most"] = middle(runs.at("turn_deg", STAGES).max(axis=0))
    found["refused"] = refusals(runs)
    found["swinging"] = swings(runs)
    found["seeds"] = runs.seeds
    return found
