"""The numbers that the page quotes: medians over seeds, unless they say else."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_repeatability.results import causes, predicates
from chapters.ch05_flexible_mirror.s3_3_repeatability.results.film import (
    FILM,
    Frames,
    quoted_of_film,
)
from chapters.ch05_flexible_mirror.s3_3_repeatability.results.relief import (
    RELIEF,
    ReliefRuns,
)
from chapters.ch05_flexible_mirror.s3_3_repeatability.results.runs import (
    OTHER,
    PLACED,
    RUNS,
    STARTED,
    STEP_MM,
    THERE,
    LoopRuns,
)
from chapters.ch05_flexible_mirror.s3_3_repeatability.trials.starts import STEPS_MM
from chapters.shared.mirror_bench import LEVEL
from repro.judge.statistics import median_and_range
from repro.page.reader import value


def name_values(open_results):
    """Name the numbers of the prose."""
    results = {name: open_results(name) for name in (RUNS, OTHER)}
    other = LoopRuns(results, geometry="B")
    relief = ReliefRuns.of({RELIEF: open_results(RELIEF)})
    quoted = quoted_of_loops(LoopRuns(results)) | {
        "lab.refused": LoopRuns(results, bench="laboratory").refused()[0],
        # On B few seeds, if any, come through: only the first step has a median.
        "b.refused": other.refused()[0],
        "b.seeds": other.seeds,
        "b.linear": median(other.of("step1", "linear_mm")) / STEP_MM,
        "relief.rise": relief.rise().value,
        "relief.removed": relief.removed().value,
    }
    quoted |= quoted_of_one_step(open_results(PLACED), open_results(STARTED))
    quoted |= quoted_of_metric(open_results(causes.METRIC))
    quoted |= quoted_of_film(Frames.of(open_results(FILM)))
    for name, number in quoted.items():
        value(name, number)


def median(found):
    """Median of the seeds (seeds,) that have a value, nan without any."""
    return median_and_range(found).value


def quoted_of_loops(runs):
    """What the loop gave at one level, by name."""
    more = 100 * (runs.of("single", "back_mm") / runs.of("step6", "back_mm") - 1)
    places = {"start": "start", "end": "step6", "single": "single"}
    measures = {"back": "back_mm", "true": "back_true_mm", "angle": "angle_deg"}
    return {
        f"{short}.{place}": median(runs.of(where, name))
        for short, name in measures.items()
        for place, where in places.items()
    } | {
        "linear": median(runs.at("linear_mm").mean(axis=0) / STEP_MM),
        "apart": median(predicates.disagreement(runs)),
        "open": median(predicates.loop_error(runs)),
        "single.apart": median(predicates.single_difference(runs)),
        "single.worse": 100 * float(np.mean(more[np.isfinite(more)] > 0)),
        "single.more": median(more),
        "height.end": median(np.abs(predicates.height_errors(runs))[-1]),
        "growth": growth(runs, "back_mm"),
        "growth.true": growth(runs, "back_true_mm"),
        "residual.first": median(runs.of("step1", "residual_mm")),
        "residual.end": median(runs.of("step6", "residual_mm")),
        "refused": runs.refused()[0],
        "seeds": runs.seeds,
    }


def growth(runs, name):
    """Growth of a measure over the six steps, % a step, of the completed runs."""
    done = runs.completed
    return predicates.growth(runs, name, done).value if done.any() else np.nan


def quoted_of_one_step(placed, started):
    """What places of the board and perturbed starts gave on the bench, by name."""
    sd = {
        f"placed.{pitch}": predicates.pooled_sd(placed, LEVEL, pitch).value
        for pitch in ("coarse", "dense")
    }
    return sd | {
        f"starts.{step}": median(predicates.of_starts(started, LEVEL, step, mm))
        for step, mm in STEPS_MM.items()
    }


def quoted_of_metric(result):
    """Back-projection error at stage 3 with the board's known metric and without."""
    return {
        f"metric.{arm}.third": median(causes.errors_of(result, arm)[THERE[-1] - 1])
        for arm in causes.ARMS
    }
