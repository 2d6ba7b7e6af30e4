"""Numbers quoted on the page: medians over the runs that completed, in words.

Where no run completed, as in quick builds, there are words for that.
"""

import numpy as np

from chapters.ch05_flexible_mirror.s3_4_distortion.results.predicates import (
    alike,
    face_left,
    radius_errors,
)
from chapters.ch05_flexible_mirror.s3_4_distortion.results.runs import (
    LAST,
    RUNS,
    CircleRuns,
)
from chapters.shared.mirror_bench import LEVEL
from repro.judge.statistics import median_and_range
from repro.page.reader import value


def in_words(number, form=".2g"):
    """A number in the format of the prose."""
    return format(float(number), form) if np.isfinite(number) else "(no number)"


def middle(found):
    """Median of the trials that have a value, nan without any."""
    return median_and_range(found).value


def name_values(open_results):
    """Name the numbers of the prose."""
    runs = CircleRuns({RUNS: open_results(RUNS)}, bench=LEVEL)
    value(f"radius.{LAST}", in_words(middle(np.abs(radius_errors(runs))[LAST])))
    for stage in (0, LAST):
        value(f"angle.{stage}", in_words(middle(runs.of(stage, "angle_deg"))))
    value("alike", in_words(middle(alike(runs))))
    for name, camera in (("face", "calibrated"), ("face.true", "true")):
        value(name, in_words(100 * middle(face_left(runs, camera)), ".0f"))
