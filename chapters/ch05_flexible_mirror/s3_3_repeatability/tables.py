"""Table 5.5 with its numbers and those of Fig. 5.13, and the sensitivity table."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_repeatability.results import predicates
from chapters.ch05_flexible_mirror.s3_3_repeatability.results.runs import (
    BACK,
    JUDGED,
    SCALE,
    STEP_MM,
    STEPS,
    WHOLE_MM,
    LoopRuns,
)
from chapters.ch05_flexible_mirror.s3_3_repeatability.trials.run import LOOP
from chapters.shared.mirror_bench import BENCHES, SAID, SWEPT
from repro.judge.statistics import median_and_range
from repro.run.columns import columns
from repro.run.experiment import numbers, table
from repro.run.outcomes import Measured, Table, Value

SET = "the steps of the rig are these: put in, not found"
# Names of states of the loop in the registry's ids -> names in the results.
PLACES = {"stage0_primary": "start", "stage3": "step3", "stage0_after6": "step6"}
COLUMNS = {
    "linear": "linear_mm",
    "final": "deflection_mm",
    "res_mean": "residual_mm",
    "res_sd": "residual_sd_mm",
}


def _median(found, unit):
    """Median of the runs that have a value, with the number of others, as a Value."""
    known = found[np.isfinite(found)]
    lost = len(found) - len(known)
    reason = f"{lost} of {len(found)} runs were rejected before" if lost else ""
    return Value.median(known if len(known) else found, unit, reason)


def middle(found):
    """Median of the runs that have a value, nan without any."""
    return median_and_range(found).value


def _percent_more(after, before):
    """Increase of the medians over completed runs, %, as a Value."""
    done = np.isfinite(after + before)
    if not done.any():
        return Value(np.nan, unit="%")
    found = predicates.loop_ratio(after[done], before[done])
    value, low, high = (100 * (number - 1) for number in found[:3])
    return Value(value, (low, high), "%")


@numbers("table_5_5", needs=("table_5_5_runs",), evidence="rendered")
def numbers_table_5_5(results):
    """Cells of the table, and the text's numbers: medians over runs."""
    runs = LoopRuns(results)
    cells = {
        f"t5_5_step{step}_{column}": _median(runs.of(f"step{step}", name), "mm")
        for step in STEPS
        for column, name in COLUMNS.items()
    }
    actual = {
        f"t5_5_step{step}_actual": Value(STEP_MM, unit="mm", put_in=SET)
        for step in STEPS
    }
    loop = predicates.loop_error(runs)
    staged = runs.at("deflection_mm", BACK).sum(axis=0)
    single = {
        f"s5_rep_single_{name}": _median(runs.of("single", column), "mm")
        for name, column in {
            "lin": "linear_mm",
            "fin": "deflection_mm",
            "res_mean": "residual_mm",
            "res_sd": "residual_sd_mm",
        }.items()
    }
    difference = predicates.single_difference(runs)
    return (
        actual
        | cells
        | single
        | {
            "s5_rep_agree": _median(predicates.disagreement(runs), "%"),
            "s5_rep_hyst_mm": _median(loop, "mm"),
            "s5_rep_hyst_pct": _median(100 * loop / WHOLE_MM, "%"),
            "s5_rep_staged": _median(staged, "mm"),
            "s5_rep_single_pct": _median(difference, "%"),
        }
    )


@numbers("fig_5_13", needs=("table_5_5_runs",), evidence="rendered")
def numbers_fig_5_13(results):
    """Back-projection errors in the fitted pose: medians over runs."""
    runs = LoopRuns(results)
    found = {
        f"s5_rep_bp_{name}_{statistic}": _median(runs.of(place, column), "mm")
        for name, place in PLACES.items()
        for statistic, column in (("mean", "back_mm"), ("sd", "back_sd_mm"))
    }
    ends = runs.at("back_mm", (STEPS[-1], STEPS[0]))
    return found | {
        "s5_rep_single_bp_mean": _median(runs.of("single", "back_mm"), "mm"),
        "s5_rep_single_bp_sd": _median(runs.of("single", "back_sd_mm"), "mm"),
        "s5_rep_bp_increase": _percent_more(*ends),
        "fig5_13_scale": Value(SCALE, unit="x"),
    }


@table("table_5_5", needs=("table_5_5_runs",), evidence="rendered")
def table_5_5(results):
    """Steps by stage: deflections, residuals, and errors against the truth."""
    runs = LoopRuns(results)
    off = predicates.height_errors(runs)
    rows = []
    for step in STEPS:
        place = f"step{step}"
        rows.append(
            (
                LOOP[step],
                STEP_MM,
                *(_cell(runs.of(place, name)) for name in COLUMNS.values()),
                _cell(np.abs(off[step - 1])),
                *(_cell(runs.of(place, n)) for n in ("angle_deg", "back_true_mm")),
            )
        )
    names = (
        "Stage",
        "Actual (mm)",
        "Linear estimate (mm)",
        "Final estimate (mm)",
        "Residual, mean (mm)",
        "Residual, SD (mm)",
        "Error of the height at the load (mm)",
        "Angle to true rays (°)",
        "Back-projection, true pose (mm)",
    )
    printed = dict(zip(names[1:6], ("actual", *COLUMNS), strict=True))
    return Table(
        columns(names, rows),
        "Deflections and errors of three steps of 5 mm out and three back, second "
        f"solved level: medians over the {runs.completed.sum()} of {runs.seeds} "
        "completed runs, with 95 % intervals. The three columns on the right require "
        "the truth, which the thesis did not have: absolute error of the height, as "
        "the sum of all steps; mean angle of the rays to the true ones; and "
        "back-projection error on a board at 400 mm in its true pose.",
        printed={
            name: [f"t5_5_step{step}_{column}" for step in STEPS]
            for name, column in printed.items()
        },
    )


def judged_by(runs):
    """Quantities that the claims test, of completed runs, and the number of these."""
    done = runs.completed
    start, third, end = (runs.of(p, "back_mm")[done] for p in PLACES.values())
    own = [
        middle(measure(runs))
        for measure in (
            predicates.disagreement,
            predicates.loop_error,
            predicates.single_difference,
        )
    ]
    if not done.any():
        return (*own, None, None, None, None, 0)
    return (
        *own,
        predicates.loop_ratio(runs.of("single", "back_mm")[done], end).value,
        predicates.error_growth(runs, "back_mm", done).value,
        predicates.loop_ratio(end, start).value,
        predicates.loop_ratio(end, third).value,
        int(done.sum()),
    )


@table("ext_table_5_5_sweep", needs=JUDGED, evidence="rendered")
def sweep_table(results):
    """Quantities that the claims test, at all levels and over the sweep."""
    rows = []
    for bench in (*BENCHES, *SWEPT):
        runs = LoopRuns(results, bench=bench)
        rows.append((SAID.get(bench, bench), *judged_by(runs), runs.seeds))
    return Table(
        columns(
            (
                "Error level",
                "Difference of equivalent steps (%)",
                "Loop error (mm)",
                "Single step against three (%)",
                "Back-projection, single over staged",
                "Growth per step (%)",
                "After six steps over before",
                "After six steps over after three",
                "Completed",
                "Runs",
            ),
            rows,
        ),
        "Quantities that the claims test, on rig A, at the error levels and at the "
        "ends of the sweep: medians, and ratios of medians, of the completed runs. A "
        "claim whose estimate changes side between half and twice the second level's "
        "numbers is undecided.",
    )


def _cell(found):
    """Median of the runs that have a value, with its interval; None without any."""
    known = found[np.isfinite(found)]
    return Measured.median_or_none(known) if len(known) else None
