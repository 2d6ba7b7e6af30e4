"""Profiles, stereo between bent states, the plan of a scene and its features."""

import numpy as np

from chapters.ch05_flexible_mirror.s4_self_calibration.results.runs import (
    OBJECTS,
    STAGES,
    THESIS_SCENE,
    Courses,
    first_seed,
)
from chapters.ch05_flexible_mirror.s4_self_calibration.trials.course import ALONG_MM
from chapters.ch05_flexible_mirror.s4_self_calibration.trials.scene import DEPTHS_MM
from chapters.shared.mirror_bench import CONTRASTED, SAID
from chapters.shared.mirror_rigs import STAGES_MM, mirror_rig
from repro.page.style import INK, legend_below, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

NEEDS = ("table_5_9_runs",)
SD_TICKS = (1, 2, 3, 5, 10, 20, 30, 50)


def first_of(arrays, columns=2):
    """The first array; one without rows where no run has one."""
    return arrays[0] if arrays else np.empty((0, columns))


@figure("fig_5_24", needs=NEEDS, evidence="rendered")
def fig_5_24(results):
    """Profiles of the middle line, found and true, of a run at each of two levels."""
    drawn, panels = new_figure(1, 2, height_in=3.8, sharey=True)
    rig, rows = mirror_rig("A"), []
    for panel, bench in zip(panels, CONTRASTED, strict=True):
        runs = Courses(results, bench=bench)
        came = np.isfinite(runs.of(THESIS_SCENE, "angle_deg"))
        # A quick build has one push.
        pushed = [row for row in came if row.any()]
        seed = first_seed(*pushed) if pushed else None
        for k, stage in enumerate(STAGES):
            true = rig.camera(STAGES_MM[stage]).mirror.height(ALONG_MM, 0 * ALONG_MM)[0]
            label = "true" if k == 0 else None
            panel.plot(ALONG_MM, true, color=INK, linestyle=":", marker="", label=label)
            look = series(k) | {"markevery": 4}
            # Where all runs were rejected the legend still names the stage.
            curve = np.full(len(ALONG_MM), np.nan)
            if seed is not None and came[k][seed]:
                curve = runs.of_seed(
                    f"{THESIS_SCENE}.stage{stage}.profile_mm", seed, came[k]
                )
                rows += [
                    (SAID[bench], stage, *row)
                    for row in zip(ALONG_MM, true, curve, strict=True)
                ]
            panel.plot(ALONG_MM, curve, label=f"stage {stage}", **look)
        panel.set(
            title=SAID[bench], xlabel="Distance from the clamp (mm)", ylim=(-4, 18)
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


def scene_seed(runs):
    """({mirror: which runs (seeds,) have the scene}, the first that has both)."""
    name = f"{OBJECTS[0]}.spread_mm"
    came = {
        mirror: np.isfinite(runs.column(f"multi.{mirror}.{name}"))
        for mirror in ("found", "true")
    }
    return came, first_seed(*came.values())


@figure("fig_5_26", needs=NEEDS, evidence="rendered")
def fig_5_26(results):
    """Plan of the scene from four stages, calibrated and true mirror."""
    runs, rows = Courses(results), []
    came, seed = scene_seed(runs)
    drawn, panels = new_figure(1, 2, height_in=4.2, sharex=True, sharey=True)
    for panel, cameras in zip(panels, ("found", "true"), strict=True):
        plan, of = (
            runs.of_seed(f"multi.{cameras}.{name}", seed, came[cameras])
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
    came, seed = scene_seed(runs)
    pixels = runs.of_seed("multi.pixels", seed, came["true"])
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
