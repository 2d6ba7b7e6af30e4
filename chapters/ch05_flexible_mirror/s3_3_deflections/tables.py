"""Tables 5.1 to 5.4 at all error levels, their numbers, and those of the text."""

from dataclasses import replace

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_deflections.results.predicates import (
    BY_SEED,
    deflection_errors,
)
from chapters.ch05_flexible_mirror.s3_3_deflections.results.runs import (
    DEFLECTED,
    JUDGED,
    RENDERED,
    RESOLUTION_MM,
    SCALES,
    SHIFT_MM,
    STAGES,
    STEP_MM,
    Runs,
)
from chapters.shared.mirror_bench import BENCHES, SAID, SWEPT
from chapters.shared.mirror_rigs import BACK_PROJECTION_MM, DYNAMIC_MM, mirror_rig
from chapters.shared.mirror_tables import beside, ranged, reached
from repro.run.columns import columns
from repro.run.experiment import numbers, table
from repro.run.outcomes import Table, Value

NEEDS = ("table_5_1_runs",)
SOLVED = (
    "the level was solved from this number: it is near the printed one by construction"
)
EXACT = (
    "deflections are put into the rig exactly; all are multiples of what the thesis's "
    "stages resolve"
)
MEDIANS = (
    "Medians over the runs completed up to that stage, with 95 % intervals; the column "
    "Runs has their number."
)


RENDERED_WAYS = {"published": "as published", "own": "raxel calibrate"}
RENDERED_MEASURES = {
    "Deflection (mm)": "deflection_mm",
    "Mean to true rays (°)": "angle_deg",
    "Residual (mm)": "residual_mm",
    "Back-projection (mm)": "back_mm",
    "Back-projection, true pose (mm)": "back_true_mm",
}


def stages_of(runs, measures, stages):
    """Rows of a table: stage, number of runs, and a cell for each measure.

    measures: names of trials, or functions (runs, stage) -> (seeds,).
    """

    def cell(measure, stage):
        if callable(measure):
            return reached(measure(runs, stage))
        return reached(runs.of(stage, measure))

    return [
        (
            stage,
            int(np.isfinite(runs.of(stage, "angle_deg")).sum()),
            *(cell(measure, stage) for measure in measures),
        )
        for stage in stages
    ]


def on_all(results, heads, stages, geometry="A"):
    """Columns of a table: those of `heads` {title: measure} at each error level."""
    rows = [
        (SAID[name], *row)
        for name in BENCHES
        for row in stages_of(
            Runs(results, bench=name, geometry=geometry), heads.values(), stages
        )
    ]
    return columns(("Error level", "Stage", "Runs", *heads), rows)


def printed(stages, prefix, end):
    """Ids for each row of `on_all`: those of the primary level, None elsewhere.

    prefix, end: of the ids, as in t5_1_s1_linear.
    """
    ids = [f"{prefix}_s{stage}_{end}" for stage in stages]
    return beside(ids, len(stages) * len(BENCHES))


@table("table_5_1", needs=NEEDS, evidence="rendered")
def table_5_1(results):
    """Actual, linear and final deflections of the three stages."""
    heads = {
        "Actual (mm)": lambda runs, stage: np.array([STEP_MM]),
        "Linear (mm)": "linear_mm",
        "Final (mm)": "deflection_mm",
        "Error since stage 0 (mm)": error_since_start,
    }
    return Table(
        on_all(results, heads, DEFLECTED),
        "Deflection of the mirror at the load at each stage: actual, linear estimate "
        "and final estimate, and error of the sum of the final estimates. "
        f"Rig A. {MEDIANS}",
        printed={
            title: printed(DEFLECTED, prefix="t5_1", end=end)
            for title, end in zip(heads, ("actual", "linear", "final"), strict=False)
        },
    )


def error_since_start(runs, stage):
    """Error of the sum of deflections up to a stage, mm (seeds,)."""
    found = runs.at("deflection_mm", DEFLECTED[:stage])
    return found.sum(axis=0) - stage * STEP_MM


@table("table_5_2", needs=NEEDS, evidence="rendered")
def table_5_2(results):
    """Travel of the monitor, from its reflections in the platter."""
    heads = {"Translation (mm)": "shift_mm", "Rotation (°)": "turn_deg"}
    return Table(
        on_all(results, heads, STAGES),
        "Translation and rotation of the monitor between its two positions, estimated "
        f"from its reflection in the platter. {MEDIANS} The true travel is "
        f"{SHIFT_MM:g} mm, with vibrations of 0.1 mm and 0.05° along each axis.",
        printed={
            "Translation (mm)": ids_with_stage_0("t"),
            "Rotation (°)": ids_with_stage_0("r"),
        },
    )


def ids_with_stage_0(end):
    """Ids of Table 5.2, with stage 0 from the text."""
    of_table = [f"t5_2_s{stage}_{end}" for stage in DEFLECTED]
    return beside([f"s5_3_3_ag_{end}", *of_table], len(STAGES) * len(BENCHES))


@table("table_5_3", needs=NEEDS, evidence="rendered")
def table_5_3(results):
    """Angles from calibrated rays to measured ones, and to the true ones."""
    heads = {
        "Largest displacement (°)": "moved_deg",
        "Mean to measured rays (°)": "measured_deg",
        "SD (°)": "measured_sd_deg",
        "Mean to true rays (°)": "angle_deg",
        "SD to true rays (°)": "angle_sd_deg",
    }
    return Table(
        on_all(results, heads, STAGES),
        "Largest rotation of a ray since stage 0, and angles from the calibrated rays "
        "to those measured with an active grid in two positions, as in the thesis. The "
        f"right columns have the angles to the true rays. Rig A. {MEDIANS}",
        printed={
            title: printed(STAGES, prefix="t5_3", end=end)
            for title, end in zip(heads, ("disp", "mean", "sd"), strict=False)
        },
    )


@table("table_5_4", needs=NEEDS, evidence="rendered")
def table_5_4(results):
    """Back-projection errors and residuals, and the errors that they do not show."""
    heads = {
        "Back-projection (mm)": "back_mm",
        "SD (mm)": "back_sd_mm",
        "Residual (mm)": "residual_mm",
        "SD of residual (mm)": "residual_sd_mm",
        "Back-projection, true pose (mm)": "back_true_mm",
        "Mean to true rays (°)": "angle_deg",
    }
    ends = ("bp_mean", "bp_sd", "res_mean", "res_sd")
    ids = {
        title: printed(STAGES, prefix="t5_4", end=end)
        for title, end in zip(heads, ends, strict=False)
    }
    for title in ("Residual (mm)", "SD of residual (mm)"):
        ids[title][0] = None
    return Table(
        on_all(results, heads, STAGES),
        "Back-projection errors on a board at 400 mm in the pose fitted by the "
        "calibrated camera, and residuals of the refinement. The right columns have "
        "what these hide: the back-projection error in the board's true pose, and the "
        f"angle to the true rays. Rig A. {MEDIANS} The second solved level is solved "
        "from the back-projection error of stage 0, the first from the residual of "
        "stage 1.",
        printed=ids,
    )


@table(
    "ext_mirror_rendered_table",
    needs=("table_5_1_rendered", "table_5_1_runs", "table_5_1_other"),
    evidence="rendered",
)
def rendered_table(results):
    """Runs from images compared with those with redrawn errors, stage by stage."""
    result, rows = results[RENDERED], []
    places = dict.fromkeys((c["geometry"], c["bench"]) for c in result.conditions)
    for geometry, bench in places:
        trials = result.select(geometry=geometry, bench=bench)
        redrawn = Runs(results, bench=bench, geometry=geometry)
        for way, words in RENDERED_WAYS.items():
            for stage in DEFLECTED:
                cells = []
                for name in RENDERED_MEASURES.values():
                    cells.append(ranged(trials.column(f"{way}.stage{stage}.{name}")))
                    many = reached(redrawn.of(stage, name))
                    cells.append(many if way == "published" else None)
                rows.append((geometry, SAID[bench], words, stage, *cells))
    heads = [head for name in RENDERED_MEASURES for head in (name, f"{name}, redrawn")]
    return Table(
        columns(("Rig", "Error level", "Method", "Stage", *heads), rows),
        "Measures of runs from rendered images (median and range), next to the same "
        "measures with redrawn errors (medians over many runs with 95 % intervals). "
        "*As published*: distances along viewing rays, fixed clamp position. "
        "*raxel calibrate*: as many knots as the corners support, all stages at once. "
        "Rays are compared where the spline is defined; if it does not reach the load, "
        "there is no deflection. Back-projection is onto a board at 400 mm, whose "
        "corners are exact in the runs from images.",
    )


@table("ext_deflections_swept", needs=JUDGED, evidence="rendered")
def ext_deflections_swept(results):
    """Shares of the runs in which claims are true, at each error level."""
    benches = [*BENCHES, *SWEPT]
    rows = [
        (
            SAID.get(bench, bench),
            *(
                _share(*predicate(Runs(results, bench=bench))[:2])
                for predicate in BY_SEED.values()
            ),
        )
        for bench in benches
    ]
    claims = (claim.removeprefix("c5_") for claim in BY_SEED)
    return Table(
        columns(("Error level", *(f"{claim} (%)" for claim in claims)), rows),
        "Share of the completed runs in which each claim is true: at the three error "
        "levels, and with one or both of the second level's numbers halved or doubled. "
        "A claim whose share crosses 90 % at one of these ends is undecided.",
    )


def _share(holds, found):
    """Share of the completed runs in which a claim is true, %; None without any."""
    done = ~np.isnan(found)
    return 100 * float(np.mean(holds[done])) if done.any() else None


def of_runs(runs, found, unit, put_in=""):
    """The Value of a measure (seeds,) of `Runs`, with the number of rejected runs."""
    lost = np.count_nonzero(~np.isfinite(found))
    reason = f"{lost} of {runs.seeds} runs were rejected before" if lost else ""
    return Value.of_seeds(found, unit, reason, put_in)


def _by_stage(runs, measures, stages):
    """{id: Value} of measures {end of the id: (name of the trials, unit)}."""
    return {
        f"s{stage}_{end}": of_runs(runs, runs.of(stage, name), unit)
        for stage in stages
        for end, (name, unit) in measures.items()
    }


def _with(prefix, values):
    return {f"{prefix}{name}": value for name, value in values.items()}


@numbers("table_5_1", needs=NEEDS, evidence="rendered")
def numbers_of_table_5_1(results):
    """Estimated deflections, and the largest error of the three."""
    runs = Runs(results)
    measures = {"linear": ("linear_mm", "mm"), "final": ("deflection_mm", "mm")}
    most = np.abs(deflection_errors(runs)).max(axis=0)
    return {
        **_with("t5_1_", _by_stage(runs, measures, DEFLECTED)),
        **{f"t5_1_s{stage}_actual": Value(STEP_MM, unit="mm") for stage in DEFLECTED},
        "s5_3_3_maxdef": of_runs(runs, most, "%"),
    }


@numbers("table_5_2", needs=NEEDS, evidence="rendered")
def numbers_of_table_5_2(results):
    """Estimated translation and rotation of the monitor."""
    measures = {"t": ("shift_mm", "mm"), "r": ("turn_deg", "deg")}
    return _with("t5_2_", _by_stage(Runs(results), measures, DEFLECTED))


@numbers("table_5_3", needs=NEEDS, evidence="rendered")
def numbers_of_table_5_3(results):
    """Angles between measured and calibrated rays."""
    measures = {
        "disp": ("moved_deg", "deg"),
        "mean": ("measured_deg", "deg"),
        "sd": ("measured_sd_deg", "deg"),
    }
    runs = Runs(results)
    found = _by_stage(runs, measures, STAGES)
    found["s0_mean"] = replace(found["s0_mean"], put_in=SOLVED)
    return _with("t5_3_", found) | {
        "t5_3_points": Value(pixels_compared(runs), unit="count")
    }


def pixels_compared(runs):
    """Pixels whose rays are compared at stage 0."""
    return len(runs.drawn(0, "off_deg"))


@numbers("table_5_4", needs=NEEDS, evidence="rendered")
def numbers_of_table_5_4(results):
    """Back-projection errors in the fitted pose, and residuals."""
    runs = Runs(results)
    back = {"bp_mean": ("back_mm", "mm"), "bp_sd": ("back_sd_mm", "mm")}
    left = {"res_mean": ("residual_mm", "mm"), "res_sd": ("residual_sd_mm", "mm")}
    found = _by_stage(runs, back, STAGES) | _by_stage(runs, left, DEFLECTED)
    found["s0_bp_mean"] = replace(found["s0_bp_mean"], put_in=SOLVED)
    board = mirror_rig("A").board
    seen, common = runs.at("corners", STAGES), runs.at("common")
    # From edge to edge of its squares.
    return _with("t5_4_", found) | {
        "t5_4_gw": Value((board.rows + 1) * board.pitch_mm, unit="mm"),
        "t5_4_gh": Value((board.columns + 1) * board.pitch_mm, unit="mm"),
        "t5_4_bpmin": Value(np.nanmin(seen), unit="count"),
        "t5_4_bpmax": Value(np.nanmax(seen), unit="count"),
        "t5_4_resmin": Value(np.nanmin(common), unit="count"),
        "t5_4_resmax": Value(np.nanmax(common), unit="count"),
        "t5_4_depth": Value(BACK_PROJECTION_MM, unit="mm"),
    }


@numbers("fig_5_12", needs=NEEDS, evidence="rendered")
def numbers_of_fig_5_12(results):
    """Scales of the drawn vectors."""
    before, after = SCALES
    return {"t5_4_sc_a": Value(before, unit="x"), "t5_4_sc_b": Value(after, unit="x")}


@numbers("sec_5_3_3", needs=NEEDS, evidence="rendered")
def numbers_of_the_text(results):
    """Numbers of the primary stage in the text."""
    runs = Runs(results)
    viewer = mirror_rig("A").viewer
    return {
        "s5_3_3_pos_n": Value(np.nanmedian(runs.raw("points")), unit="count"),
        "s5_3_3_pos_mean": of_runs(runs, runs.raw("miss_mm"), "mm"),
        "s5_3_3_pos_sd": of_runs(runs, runs.raw("miss_sd_mm"), "mm"),
        "s5_3_3_ag_t": of_runs(runs, runs.of(0, "shift_mm"), "mm"),
        "s5_3_3_ag_r": of_runs(runs, runs.of(0, "turn_deg"), "deg"),
        "s5_3_3_ag_nom": Value(SHIFT_MM, unit="mm"),
        "s5_3_3_pix": Value(pixels_compared(runs), unit="count"),
        "s5_3_3_ang_mean": of_runs(runs, runs.of(0, "measured_deg"), "deg", SOLVED),
        "s5_3_3_ang_sd": of_runs(runs, runs.of(0, "measured_sd_deg"), "deg"),
        "s5_3_3_depth": Value(DYNAMIC_MM, unit="mm"),
        "s5_3_3_step": Value(STEP_MM, unit="mm"),
        "s5_3_3_stage_res": Value(RESOLUTION_MM, unit="mm", put_in=EXACT),
        "s5_3_3_mp": Value(viewer.width * viewer.height / 1e6, unit="Mpixel"),
    }
