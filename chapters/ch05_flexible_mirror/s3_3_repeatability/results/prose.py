"""The numbers that the page quotes: medians over completed runs."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_repeatability.results import causes
from chapters.ch05_flexible_mirror.s3_3_repeatability.results.runs import (
    RUNS,
    STEPS,
    THERE,
    LoopRuns,
)
from chapters.ch05_flexible_mirror.s3_3_repeatability.trials.film import update_seconds
from repro.judge.statistics import median_and_range
from repro.page.reader import value

MS = 1000.0


def name_values(open_results):
    """Name the numbers of the prose."""
    runs = LoopRuns({RUNS: open_results(RUNS)})
    last = f"step{STEPS[-1]}"
    more = runs.of("single", "back_mm") / runs.of(last, "back_mm")
    quoted = {
        "single.worse": 100 * float(np.mean(more[np.isfinite(more)] > 1)),
        "angle.start": median(runs.of("start", "angle_deg")),
        "angle.end": median(runs.of(last, "angle_deg")),
        "film.update_ms": MS * update_seconds(),
    }
    quoted |= quoted_of_metric(open_results(causes.METRIC))
    for name, number in quoted.items():
        value(name, number)


def median(found):
    """Median of the runs (seeds,) that have a value, nan without any."""
    return median_and_range(found).value


def quoted_of_metric(result):
    """Back-projection error at stage 3 with the board's known metric and without."""
    return {
        f"metric.{arm}.third": median(causes.errors_of(result, arm)[THERE[-1] - 1])
        for arm in causes.ARMS
    }
