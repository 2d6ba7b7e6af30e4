"""Which trials Fig. 5.7 and its claims read, and the numbers that the page quotes."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_2_reduced_model.trials.run import (
    OTHER_WAYS,
    PUBLISHED_WAY,
)
from chapters.ch05_flexible_mirror.s3_2_reduced_model.trials.sensitivity import (
    INJECTED_MM,
    KINDS,
)
from chapters.shared.mirror_bench import BENCH, BENCHES
from chapters.shared.mirror_bench import SWEPT as ENDS
from chapters.shared.mirror_sweep import READINGS as BENCH_READINGS
from repro.judge.statistics import trend, with_worst
from repro.page.reader import value
from repro.run.readings import Case

TIMES = 3.0  # the final error: from there on the prose counts linear errors as poor
RUNS, SWEPT, OTHER = "fig_5_7_runs", "fig_5_7_swept", "fig_5_7_other"
SENSITIVITY = "exp_c5_primary_sensitivity"
# The options of each question, as trials call them; each but the primary one is a way
# of its own to calibrate.
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
    """One reading of 5.3.2, with the primary option of what is not asked."""

    def __init__(self, options=None):
        super().__init__(READINGS, options)

    @property
    def way(self):
        """What the trials call the way to calibrate; at most one option differs."""
        return next((self[q] for q in WAYS if self[q] != PUBLISHED_WAY), PUBLISHED_WAY)

    def errors(self, results, bench, stage):
        """Mean distances (seeds,) of a curve from the scan, mm; nan where refused.

        stage: "before", "linear" or "final".
        """
        name = f"{bench}.{self.way}.{stage}.{self['scan_frame']}"
        return results[SWEPT if bench in ENDS else RUNS].column(name)


PRIMARY = ReducedCase()


def finals(result, kind):
    """Final errors (seeds, levels) mm with errors of a kind put in before; nan where
    refused."""
    return np.array(result.arrays("final_mm", kind=kind))


def medians_by_kind(result, kind):
    """Median final error of each level, mm; a refused seed is the worst."""
    return np.median(with_worst(finals(result, kind)), axis=0)


def final_over_injected(result, kind):
    """Slope of the median final error over the error put in, Estimate."""
    levels = list(finals(result, kind).T)
    return trend(
        np.array(INJECTED_MM), levels, lambda x, y: float(np.polyfit(x, y, 1)[0])
    )


def name_values(open_results):
    """Name the numbers of the prose."""
    results = {name: open_results(name) for name in (RUNS, SWEPT, OTHER)}
    for name, number in quoted(results).items():
        value(name, number)
    for kind in KINDS:
        slope = final_over_injected(open_results(SENSITIVITY), kind).value
        value(f"sensitivity.{kind}", slope)
    pictures = open_results("fig_5_6_pictures")
    for depth in ("280", "1000", "5000"):
        value(f"moved.{depth}", float(pictures.column(f"moved.{depth}")[0]))


def quoted(results):
    """Name -> number, of what the prose quotes: medians over the seeds."""
    out = {}
    for geometry, result in (("A", results[RUNS]), ("B", results[OTHER])):
        for bench in BENCHES:
            for key, number in of_bench(result, bench).items():
                out[f"{geometry}.{bench}.{key}"] = number
    for way in OTHER_WAYS:
        for stage in ("before", "final"):
            found = results[RUNS].column(f"{BENCH}.{way}.{stage}.camera_mm")
            out[f"{way}.{stage}"] = _middle(found)
    for end in ("half the factor", "half the aberration"):
        found = results[SWEPT].column(f"{end}.{PUBLISHED_WAY}.final.angle_deg")
        out[f"{end.replace(' ', '_')}.angle"] = _middle(found)
    for frame in FRAMES["scan_frame"].values():
        linear, final = (
            results[RUNS].column(f"{BENCH}.{PUBLISHED_WAY}.{stage}.{frame}")
            for stage in ("linear", "final")
        )
        out[f"ratio.{frame}"] = _middle(linear / final)
        out[f"poor.{frame}"] = 100 * float(np.mean(linear >= TIMES * final))
    return out


def of_bench(result, bench):
    """Name -> median over the seeds, as published; and how many were refused."""
    whose = f"{bench}.{PUBLISHED_WAY}"
    names = [
        f"{stage}.{frame}"
        for stage in ("before", "linear", "final")
        for frame in FRAMES["scan_frame"].values()
    ]
    names += ["linear.deflection_mm", "final.deflection_mm", "residual_mm",
              "before.angle_deg", "final.angle_deg", "back.own_mm", "back.true_mm",
              "corners", "reach"]  # fmt: skip
    out = {name: _middle(result.column(f"{whose}.{name}")) for name in names}
    out["reach"] *= 100
    final = result.column(f"{whose}.final.camera_mm")
    return out | {"refused": int(np.count_nonzero(np.isnan(final)))}


def _middle(found):
    return float(np.nanmedian(found))
