"""Numbers quoted on the page: medians over the runs that completed, as words.

All runs of a stage may be rejected.
"""

import numpy as np

from chapters.ch05_flexible_mirror.s4_self_calibration.results.runs import (
    RUNS,
    THESIS_SCENE,
    Courses,
)
from chapters.shared.mirror_bench import LABORATORY, LEVEL
from repro.judge.statistics import median_and_range
from repro.page.reader import value

NONE = "none"


def median_words(found, digits=2):
    """Median of the runs that have a value, as words."""
    middle = median_and_range(found).value
    return f"{middle:.{digits}f}" if np.isfinite(middle) else NONE


def name_values(open_results):
    """Name the numbers of the prose."""
    results = {RUNS: open_results(RUNS)}
    low_noise = Courses(results, bench=LABORATORY)
    found = low_noise.of(THESIS_SCENE, "deflection_mm")
    value("lab.told.1", median_words(found[0]))
    value("lab.told.3", median_words(found[-1]))
    for way, digits in ((THESIS_SCENE, 1), ("board", 3)):
        angle = low_noise.of(way, "angle_deg")[-1]
        value(f"lab.{way}.deg.3", median_words(angle, digits))
    runs = Courses(results, bench=LEVEL)
    for cameras, digits in (("found", 1), ("true", 2)):
        error = 100 * runs.column(f"stereo.{cameras}.deflected")
        value(f"{cameras}.deflected", median_words(error, digits))
