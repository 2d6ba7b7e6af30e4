"""Results of this page read: values of the prose, figures, tables."""

import numpy as np

from chapters.ch05_flexible_mirror.s4_self_calibration.experiment import (
    ALONG_MM,
    DEPTHS_MM,
    SCENES,
)
from chapters.shared.mirror import (
    BENCHES,
    CONTRASTED,
    LABORATORY,
    LEVEL,
    LEVEL_NAMES,
    MEDIANS,
    STAGES_MM,
    BenchRuns,
    mirror_rig,
    reached,
)
from chapters.shared.mirror import with_published as with_published
from repro.page import INK, legend_below, new_figure, series, value
from repro.run import (
    Drawing,
    Table,
    Value,
    columns,
    figure,
    median_and_range,
    numbers,
    table,
)

# Runs of self-calibration: result, error level and features.


RUNS, SWEPT_RUNS = "table_5_9_runs", "table_5_9_swept"
STAGES = (1, 2, 3)
STAGE_NAMES = tuple(f"stage{stage}" for stage in STAGES)
STEP_MM = STAGES_MM[1]
# As 5.4 describes: features across the middle, and near ones at the free end.
THESIS_SCENE = next(iter(SCENES))
OBJECTS = ("plane", "object", "wall")


class Courses(BenchRuns):
    """Three pushes."""

    EXPERIMENTS = (RUNS, SWEPT_RUNS)

    def column(self, *path):
        """A value (..., runs) of each run, nan where it ended before."""
        return self.result.column(self.bench, *path)

    def of(self, way, name):
        """A value (stages, runs) of `board` or one of SCENES."""
        return self.column(way, STAGE_NAMES, name)

    def arrays(self, *path):
        """One array for each run that has it; none where nothing was run."""
        return self.result.arrays(self.bench, *path) if self.result.names() else []

    def of_run(self, run, came, *path):
        """Array of one run, where `came` (runs,) marks the runs that have it.

        One without rows where `run` is None.
        """
        if run is None:
            return np.empty((0, 2))
        return self.arrays(*path)[np.count_nonzero(came[:run])]


def first_run(*came):
    """Index of the first run for which all conditions hold; None without one."""
    every = np.flatnonzero(np.logical_and.reduce(came))
    return int(every[0]) if len(every) else None


# Numbers quoted on the page: medians over the runs that completed, as words.
#
# All runs of a stage may be rejected.


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
        error = 100 * runs.column("stereo", cameras, "deflected")
        value(f"{cameras}.deflected", median_words(error, digits))


# Profiles, stereo between bent states, the plan of a scene and its features.


NEEDS = ("table_5_9_runs",)
SD_TICKS = (1, 2, 3, 5, 10, 20, 30, 50)


def first_of(arrays, width=2):
    """The first array; one without rows where no run has one."""
    return arrays[0] if arrays else np.empty((0, width))


@figure("fig_5_24", needs=NEEDS, evidence="rendered")
def fig_5_24(results):
    """Profiles of the middle line, found and true, of a run at each of two levels."""
    drawn, panels = new_figure(1, 2, height_in=3.8, sharey=True)
    rig, rows = mirror_rig("A"), []
    for panel, level in zip(panels, CONTRASTED, strict=True):
        runs = Courses(results, bench=level)
        came = np.isfinite(runs.of(THESIS_SCENE, "angle_deg"))
        # A quick build has one push.
        pushed = [row for row in came if row.any()]
        seed = first_run(*pushed) if pushed else None
        for k, stage in enumerate(STAGES):
            true = rig.camera(STAGES_MM[stage]).mirror.height(ALONG_MM, 0 * ALONG_MM)[0]
            label = "true" if k == 0 else None
            panel.plot(ALONG_MM, true, color=INK, linestyle=":", marker="", label=label)
            look = series(k) | {"markevery": 4}
            # Where all runs were rejected the legend still names the stage.
            curve = np.full(len(ALONG_MM), np.nan)
            if seed is not None and came[k][seed]:
                path = THESIS_SCENE, STAGE_NAMES[k], "profile_mm"
                curve = runs.of_run(seed, came[k], *path)
                rows += [
                    (LEVEL_NAMES[level], stage, *row)
                    for row in zip(ALONG_MM, true, curve, strict=True)
                ]
            panel.plot(ALONG_MM, curve, label=f"stage {stage}", **look)
        panel.set(
            title=LEVEL_NAMES[level],
            xlabel="Distance from the clamp (mm)",
            ylim=(-4, 18),
        )
    panels[0].set_ylabel("Height above the flat sheet (mm)")
    legend_below(drawn, panels[0], ncols=4)
    return Drawing(
        drawn,
        columns(("level", "stage", "along_mm", "true_mm", "found_mm"), rows),
        "Middle line of the mirror after each push of 5 mm: true, and by linear "
        "self-calibration from features across the middle and near ones at the free "
        "end. The first run that reaches the last stage, at each of two levels.",
    )


@figure("fig_5_25", needs=NEEDS, evidence="rendered")
def fig_5_25(results):
    """A board by stereo between stages 0 and 1, and depth noise along the mirror."""
    runs = Courses(results)
    drawn, (left, right) = new_figure(1, 2, height_in=3.8)
    met = first_of(runs.arrays("stereo.found.met"), 3)
    # A run that was rejected has a board, and no reconstructed points.
    came = np.flatnonzero(np.isfinite(runs.column("stereo.found.board")))
    boards = runs.arrays("stereo.board_points")
    board = first_of([boards[k] for k in came], 3)
    for number, (name, points) in enumerate((("true", board), ("found", met))):
        look = series(number) | {"linestyle": "", "markersize": 3}
        left.plot(points[:, 0], points[:, 2], label=name, **look)
    left.set(xlabel="x (mm)", ylabel="z (mm)", title="board, seen from above")
    left.legend()
    along = np.mean(runs.arrays("stereo.along"), axis=0)
    sd = np.median(runs.arrays("stereo.sd_mm"), axis=0)
    right.plot(along, sd, **series(0))
    right.set_yscale("log")
    right.set_yticks(SD_TICKS, map(str, SD_TICKS), minor=False)
    right.set_yticks([], minor=True)
    right.set(xlabel="Distance from the clamp (fraction of the length)")
    right.set(ylabel="Depth SD (mm per px)", title="true mirror")
    rows = [("board", *p, *q) for p, q in zip(board, met, strict=True)]
    return Drawing(
        drawn,
        columns(("of", "x", "y", "z", "found_x", "found_y", "found_z"), rows),
        "Stereo between stages 0 and 1, both calibrated with boards. Left: corners of "
        "a board, true and reconstructed, one run at the second level. Right: standard "
        "deviation of depths at 260 mm with the true mirror, for noise of 1 px in both "
        "images. Next to the clamp depth is undetermined.",
    )


def run_of_scene(runs):
    """({mirror: which runs (seeds,) have the scene}, the first that has both)."""
    came = {
        mirror: np.isfinite(runs.column("multi", mirror, OBJECTS[0], "spread_mm"))
        for mirror in ("found", "true")
    }
    return came, first_run(*came.values())


@figure("fig_5_26", needs=NEEDS, evidence="rendered")
def fig_5_26(results):
    """Plan of the scene from four stages, calibrated and true mirror."""
    runs, rows = Courses(results), []
    came, seed = run_of_scene(runs)
    drawn, panels = new_figure(1, 2, height_in=4.2, sharex=True, sharey=True)
    for panel, cameras in zip(panels, ("found", "true"), strict=True):
        plan, of = (
            runs.of_run(seed, came[cameras], "multi", cameras, name)
            for name in ("plan", "of")
        )
        of = of.ravel() if seed is not None else np.empty(0)
        for k, one in enumerate(OBJECTS):
            look = series(k) | {"linestyle": "", "markersize": 4}
            panel.plot(*plan[of == k].T, label=one, **look)
            panel.axhline(DEPTHS_MM[one], color=look["color"], linewidth=0.8, marker="")
            rows += [(cameras, one, *p) for p in plan[of == k]]
        title = "calibrated mirror" if cameras == "found" else "true mirror"
        panel.set(
            title=title,
            xlabel="Lateral position (mm)",
            ylim=(0, 9000),
            xlim=(-1500, 1500),
        )
    panels[0].set_ylabel("Depth from the mirror (mm)")
    legend_below(drawn, panels[0], ncols=3)
    return Drawing(
        drawn,
        columns(("mirror", "of", "lateral_mm", "depth_mm"), rows),
        "Plan view of a scene triangulated from images at all four stages, with "
        "features picked to half a pixel. Lines: true depths. The first run of the "
        "second level that boards calibrate at all stages. Points outside the frame "
        "are not drawn.",
    )


@figure("fig_5_27", needs=NEEDS, evidence="rendered")
def fig_5_27(results):
    """Features that all four images show, in that of stage 2."""
    runs = Courses(results)
    came, seed = run_of_scene(runs)
    pixels = runs.of_run(seed, came["true"], "multi", "pixels")
    pixels = pixels[np.isfinite(pixels[:, 0])]
    drawn, panel = new_figure(height_in=3.6)
    panel.plot(*pixels.T, **series(0) | {"linestyle": "", "markersize": 4})
    panel.set(xlim=(0, 3072), ylim=(2304, 0), xlabel="u (px)", ylabel="v (px)")
    panel.set_aspect("equal")
    return Drawing(
        drawn,
        columns(("u_px", "v_px"), pixels),
        "Features of the scene in the image of stage 2, in the run of Fig. 5.26.",
    )


# Table 5.9 at all levels, other features, and the numbers of 5.4.


REACH = "Not every estimated shape reaches the load, and fewer have its sides."
FEATURES = {
    "clustered": "clustered, all far",
    "near": "even, near at the end",
    "even": "even, all far",
}
PUSHED = "the simulated mirror is pushed by this distance"
PLACED = "the simulated scene is at this depth"


HEADS = {
    "deflection_mm": "Self-calibration (mm)",
    "sag_mm": "Sag (mm)",
    "angle_deg": "Ray error (°)",
    "back_mm": "Back-projection (mm)",
    "back_true_mm": "Back-projection, true pose (mm)",
}
# Back-projection with an estimated pose is measured for some features only.
OF_FEATURES = [name for name in HEADS if name != "back_mm"]


def _rows(runs, way, level, names=tuple(HEADS)):
    of = {name: runs.of(way, name) for name in names}
    # Features as in 5.4 have a table of their own.
    features = () if way == THESIS_SCENE else (FEATURES[way],)
    return [
        (
            LEVEL_NAMES[level],
            *features,
            stage,
            int(np.isfinite(of["deflection_mm"][k]).sum()),
            STEP_MM,
            *(reached(of[name][k]) for name in names),
        )
        for k, stage in enumerate(STAGES)
    ]


def _heads(*features, names=tuple(HEADS)):
    first = ("Error level", *features, "Stage", "Runs", "Actual (mm)")
    return (*first, *(HEADS[name] for name in names))


@table("table_5_9", needs=NEEDS, evidence="rendered")
def table_5_9(results):
    """Deflections by linear self-calibration, features as in 5.4."""
    rows = [
        row
        for level in BENCHES
        for row in _rows(Courses(results, bench=level), THESIS_SCENE, level)
    ]
    return Table(
        columns(_heads(), rows),
        "Deflections from a distant scene by linear self-calibration, with features "
        "across the middle of the mirror and near ones at the free end. Sag at the "
        "load. Errors of rays and back-projection are not in the thesis. Rig A. "
        f"{MEDIANS} {REACH}",
        printed={
            title: with_published([f"t5_9_s{k}_{end}" for k in STAGES], len(rows))
            for title, end in (
                ("Actual (mm)", "actual"),
                ("Self-calibration (mm)", "est"),
            )
        },
    )


@table("ext_self_features", needs=NEEDS, evidence="rendered")
def ext_self_features(results):
    """Deflections with other distributions of features."""
    rows = [
        row
        for level in BENCHES
        for way in SCENES
        if way != THESIS_SCENE
        for row in _rows(Courses(results, bench=level), way, level, OF_FEATURES)
    ]
    return Table(
        columns(_heads("Features", names=OF_FEATURES), rows),
        "Deflections by linear self-calibration with other distributions of features: "
        f"over the whole mirror, and without near ones. {MEDIANS} {REACH}",
    )


def _value(runs, found, unit):
    lost = np.count_nonzero(~np.isfinite(found))
    reason = f"{lost} of {runs.seeds} runs have none: rejected, or load not reached"
    reason = reason if lost else ""
    if lost == runs.seeds:
        return Value(np.inf, unit=unit, reason=reason)
    return Value.of_seeds(found, unit, reason)


@numbers("table_5_9", needs=NEEDS, evidence="rendered")
def numbers_of_table_5_9(results):
    """Deflections found."""
    runs = Courses(results)
    found = runs.of(THESIS_SCENE, "deflection_mm")
    return {
        f"t5_9_s{k}_actual": Value(STEP_MM, unit="mm", put_in=PUSHED) for k in STAGES
    } | {f"t5_9_s{k}_est": _value(runs, found[k - 1], "mm") for k in STAGES}


@numbers("sec_5_4", needs=NEEDS, evidence="rendered")
def numbers_of_the_text(results):
    """Linear estimates of boards less the final ones, and the sag at the load."""
    runs = Courses(results)
    linear, final = (runs.of("board", name) for name in ("linear_mm", "deflection_mm"))
    below = 100 * (1 - linear / final)
    sag = np.abs(runs.of("clustered", "sag_mm"))[-1]
    return {
        "s5_4_lin_min": _value(runs, below.min(axis=0), "%"),
        "s5_4_lin_max": _value(runs, below.max(axis=0), "%"),
        "s5_4_vcurv": _value(runs, sag, "mm"),
    }


@numbers("fig_5_26", needs=NEEDS, evidence="rendered")
def numbers_of_fig_5_26(results):
    """Centroids and spreads of the four-stage reconstruction."""
    runs = Courses(results)

    def of(one, name):
        return _value(runs, runs.column("multi", "found", one, name), "mm")

    found = {f"fig5_26_{one}_est": of(one, "centroid_mm") for one in OBJECTS}
    found |= {
        f"fig5_26_{one}_meas": Value(DEPTHS_MM[one], unit="mm", put_in=PLACED)
        for one in OBJECTS
    }
    return found | {
        "fig5_26_front": of("plane", "spread_mm"),
        "fig5_26_rear": of("wall", "spread_mm"),
    }
