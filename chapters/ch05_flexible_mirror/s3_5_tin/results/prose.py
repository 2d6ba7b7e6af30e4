"""The numbers that the page quotes: medians over the seeds that have a tin."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_tin.results.predicates import (
    angles_found,
    distances_normal,
)
from chapters.ch05_flexible_mirror.s3_5_tin.results.runs import (
    OTHER,
    PICTURES,
    RUNS,
    WAYS,
    TinRuns,
)
from chapters.shared.mirror_bench import BENCH, BENCHES
from repro.judge.statistics import median_and_range
from repro.page.reader import value

SHORT = {"bench": "", "laboratory": "lab."}
MEASURES = {"off": "off_deg", "rms": "rms_mm", "ray": "ray_deg"}


def middle(found):
    """Median of the trials that have a value, nan without any."""
    return median_and_range(found).value


def name_values(open_results):
    """Name the numbers of the prose."""
    results = {name: open_results(name) for name in (RUNS, OTHER, PICTURES)}
    for name, found in of_runs(results).items():
        value(name, found)
    for name, found in of_pictures(results[PICTURES]).items():
        value(name, found)


def of_runs(results):
    """Name -> what prose quotes of both geometries."""
    out = {}
    for geometry, bench in ((g, b) for g in "AB" for b in BENCHES):
        runs = TinRuns(results, bench=bench, geometry=geometry)
        short = ("" if geometry == "A" else "b.") + SHORT[bench]
        for way in WAYS:
            for name, measure in MEASURES.items():
                out[f"{short}{way}.{name}"] = middle(runs.of(measure, way))
            lost = np.count_nonzero(~np.isfinite(runs.of("off_deg", way)))
            out[f"{short}{way}.refused"] = lost
        for way, motion in (("true", "free"), ("true", "length"), ("bundle", "length")):
            found = runs.of(f"{motion}.off_deg", way)
            out[f"{short}{way}.{motion}"] = middle(found)
        out[f"{short}seeds"] = runs.seeds
        if geometry == "A":
            out[f"{short}share.angles"] = 100 * np.mean(angles_found(runs)[0])
            out[f"{short}share.normal"] = 100 * np.mean(distances_normal(runs)[0])
    return out


def of_pictures(result):
    """Name -> what prose quotes of the rendered pictures."""
    names = ("matches", "on_tin", "wrong", "match_px")
    out = {f"pic.{name}": middle(result.column(f"{BENCH}.{name}")) for name in names}
    for way in WAYS:
        for bench, short in SHORT.items():
            found = result.column(f"{bench}.{way}.off_deg")
            out[f"pic.{short}{way}.off"] = middle(found)
    for name, measure in (("left_out", "left_out"), ("kept", "wrong_kept")):
        out[f"pic.{name}"] = middle(result.column(f"{BENCH}.true.{measure}"))
    return out | {"pic.seeds": result.trials_per_condition}
