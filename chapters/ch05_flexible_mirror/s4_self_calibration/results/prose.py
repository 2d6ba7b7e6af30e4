"""The numbers that the page quotes: medians over the seeds that came so far, as words,
since of a stage all seeds may be refused."""

import numpy as np

from chapters.ch05_flexible_mirror.s4_self_calibration.results import predicates
from chapters.ch05_flexible_mirror.s4_self_calibration.results.known import slopes
from chapters.ch05_flexible_mirror.s4_self_calibration.results.runs import (
    KNOWN,
    OBJECTS,
    RUNS,
    SWEPT_RUNS,
    TOLD,
    Courses,
)
from chapters.shared.mirror_bench import LABORATORY, LEVEL
from repro.judge.statistics import median_and_range
from repro.page.reader import value

SHORT = {LEVEL: "", LABORATORY: "lab."}
NONE = "none"


def said(found, digits=2):
    """Median of the trials that have a value, as words."""
    middle = median_and_range(found).value
    return f"{middle:.{digits}f}" if np.isfinite(middle) else NONE


def name_values(open_results):
    """Name the numbers of the prose."""
    results = {name: open_results(name) for name in (RUNS, SWEPT_RUNS, KNOWN)}
    for bench in SHORT:
        runs = Courses(results, bench=bench)
        for name, words in (of_scenes(runs) | of_views(runs)).items():
            value(f"{SHORT[bench]}{name}", words)
    value("swept.seeds", results[SWEPT_RUNS].trials_per_condition)
    for way in ("known", "boards"):
        value(f"{way}.slope", f"{np.mean(slopes(results[KNOWN], way)):.2f}")
    value("known.seeds", results[KNOWN].trials_per_condition)


def of_scenes(runs):
    """{name: words} of what self-calibration finds on a bench."""
    found = {"seeds": runs.seeds}
    for way in (TOLD, "clustered", "near", "even", "board"):
        for k, one in enumerate(runs.of(way, "deflection_mm"), 1):
            found[f"{way}.{k}"] = said(one)
        for k, one in enumerate(runs.of(way, "angle_deg"), 1):
            found[f"{way}.deg.{k}"] = said(one, 3 if way == "board" else 1)
        found[f"{way}.sag"] = said(np.abs(runs.of(way, "sag_mm"))[-1], 1)
        found[f"{way}.refused"] = sum(text is not None for text in runs.refused(way))
        at_load = runs.of(way, "deflection_mm")[-1]
        found[f"{way}.reach"] = int(np.isfinite(at_load).sum())
    sides = runs.of("clustered", "sag_mm")[-1]
    found["sides"] = int(np.isfinite(sides).sum())
    for way in ("near", "even"):
        found[f"{way}.inflected"] = (
            f"{100 * runs.inflected(way).all(axis=0).mean():.0f}"
        )
    found["whole"] = sum(text is not None for text in runs.refused("whole"))
    return found


def of_views(runs):
    """{name: words} of stereo between states, and of all of them."""
    found = {"ordered": f"{100 * np.mean(predicates.order(runs)[0]):.0f}"}
    found["edge"] = said(predicates.edge_times(runs), 1)
    found["apart"] = said(runs.column("stereo.apart_mm"), 0)
    found["finer"] = said(runs.column("stereo.finer"), 0)
    for cameras in ("found", "true"):
        for name in ("deflected", "baseline", "board"):
            of = 100 * runs.column(f"stereo.{cameras}.{name}")
            found[f"{cameras}.{name}"] = said(of, 1 if cameras == "found" else 2)
        for one in OBJECTS:
            ratio, spread = (
                runs.column(f"multi.{cameras}.{one}.{name}")
                for name in ("ratio", "spread_mm")
            )
            found[f"{cameras}.{one}.ratio"] = said(ratio)
            found[f"{cameras}.{one}.spread"] = said(spread / 1000, 1)
    return found
