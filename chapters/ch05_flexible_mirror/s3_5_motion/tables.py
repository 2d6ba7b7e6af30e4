"""Table 5.7 and the numbers of 5.3.5 about motion."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_motion.results.runs import EACH_STEP, MotionRuns
from chapters.ch05_flexible_mirror.s3_5_motion.trials.motion import MARKER_MM
from chapters.ch05_flexible_mirror.s3_5_motion.trials.scene import (
    MARKS,
    RADIUS_MM,
    STEP_MM,
)
from chapters.shared.mirror_tables import MEDIANS, reached
from repro.run.columns import columns
from repro.run.experiment import numbers, table
from repro.run.outcomes import Table, Value

NEEDS = ("table_5_7_runs",)
MOVED = "the cylinder is moved by this distance"
MADE = "the cylinder has this size"


@table("table_5_7", needs=NEEDS, evidence="rendered")
def table_5_7(results):
    """Translations and rotations added up, as in the thesis."""
    runs = MotionRuns(results)
    lengths, turns, off = (
        runs.steps(name) for name in ("length_mm", "turn_deg", "off_mm")
    )
    given = runs.steps("turn_deg", way="given")
    true = runs.steps("turn_deg", "true", "given")
    rows = [
        (int(k * STEP_MM), *(reached(one[k - 1]) for one in
         (lengths, turns, off, given, true)))
        for k in EACH_STEP
    ]  # fmt: skip
    names = (
        "Ground truth (mm)",
        "Translation (mm)",
        "Rotation (°)",
        "Position error (mm)",
        "Rotation, lengths given (°)",
        "Rotation, lengths given, true mirror (°)",
    )
    ids = {
        title: [f"t5_7_{k * STEP_MM:.0f}_{end}" for k in EACH_STEP]
        for title, end in zip(names, ("gt", "t", "r"), strict=False)
    }
    return Table(
        columns(names, rows),
        "Translations and rotations of the cylinder, estimated from each image to the "
        "next and added up, with the mean step scaled to the true one. Second level, "
        f"mirror calibrated stage by stage; the true rotation is 0. {MEDIANS} Right: "
        "rotations with given step lengths.",
        printed=ids,
    )


def of_runs(runs, found, unit):
    """Return the Value of a measure (seeds,), and how many runs have none.

    Infinite where no run has one.
    """
    lost = np.count_nonzero(~np.isfinite(found))
    reason = f"{lost} of {runs.seeds} runs have none" if lost else ""
    if lost == runs.seeds:
        return Value(np.inf, unit=unit, reason=reason)
    return Value.of_seeds(found, unit, reason)


@numbers("table_5_7", needs=NEEDS, evidence="rendered")
def numbers_of_table_5_7(results):
    """Translations and rotations after each step."""
    runs, found = MotionRuns(results), {}
    lengths, turns = (runs.steps(name) for name in ("length_mm", "turn_deg"))
    for k in EACH_STEP:
        prefix = f"t5_7_{k * STEP_MM:.0f}"
        found[f"{prefix}_gt"] = Value(k * STEP_MM, unit="mm", put_in=MOVED)
        found[f"{prefix}_t"] = of_runs(runs, lengths[k - 1], "mm")
        found[f"{prefix}_r"] = of_runs(runs, turns[k - 1], "deg")
    return found


@numbers("fig_5_20", needs=NEEDS, evidence="rendered")
def numbers_of_fig_5_20(results):
    """Error of the final position."""
    runs = MotionRuns(results)
    return {"s5_3_5_final": of_runs(runs, runs.steps("off_mm")[-1], "mm")}


@numbers("sec_5_3_5", needs=NEEDS, evidence="rendered")
def numbers_of_the_text(results):
    """The mean step before it is scaled."""
    runs = MotionRuns(results)
    return {"s5_3_5_unscaled": of_runs(runs, runs.of("mean_mm"), "mm")}


@numbers("fig_5_21", needs=NEEDS, evidence="rendered")
def numbers_of_fig_5_21(results):
    """The cylinder: radii, distances, markers that miss."""
    runs = MotionRuns(results)
    return {
        "s5_3_5_rad_un": of_runs(runs, runs.of("radius_mm"), "mm"),
        "s5_3_5_rad_sc": of_runs(runs, runs.of("scaled_mm"), "mm"),
        "s5_3_5_rad_true": Value(RADIUS_MM, unit="mm", put_in=MADE),
        "s5_3_5_fit_mean": of_runs(runs, runs.of("fit_mm"), "mm"),
        "s5_3_5_fit_sd": of_runs(runs, runs.of("fit_sd_mm"), "mm"),
        "s5_3_5_npts": Value(MARKS, unit="count", put_in=MADE),
        "s5_3_5_miss": of_runs(runs, runs.of("missed"), "count (of 25)"),
        "s5_3_5_marker": Value(MARKER_MM, unit="mm", put_in="radius of a marker"),
    }
