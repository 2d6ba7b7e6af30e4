"""Trials of Fig. 5.7 and its claims, and the numbers quoted on the page."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_2_reduced_model.trials.run import PUBLISHED_WAY
from chapters.ch05_flexible_mirror.s3_2_reduced_model.trials.sensitivity import (
    INJECTED_MM,
)
from chapters.shared.mirror_bench import LEVEL
from chapters.shared.mirror_bench import SWEPT as ENDS
from chapters.shared.mirror_sweep import READINGS as BENCH_READINGS
from repro.judge.statistics import trend, with_worst
from repro.page.reader import value
from repro.run.readings import Case

RUNS, SWEPT = "fig_5_7_runs", "fig_5_7_swept"
SENSITIVITY = "exp_c5_primary_sensitivity"
# Options of each question, as trials call them; each except the primary one is a
# calibration of its own.
WAYS = {
    "reduced_curve": {
        "distance along the viewing rays": PUBLISHED_WAY,
        "height over the clamped line": "height",
    },
    "reduced_start": {
        "shape from normals, scale from points": PUBLISHED_WAY,
        "mirror points": "points",
    },
    "reduced_corners": {"all": PUBLISHED_WAY, "middle strip": "strip"},
}
FRAMES = {
    "scan_frame": {
        "camera's frame": "camera_mm",
        "aligned before bending": "shared_mm",
        "each aligned": "alone_mm",
    }
}
READINGS = BENCH_READINGS | WAYS | FRAMES


class ReducedCase(Case):
    """One interpretation of 5.3.2, with primary options where none is given."""

    def __init__(self, options=None):
        super().__init__(READINGS, options)

    @property
    def way(self):
        """The trials' name of the calibration; at most one option differs."""
        return next((self[q] for q in WAYS if self[q] != PUBLISHED_WAY), PUBLISHED_WAY)

    def errors(self, results, bench, stage):
        """Mean distances (seeds,) of a curve from the scan, mm; nan where rejected.

        stage: "before", "linear" or "final".
        """
        name = f"{bench}.{self.way}.{stage}.{self['scan_frame']}"
        return results[SWEPT if bench in ENDS else RUNS].column(name)


PRIMARY = ReducedCase()


def finals(result, kind):
    """Final errors (seeds, levels) mm with added errors; nan where rejected."""
    return np.array(result.arrays("final_mm", kind=kind))


def medians_by_kind(result, kind):
    """Median final error of each level, mm; a rejected run counts as the worst."""
    return np.median(with_worst(finals(result, kind)), axis=0)


def final_over_injected(result, kind):
    """Slope of the median final error over the added error, Estimate."""
    levels = list(finals(result, kind).T)
    return trend(
        np.array(INJECTED_MM), levels, lambda x, y: float(np.polyfit(x, y, 1)[0])
    )


def name_values(open_results):
    """Name the numbers of the prose: medians over the runs at the primary level."""
    result = open_results(RUNS)
    whose = f"{LEVEL}.{PUBLISHED_WAY}"
    before = result.column(f"{whose}.before.camera_mm")
    value(f"{LEVEL}.before.camera_mm", float(np.nanmedian(before)))
    for frame in FRAMES["scan_frame"].values():
        linear, final = (
            result.column(f"{whose}.{stage}.{frame}") for stage in ("linear", "final")
        )
        value(f"ratio.{frame}", float(np.nanmedian(linear / final)))
    slope = final_over_injected(open_results(SENSITIVITY), "all")
    value("sensitivity.all", slope.value)
