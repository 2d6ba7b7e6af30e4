"""The numbers that the page quotes: medians over seeds, unless they say else."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_repeatability.results import causes, predicates
from chapters.ch05_flexible_mirror.s3_3_repeatability.results.runs import (
    BACK,
    OTHER,
    PANELS,
    PLACED,
    RUNS,
    STARTED,
    STEP_MM,
    THERE,
    LoopRuns,
)
from chapters.ch05_flexible_mirror.s3_3_repeatability.results.vectors import edge_ratios
from chapters.ch05_flexible_mirror.s3_3_repeatability.trials.starts import STEPS_MM
from chapters.shared.mirror_bench import BENCH
from repro.judge.statistics import with_worst
from repro.page.reader import value

CASES = {"": {}, "lab.": {"bench": "laboratory"}}


def name_values(open_results):
    """Name the numbers of the prose."""
    results = {name: open_results(name) for name in (RUNS, OTHER, PLACED, STARTED)}
    for prefix, case in CASES.items():
        for name, number in _of_loops(LoopRuns(results, **case)).items():
            value(prefix + name, number)
    other = LoopRuns(results, geometry="B")
    # On B few seeds, if any, come through: only the first step has a median.
    value("b.refused", other.refused()[0])
    value("b.seeds", other.seeds)
    value("b.linear", median(other.of("step1", "linear_mm")) / STEP_MM)
    for name, number in _of_causes(open_results, LoopRuns(results)).items():
        value(name, number)
    for name, number in _of_one_step(results[PLACED], results[STARTED]).items():
        value(name, number)


def median(found):
    """Median (seeds,) in which a refused seed is the worst."""
    return float(np.median(with_worst(found)))


def _of_loops(runs):
    """What the loop gave on one bench, by name."""
    errors = np.abs(predicates.height_errors(runs))
    staged = runs.at("deflection_mm", BACK).sum(axis=0)
    places = {"start": "start", "third": "step3", "end": "step6", "single": "single"}
    measures = {"back": "back_mm", "true": "back_true_mm", "angle": "angle_deg"}
    refused = runs.refused()
    apart, opened = predicates.disagreement(runs), predicates.loop_error(runs)
    whole = np.isfinite(opened)
    return {
        f"{short}.{place}": median(runs.of(where, name))
        for short, name in measures.items()
        for place, where in places.items()
    } | {
        "linear": median(runs.at("linear_mm").mean(axis=0) / STEP_MM),
        "apart": median(apart),
        "apart.share": 100 * np.mean(apart[whole] <= predicates.MOST_APART),
        "open": median(opened),
        "open.share": 100 * np.mean(opened[whole] <= predicates.MOST_OPEN_MM),
        "single.apart": median(predicates.single_difference(runs)),
        "single.mm": median(runs.of("single", "deflection_mm")),
        "staged.mm": median(staged),
        "height.third": median(errors[THERE[-1] - 1]),
        "height.end": median(errors[-1]),
        "growth": predicates.growth(runs).value,
        "growth.true": predicates.growth(runs, "back_true_mm").value,
        "residual.first": median(runs.of("step1", "residual_mm")),
        "residual.end": median(runs.of("step6", "residual_mm")),
        "residual.single": median(runs.of("single", "residual_mm")),
        "common.step": np.nanmedian(runs.at("common", BACK)),
        "common.single": np.nanmedian(runs.of("single", "common")),
        "refused": refused[0],
        "refused.single": refused[1],
        "seeds": runs.seeds,
    }


def _of_one_step(placed, started):
    """What places of the board and perturbed starts gave on the bench, by name."""
    sd = {
        f"placed.{pitch}": predicates.pooled_sd(placed, BENCH, pitch).value
        for pitch in ("coarse", "dense")
    }
    starts = {
        f"starts.{step}": median(predicates.of_starts(started, BENCH, step, mm))
        for step, mm in STEPS_MM.items()
    }
    ends = {
        f"starts.{which}": 100
        * np.median(started.column(f"{BENCH}.5.{which}_start_mm"))
        / STEPS_MM["5"]
        for which in ("least", "most")
    }
    return sd | starts | ends


def _of_causes(open_results, runs):
    """What steps have to see, the known metric, and the board's edge, by name."""
    seen, _ = causes.CONDITIONED
    results = {seen: open_results(seen)}
    found = {"seen.seeds": results[seen].trials_per_condition}
    for name in causes.MEASURES:
        steps = causes.of_steps(results, BENCH, name)
        for way, which in (("out", THERE), ("back", BACK)):
            means = steps[np.subtract(which, 1)].mean(axis=0)
            found[f"{name}.{way}"] = np.nanmedian(means)
        ratios = causes.back_over_out(results, BENCH, name)
        found[f"{name}.larger"] = np.count_nonzero(ratios > 1)
    found["seen.whole"] = np.count_nonzero(np.isfinite(ratios))
    ablated = open_results(causes.METRIC)
    found["metric.seeds"] = ablated.trials_per_condition
    found["metric.steps_mm"] = _median_of(causes.while_both_go_on(ablated))
    for arm in causes.ARMS:
        found[f"metric.{arm}.refused"] = causes.refused(ablated, arm)
    for place in PANELS:
        ratios = edge_ratios(runs, place)
        known = ratios[np.isfinite(ratios)]
        found[f"edge.{place}"] = 100 * np.mean(known < 1) if len(known) else np.nan
    return found


def _median_of(values):
    return float(np.median(values)) if len(values) else np.nan
