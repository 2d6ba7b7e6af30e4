"""The numbers that the page quotes: medians over the completed runs."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_deflections.results.geometry import camera_mm
from chapters.ch05_flexible_mirror.s3_3_deflections.results.predicates import (
    deflections_found,
)
from chapters.ch05_flexible_mirror.s3_3_deflections.results.runs import LAST, RUNS, Runs
from repro.judge.statistics import median_and_range
from repro.page.reader import value


def middle(found):
    """Median of the trials that have a value, nan without any."""
    return median_and_range(found).value


def name_values(open_results):
    """Name the numbers of the prose."""
    runs = Runs({RUNS: open_results(RUNS)})
    quoted = {
        "share.deflections": share(*deflections_found(runs)[:2]),
        "angle.0": middle(runs.of(0, "angle_deg")),
        f"angle.{LAST}": middle(runs.of(LAST, "angle_deg")),
        "true.1": middle(runs.of(1, "back_true_mm")),
        f"true.{LAST}": middle(runs.of(LAST, "back_true_mm")),
        "camera": camera_mm(),
    }
    for name, number in quoted.items():
        value(name, number)


def share(holds, found):
    """Of the completed runs, those in which a claim is true, %; nan without any."""
    done = ~np.isnan(found)
    return 100 * float(np.mean(holds[done])) if done.any() else np.nan
