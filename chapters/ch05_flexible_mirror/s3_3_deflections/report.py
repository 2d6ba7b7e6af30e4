"""Results of this page read: values of the prose, figures, tables."""

from dataclasses import replace
from typing import ClassVar

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_deflections.experiment import COMPARED_PX
from chapters.shared.mirror import (
    BACK_PROJECTION_MM,
    DYNAMIC_MM,
    LEVEL_NAMES,
    STAGES_MM,
    BenchRuns,
    lengths,
    mirror_rig,
    ranged,
    reached,
)
from raxel.geometry import transform
from repro.page import INK, new_figure, series
from repro.page import value as name_value
from repro.run import (
    Check,
    Drawing,
    Table,
    Value,
    columns,
    figure,
    median_and_range,
    numbers,
    table,
)

# Distances of a rig, and the share of a deflection that the linear stage finds.


def camera_mm(geometry="A"):
    """Distance from the camera to the middle of the mirror at stage 0, mm."""
    camera = mirror_rig(geometry).camera(0.0)
    half = camera.mirror.end / 2
    height = camera.mirror.height(np.array([half]), np.zeros(1))[0][0]
    on_mirror = np.array([[half, 0.0, height]])
    return float(np.linalg.norm(transform(camera.T_viewer_mirror, on_mirror)[0]))


def by_formula(geometry="A"):
    """Z / (Z + D): linear over true deflection, as derived in 5.3.1."""
    return DYNAMIC_MM / (DYNAMIC_MM + camera_mm(geometry))


# The runs of three deflections: which result, which error level, which stage.


RUNS, SWEPT_RUNS = "table_5_1_runs", "table_5_1_swept"
OTHER, LONGER = "table_5_1_other", "table_5_1_longer"
NEEDS = ("table_5_1_runs",)
JUDGED = ("table_5_1_runs", "table_5_1_swept", "table_5_1_longer")
RENDERED = "table_5_1_rendered"
STAGES, DEFLECTED = (0, 1, 2, 3), (1, 2, 3)
STAGE_NAMES = tuple(f"stage{stage}" for stage in STAGES)
LAST = DEFLECTED[-1]
STEP_MM = STAGES_MM[1] - STAGES_MM[0]
# Of the translation stages that deflect the mirror.
RESOLUTION_MM = 0.01
SHIFT_MM = 100.0  # of the monitor, on its stage
# In Fig. 5.12, before calibration and after.
SCALES = (5, 30)


class Runs(BenchRuns):
    """Three deflections."""

    EXPERIMENTS = (RUNS, SWEPT_RUNS)
    ELSEWHERE: ClassVar = {"B": OTHER, "C": LONGER}
    SWINGS = STAGE_NAMES[1:]

    def of(self, stage, name):
        """A value (runs,) of one stage."""
        return self.at_place(STAGE_NAMES[stage], name)

    def at(self, name, stages=DEFLECTED):
        """A value (stages, runs) of several stages."""
        return np.array([self.of(stage, name) for stage in stages])

    def arrays(self, stage, name):
        """An array of one stage, of each run that has it."""
        return self.result.arrays(self.bench, STAGE_NAMES[stage], name)

    def calibrated(self, stage):
        """Which runs (runs,) have a camera of a stage, whatever its ends do."""
        return np.isfinite(
            self.result.column(self.bench, STAGE_NAMES[stage], "angle_deg")
        )

    def drawn(self, stage, name):
        """An array of one stage of the first completed run."""
        whole = np.isfinite(self.at("angle_deg", STAGES)).all(axis=0)
        return self.arrays(stage, name)[self.calibrated(stage)[: whole.argmax()].sum()]


MAX_ERROR = 10.0  # %, of a deflection


def largest_error(runs):
    """Largest error (runs,) of the three final deflections, %, without sign."""
    return np.abs(100 * (runs.at("deflection_mm") / STEP_MM - 1)).max(axis=0)


def name_values(open_results):
    """Name the numbers of the prose: medians over the completed runs."""
    runs = Runs({RUNS: open_results(RUNS)})
    most = largest_error(runs)
    within = most[np.isfinite(most)] <= MAX_ERROR
    name_value("share.deflections", 100 * within.mean() if len(within) else np.nan)
    for prefix, name, stages in (
        ("angle", "angle_deg", (0, LAST)),
        ("true", "back_true_mm", (1, LAST)),
    ):
        for stage in stages:
            found = median_and_range(runs.of(stage, name)).value
            name_value(f"{prefix}.{stage}", found)
    name_value("camera", camera_mm())


# Figs. 5.11 and 5.12: angles over the image, and vectors on the board.


EXACT = 1e-9


@figure("fig_5_11", needs=NEEDS, evidence="rendered")
def fig_5_11(results):
    """Angles to the true rays over the image, at stages 0 to 3 of one run."""
    runs = Runs(results)
    drawn, axes = new_figure(2, 2, height_in=4.8, sharex=True, sharey=True)
    pixels, off = (
        [runs.drawn(stage, name) for stage in STAGES] for name in ("pixels", "off_deg")
    )
    largest = max(map(np.nanmax, off))
    rows = []
    for stage, panel in enumerate(axes.flat):
        image = in_lattice(pixels[stage], off[stage])
        mesh = panel.pcolormesh(*image, cmap="viridis", vmin=0, vmax=largest)
        panel.set(
            title=f"({'abcd'[stage]}) stage {stage}", xlim=(0, 3072), ylim=(2304, 0)
        )
        panel.set_aspect("equal")
        rows += [(stage, *p, a) for p, a in zip(pixels[stage], off[stage], strict=True)]
    for panel in axes[:, 0]:
        panel.set_ylabel("Image v (px)")
    for panel in axes[1]:
        panel.set_xlabel("Image u (px)")
    drawn.colorbar(mesh, ax=axes, label="Angle to the true ray (deg)", shrink=0.8)
    means = ", ".join(f"{np.nanmean(one):.3f}" for one in off)
    return Drawing(
        drawn,
        columns(("stage", "u_px", "v_px", "angle_deg"), rows),
        "Angles between calibrated and true rays over the image, at each stage of "
        "deflection: the first completed run, rig A at the second solved level. The "
        f"clamped edge is at the right. Means of this run: {means}°.",
    )


def in_lattice(pixels, values):
    """Columns (n,) and rows (m,) of a lattice, values (m, n), nan off the mirror."""
    u, v = (np.unique(pixels[:, k]) for k in (0, 1))
    u, v = (np.arange(at[0], at[-1] + 1, COMPARED_PX) for at in (u, v))
    found = np.full((len(v), len(u)), np.nan)
    at = ((pixels - [u[0], v[0]]) / COMPARED_PX).round().astype(int)
    found[at[:, 1], at[:, 0]] = values
    return u, v, found


@figure("fig_5_12", needs=NEEDS, evidence="rendered")
def fig_5_12(results):
    """Back-projection errors of stage 3 on the board, before and after calibration."""
    runs = Runs(results)
    points = runs.drawn(LAST, "board_mm")
    drawn, axes = new_figure(1, 2, height_in=3.9, sharex=True, sharey=True)
    rows, gaps = [], []
    seed = np.flatnonzero(np.isfinite(runs.of(LAST, "angle_deg")))[0]
    for panel, letter, name, of, scale in zip(
        axes, "ab", ("stale", "own"), ("stale_mm", "back_mm"), SCALES, strict=True
    ):
        errors = runs.drawn(LAST, name)
        ends = points + scale * errors
        panel.plot(
            *np.stack([points, ends], axis=-1).transpose(1, 2, 0),
            color=series(0)["color"], lw=0.9, ls="-", marker="",
        )  # fmt: skip
        visible = np.isfinite(errors[:, 0])
        panel.plot(*points[visible].T, ls="", marker=".", color=INK, ms=2)
        mean = lengths(errors).mean()
        gaps.append(abs(mean - runs.of(LAST, of)[seed]))
        panel.set_title(f"({letter}) × {scale}, mean {mean:.2f} mm")
        panel.set_aspect("equal")
        panel.set_xlabel("Board x (mm)")
        rows += [(name, *p, *e) for p, e in zip(points, errors, strict=True)]
    axes[0].set_ylabel("Board y (mm)")
    return Drawing(
        drawn,
        columns(("calibration", "x_mm", "y_mm", "error_x_mm", "error_y_mm"), rows),
        "Back-projection errors on a board at 400 mm with the mirror at stage 3: (a) "
        "with the calibration of stage 2, vectors scaled by 5; (b) after dynamic "
        "calibration, vectors scaled by 30. Each calibration fits the board's pose. "
        "The run of Fig. 5.11.",
        Check(
            bool(max(gaps) < EXACT),
            f"the vectors have the means that are judged, to {max(gaps):.0e} mm",
        ),
    )


# Tables 5.1 to 5.4 at all error levels, their numbers, and those of the text.


SOLVED = (
    "the level was solved from this number: it is near the printed one by construction"
)
EXACTLY_SET = (
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


# Ids of printed numbers at stage 0 that do not follow those of their table.
IDS_AT_STAGE_0 = {
    "t5_2_s0_t": "s5_3_3_ag_t",
    "t5_2_s0_r": "s5_3_3_ag_r",
    "t5_4_s0_res_mean": None,
    "t5_4_s0_res_sd": None,
}


def level_table(results, prefix, heads, stages, caption):
    """Table of measures at each error level and stage, printed numbers at the primary.

    heads: {title: (measure, end of the printed ids or None)}; a measure is the name of
    a value or a function (runs, stage) -> (runs,). The ids are as t5_1_s1_linear.
    """
    rows, printed = [], {}
    for level, words in LEVEL_NAMES.items():
        runs = Runs(results, None, level)
        for stage in stages:
            found = (
                measure(runs, stage) if callable(measure) else runs.of(stage, measure)
                for measure, _ in heads.values()
            )
            completed = int(np.isfinite(runs.of(stage, "angle_deg")).sum())
            rows.append((words, stage, completed, *map(reached, found)))
    for title, (_, end) in heads.items():
        if end:
            ids = [f"{prefix}_s{stage}_{end}" for stage in stages]
            ids = [IDS_AT_STAGE_0.get(one, one) for one in ids]
            printed[title] = ids + [None] * (len(rows) - len(ids))
    data = columns(("Error level", "Stage", "Runs", *heads), rows)
    return Table(data, caption, printed=printed)


@table("table_5_1", needs=NEEDS, evidence="rendered")
def table_5_1(results):
    """Actual, linear and final deflections of the three stages."""
    heads = {
        "Actual (mm)": (lambda runs, stage: np.array([STEP_MM]), "actual"),
        "Linear (mm)": ("linear_mm", "linear"),
        "Final (mm)": ("deflection_mm", "final"),
        "Error since stage 0 (mm)": (error_since_start, None),
    }
    caption = (
        "Deflection of the mirror at the load at each stage: actual, linear estimate "
        "and final estimate, and error of the sum of the final estimates. "
        f"Rig A. {MEDIANS}"
    )
    return level_table(results, "t5_1", heads, DEFLECTED, caption)


def error_since_start(runs, stage):
    """Error of the sum of deflections up to a stage, mm (runs,)."""
    found = runs.at("deflection_mm", DEFLECTED[:stage])
    return found.sum(axis=0) - stage * STEP_MM


@table("table_5_2", needs=NEEDS, evidence="rendered")
def table_5_2(results):
    """Travel of the monitor, from its reflections in the platter."""
    heads = {"Translation (mm)": ("shift_mm", "t"), "Rotation (°)": ("turn_deg", "r")}
    caption = (
        "Translation and rotation of the monitor between its two positions, estimated "
        f"from its reflection in the platter. {MEDIANS} The true travel is "
        f"{SHIFT_MM:g} mm, with vibrations of 0.1 mm and 0.05° along each axis."
    )
    return level_table(results, "t5_2", heads, STAGES, caption)


@table("table_5_3", needs=NEEDS, evidence="rendered")
def table_5_3(results):
    """Angles from calibrated rays to measured ones, and to the true ones."""
    heads = {
        "Largest displacement (°)": ("moved_deg", "disp"),
        "Mean to measured rays (°)": ("measured_deg", "mean"),
        "SD (°)": ("measured_sd_deg", "sd"),
        "Mean to true rays (°)": ("angle_deg", None),
        "SD to true rays (°)": ("angle_sd_deg", None),
    }
    caption = (
        "Largest rotation of a ray since stage 0, and angles from the calibrated rays "
        "to those measured with an active grid in two positions, as in the thesis. The "
        f"right columns have the angles to the true rays. Rig A. {MEDIANS}"
    )
    return level_table(results, "t5_3", heads, STAGES, caption)


@table("table_5_4", needs=NEEDS, evidence="rendered")
def table_5_4(results):
    """Back-projection errors and residuals, and the errors that they do not show."""
    heads = {
        "Back-projection (mm)": ("back_mm", "bp_mean"),
        "SD (mm)": ("back_sd_mm", "bp_sd"),
        "Residual (mm)": ("residual_mm", "res_mean"),
        "SD of residual (mm)": ("residual_sd_mm", "res_sd"),
        "Back-projection, true pose (mm)": ("back_true_mm", None),
        "Mean to true rays (°)": ("angle_deg", None),
    }
    caption = (
        "Back-projection errors on a board at 400 mm in the pose fitted by the "
        "calibrated camera, and residuals of the refinement. The right columns have "
        "what these hide: the back-projection error in the board's true pose, and the "
        f"angle to the true rays. Rig A. {MEDIANS} The second solved level is solved "
        "from the back-projection error of stage 0, the first from the residual of "
        "stage 1."
    )
    return level_table(results, "t5_4", heads, STAGES, caption)


@table(
    "ext_mirror_rendered_table",
    needs=("table_5_1_rendered", "table_5_1_runs", "table_5_1_other"),
    evidence="rendered",
)
def rendered_table(results):
    """Runs from images compared with those with redrawn errors, stage by stage."""
    result, rows = results[RENDERED], []
    for geometry, level in dict.fromkeys(
        (c["geometry"], c["bench"]) for c in result.conditions
    ):
        trials = result.select(geometry=geometry, bench=level)
        redrawn = Runs(results, None, level, geometry)
        for way, words in RENDERED_WAYS.items():
            for stage in DEFLECTED:
                cells = []
                for name in RENDERED_MEASURES.values():
                    found = trials.column(way, STAGE_NAMES[stage], name)
                    many = reached(redrawn.of(stage, name))
                    cells += [ranged(found), many if way == "published" else None]
                rows.append((geometry, LEVEL_NAMES[level], words, stage, *cells))
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


def of_runs(runs, found, unit, put_in=""):
    """The Value of a measure (runs,), with the number of rejected runs."""
    lost = np.count_nonzero(~np.isfinite(found))
    reason = f"{lost} of {runs.seeds} runs were rejected before" if lost else ""
    return Value.of_seeds(found, unit, reason, put_in)


def by_stage(runs, prefix, measures, stages):
    """{id: Value} of measures {end of the id: name of the value}, by their units."""
    return {
        f"{prefix}_s{stage}_{end}": of_runs(
            runs, runs.of(stage, name), name.rsplit("_", 1)[1]
        )
        for stage in stages
        for end, name in measures.items()
    }


@numbers("table_5_1", needs=NEEDS, evidence="rendered")
def numbers_of_table_5_1(results):
    """Estimated deflections, and the largest error of the three."""
    runs = Runs(results)
    measures = {"linear": "linear_mm", "final": "deflection_mm"}
    return {
        **by_stage(runs, "t5_1", measures, DEFLECTED),
        **{f"t5_1_s{stage}_actual": Value(STEP_MM, unit="mm") for stage in DEFLECTED},
        "s5_3_3_maxdef": of_runs(runs, largest_error(runs), "%"),
    }


@numbers("table_5_2", needs=NEEDS, evidence="rendered")
def numbers_of_table_5_2(results):
    """Estimated translation and rotation of the monitor."""
    measures = {"t": "shift_mm", "r": "turn_deg"}
    return by_stage(Runs(results), "t5_2", measures, DEFLECTED)


@numbers("table_5_3", needs=NEEDS, evidence="rendered")
def numbers_of_table_5_3(results):
    """Angles between measured and calibrated rays."""
    measures = {"disp": "moved_deg", "mean": "measured_deg", "sd": "measured_sd_deg"}
    runs = Runs(results)
    found = by_stage(runs, "t5_3", measures, STAGES)
    found["t5_3_s0_mean"] = replace(found["t5_3_s0_mean"], put_in=SOLVED)
    return found | {"t5_3_points": Value(pixels_compared(runs), unit="count")}


def pixels_compared(runs):
    """Pixels whose rays are compared at stage 0."""
    return len(runs.drawn(0, "off_deg"))


@numbers("table_5_4", needs=NEEDS, evidence="rendered")
def numbers_of_table_5_4(results):
    """Back-projection errors in the fitted pose, and residuals."""
    runs = Runs(results)
    back = {"bp_mean": "back_mm", "bp_sd": "back_sd_mm"}
    left = {"res_mean": "residual_mm", "res_sd": "residual_sd_mm"}
    found = by_stage(runs, "t5_4", back, STAGES)
    found["t5_4_s0_bp_mean"] = replace(found["t5_4_s0_bp_mean"], put_in=SOLVED)
    board = mirror_rig("A").board
    visible, common = runs.at("corners", STAGES), runs.at("common")
    return {
        **found,
        **by_stage(runs, "t5_4", left, DEFLECTED),
        # From edge to edge of its squares.
        "t5_4_gw": Value((board.rows + 1) * board.pitch_mm, unit="mm"),
        "t5_4_gh": Value((board.columns + 1) * board.pitch_mm, unit="mm"),
        "t5_4_bpmin": Value(np.nanmin(visible), unit="count"),
        "t5_4_bpmax": Value(np.nanmax(visible), unit="count"),
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
        "s5_3_3_stage_res": Value(RESOLUTION_MM, unit="mm", put_in=EXACTLY_SET),
        "s5_3_3_mp": Value(viewer.width * viewer.height / 1e6, unit="Mpixel"),
    }
