"""The numbers that the page quotes: medians over the seeds that came so far."""

import numpy as np

from chapters.ch05_flexible_mirror.s4_self_calibration.results import predicates
from chapters.ch05_flexible_mirror.s4_self_calibration.results.known import slopes
from chapters.ch05_flexible_mirror.s4_self_calibration.results.runs import (
    KNOWN,
    OBJECTS,
    RUNS,
    TOLD,
    WAYS,
    Courses,
)
from repro.judge.statistics import median_and_range
from repro.page.reader import value

SHORT = {"bench": "", "laboratory": "lab."}
STEPPED = ("linear", "feedback6", "edges", "lines", "one_depth", "one_depth_held")


def middle(found):
    """Median of the trials that have a value, nan without any."""
    return median_and_range(found).value


def name_values(open_results):
    """Name the numbers of the prose."""
    results = {name: open_results(name) for name in (RUNS, WAYS, KNOWN)}
    for bench, short in SHORT.items():
        for name, number in quoted(Courses(results, bench=bench)).items():
            value(f"{short}{name}", number)
    for depth, short in ((0.0, "far"), (800.0, "near")):
        found = results[WAYS].select(depth_mm=depth)
        for way in STEPPED:
            value(f"{short}.{way}", middle(found.column(f"{way}.deflection_mm")))
            value(f"{short}.{way}.deg", middle(found.column(f"{way}.angle_deg")))
    value("known.slope", float(np.mean(slopes(results[KNOWN], "known"))))
    value("boards.slope", float(np.mean(slopes(results[KNOWN], "boards"))))


def quoted(runs):
    """{name: number} of one bench."""
    found = {"seeds": runs.seeds}
    for way in (TOLD, "clustered", "near", "even", "board"):
        went = runs.of(way, "deflection_mm")
        for k, one in enumerate(went, 1):
            # Words, since all seeds of a stage may be refused.
            found[f"{way}.{k}"] = predicates.middle(one)
        found[f"{way}.sag"] = predicates.middle(np.abs(runs.of(way, "sag_mm"))[-1])
        found[f"{way}.deg"] = predicates.middle(runs.of(way, "angle_deg")[-1])
        found[f"{way}.refused"] = sum(text is not None for text in runs.refused(way))
    found["whole"] = sum(text is not None for text in runs.refused("whole"))
    found["start"] = middle(runs.column("start_deg"))
    found["again"] = middle(runs.column("again_deg"))
    for cameras in ("found", "true"):
        for name in ("deflected", "baseline", "board"):
            of = runs.column(f"stereo.{cameras}.{name}")
            found[f"{cameras}.{name}"] = 100 * middle(of)
        for one in OBJECTS:
            for name in ("centroid_mm", "median_mm", "spread_mm", "ratio"):
                of = runs.column(f"multi.{cameras}.{one}.{name}")
                found[f"{cameras}.{one}.{name.removesuffix('_mm')}"] = middle(of)
    found["ordered"] = 100 * float(np.mean(predicates.order(runs)[0]))
    return found
