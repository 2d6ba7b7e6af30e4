"""Table 5.6 at all levels, and its numbers."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_4_distortion.results.predicates import (
    radius_errors,
)
from chapters.ch05_flexible_mirror.s3_4_distortion.results.runs import (
    SCALE,
    STAGES,
    CircleRuns,
)
from chapters.ch05_flexible_mirror.s3_4_distortion.trials.face import DEFLECTION_MM
from chapters.ch05_flexible_mirror.s3_4_distortion.trials.target import RADIUS_MM
from chapters.shared.mirror_bench import BENCHES, SAID
from chapters.shared.mirror_tables import MEDIANS, beside, reached
from repro.run.columns import columns
from repro.run.experiment import numbers, table
from repro.run.outcomes import Table, Value

DRAWN = "the target has this radius"
IN_MM = ("residual", "residual_sd", "radius")
PRINTED = {
    "Residual (mm)": "mean",
    "SD (mm)": "sd",
    "Radius (mm)": "radius",
    "Radius error (%)": "err",
}


@table("table_5_6", needs=("table_5_6_runs",), evidence="rendered")
def table_5_6(results):
    """Residuals and radii of the corrected circle at four stages."""
    rows = []
    for bench in BENCHES:
        runs = CircleRuns(results, bench=bench)
        off = np.abs(radius_errors(runs))
        rows += [
            (
                SAID[bench],
                stage,
                runs.came_to(stage),
                *(reached(runs.of(stage, f"{name}_mm")) for name in IN_MM),
                reached(off[stage]),
                reached(runs.of(stage, "angle_deg")),
                reached(runs.of(stage, "pose_mm")),
            )
            for stage in STAGES
        ]
    heads = ("Error level", "Stage", "Runs", *PRINTED, "Ray error (°)", "Pose (mm)")
    return Table(
        columns(heads, rows),
        "Residuals and radius of the circle of 87.21 mm after correction, with the "
        "board's pose estimated with the same camera. Right: what these do not show, "
        "the mean ray error over the mirror and the position error of the board's "
        f"middle. Geometry A. {MEDIANS}",
        printed={
            head: beside([f"t5_6_s{stage}_{end}" for stage in STAGES], len(rows))
            for head, end in PRINTED.items()
        },
    )


@numbers("table_5_6", needs=("table_5_6_runs",), evidence="rendered")
def numbers_of_table_5_6(results):
    """Residuals, radii and their errors at each stage."""
    runs = CircleRuns(results)
    measures = {
        "mean": (runs.at("residual_mm"), "mm"),
        "sd": (runs.at("residual_sd_mm"), "mm"),
        "radius": (runs.at("radius_mm"), "mm"),
        "err": (np.abs(radius_errors(runs)), "%"),
    }
    found = {"t5_6_true": Value(RADIUS_MM, unit="mm", put_in=DRAWN)}
    for stage in STAGES:
        for end, (values, unit) in measures.items():
            found[f"t5_6_s{stage}_{end}"] = value_of(values[stage], unit)
    return found


def value_of(trials, unit):
    """The Value of seeds (n,), and how many have none: in words if that is all."""
    lost = np.count_nonzero(~np.isfinite(trials))
    reason = f"{lost} of {len(trials)} runs were rejected before" if lost else ""
    if lost == len(trials):
        return Value("nothing", unit=unit, reason=reason)
    return Value.of_seeds(trials, unit, reason)


@numbers("fig_5_14", needs=(), evidence="analytic")
def numbers_of_fig_5_14(results):
    """Magnification of the residuals."""
    return {"fig5_14_scale": Value(SCALE, unit="x")}


@numbers("fig_5_19", needs=(), evidence="analytic")
def numbers_of_fig_5_19(results):
    """Deflection of the mirror for the face."""
    return {"fig5_19_defl": Value(DEFLECTION_MM, unit="mm")}
