"""The numbers that the page quotes: medians over the seeds that came so far."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_deflections.results.geometry import (
    by_formula,
    camera_mm,
    depth_for,
)
from chapters.ch05_flexible_mirror.s3_3_deflections.results.predicates import (
    angles_by_place,
    angles_not_worse,
    angles_spatial,
    deflection_errors,
    deflections_found,
    edge_residuals,
    linear_ratios,
    pose_reflection,
)
from chapters.ch05_flexible_mirror.s3_3_deflections.results.runs import (
    LAST,
    OTHER,
    RUNS,
    STAGES,
    Runs,
)
from repro.page.reader import value

SHORT = {"bench": "", "laboratory": "lab."}
MEASURES = {
    "angle": "angle_deg",
    "measured": "measured_deg",
    "back": "back_mm",
    "true": "back_true_mm",
    "residual": "residual_mm",
    "stale": "stale_mm",
}
SHARES = {
    "poses": pose_reflection,
    "deflections": deflections_found,
    "not_worse": angles_not_worse,
    "spatial": angles_spatial,
    "edges": edge_residuals,
}


def middle(found):
    """Median of the trials that have a value."""
    return float(np.nanmedian(found))


def name_values(open_results):
    """Name the numbers of the prose."""
    results = {name: open_results(name) for name in (RUNS, OTHER)}
    for bench, short in SHORT.items():
        for name, number in quoted(Runs(results, bench=bench)).items():
            value(f"{short}{name}", number)
    for bench, short in SHORT.items():
        of_b = quoted(Runs(results, bench=bench, geometry="B"))
        for name in ("linear.1", "linear.3", "worst", "angle.3", "refused"):
            value(f"b.{short}{name}", of_b[name])
    for geometry, short in (("A", ""), ("B", "b.")):
        value(f"{short}formula", by_formula(geometry))
        value(f"{short}camera", camera_mm(geometry))
    value("depth.low", depth_for(0.54))
    value("depth.high", depth_for(0.65))
    value("ratio.low", depth_for(0.54) / camera_mm())
    value("ratio.high", depth_for(0.65) / camera_mm())


def quoted(runs):
    """{name: number} of one bench and geometry."""
    found = {
        f"{short}.{stage}": middle(runs.of(stage, name))
        for short, name in MEASURES.items()
        for stage in STAGES
        if np.isfinite(runs.of(stage, name)).any()
    }
    for stage, ratios, off in zip(
        (1, 2, 3), linear_ratios(runs), deflection_errors(runs), strict=True
    ):
        found[f"linear.{stage}"] = middle(ratios)
        found[f"off.{stage}"] = middle(off)
    found["worst"] = middle(np.abs(deflection_errors(runs)).max(axis=0))
    found["left"] = middle(runs.of(LAST, "back_mm") / runs.of(LAST, "stale_mm"))
    found["growth"] = found["angle.3"] / found["angle.0"]
    found["measured_growth"] = found["measured.3"] / found["measured.0"]
    clamped, whole, free = np.nanmedian(angles_by_place(runs)[:, LAST], axis=-1)
    found |= {"clamped": float(clamped), "whole": float(whole), "free": float(free)}
    for name, predicate in SHARES.items():
        found[f"share.{name}"] = 100 * float(np.mean(predicate(runs)[0]))
    found["shift.most"] = middle(np.abs(runs.at("shift_mm", STAGES) - 100).max(axis=0))
    found["turn.most"] = middle(runs.at("turn_deg", STAGES).max(axis=0))
    found["refused"] = sum(reason is not None for reason in runs.refused())
    found["seeds"] = runs.seeds
    return found
