"""The numbers that the page quotes: medians over the seeds that came so far."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_4_distortion.results.exact import exact_radii
from chapters.ch05_flexible_mirror.s3_4_distortion.results.predicates import (
    BY_SEED,
    alike,
    face_left,
    radius_errors,
)
from chapters.ch05_flexible_mirror.s3_4_distortion.results.runs import (
    LAST,
    OTHER,
    RUNS,
    STAGES,
    CircleRuns,
)
from chapters.ch05_flexible_mirror.s3_4_distortion.trials.face import PER_PX
from repro.judge.statistics import median_and_range
from repro.page.reader import value

SHORT = {"bench": "", "laboratory": "lab."}


def middle(found):
    """Median of the trials that have a value, nan without any."""
    return median_and_range(found).value


def name_values(open_results):
    """Name the numbers of the prose."""
    results = {name: open_results(name) for name in (RUNS, OTHER)}
    for bench, short in SHORT.items():
        for name, number in quoted(CircleRuns(results, bench=bench)).items():
            value(f"{short}{name}", number)
    of_b = CircleRuns(results, geometry="B")
    value("b.refused", of_b.refused())
    value("b.seeds", of_b.seeds)
    value("exact", float(np.abs(exact_radii()).max()))


def quoted(runs):
    """{name: number} of one bench."""
    found = {"seeds": runs.seeds, "refused": runs.refused()}
    of_stages = {
        "radius": np.abs(radius_errors(runs)),
        "bundle.radius": np.abs(radius_errors(runs, "bundle")),
        "residual": runs.at("residual_mm"),
        "angle": runs.at("angle_deg"),
        "ring": runs.at("ring_deg"),
        "bundle.angle": runs.at("angle_deg", "bundle"),
        "pose": runs.at("pose_mm"),
        "true": runs.at("residual_mm", "true"),
        "conic": runs.at("conic_px", "picture"),
        "parallax": runs.at("parallax_mm", "true"),
        "single": runs.at("single_mm"),
    }
    for name, stages in of_stages.items():
        for stage in STAGES:
            found[f"{name}.{stage}"] = middle(stages[stage])
    found["radius.most"] = max(found[f"radius.{stage}"] for stage in STAGES)
    found["true.most"] = max(found[f"true.{stage}"] for stage in STAGES)
    found["growth"] = found[f"residual.{LAST}"] / found["residual.1"]
    found["angle.growth"] = found[f"angle.{LAST}"] / found["angle.1"]
    found["alike"] = middle(alike(runs))
    found["face"] = 100 * middle(face_left(runs))
    found["face.true"] = 100 * middle(face_left(runs, "true"))
    for name in ("raw", "corrected"):
        found[f"face.{name}"] = PER_PX * middle(runs.face(f"{name}_px"))
    for claim, predicate in BY_SEED.items():
        found[f"share.{claim}"] = 100 * float(np.mean(predicate(runs)[0]))
    return found
