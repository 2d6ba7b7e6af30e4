"""Figs 5.20 and 5.21, and the uncertainty of a length from rays."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_5_motion.results.runs import (
    EACH_STEP,
    STAGES,
    WAY,
    MotionRuns,
)
from chapters.ch05_flexible_mirror.s3_5_motion.trials.motion import MARKER_MM
from chapters.ch05_flexible_mirror.s3_5_motion.trials.scene import RADIUS_MM, STEP_MM
from chapters.shared.mirror_bench import CONTRASTED, SAID
from chapters.shared.mirror_rigs import STAGES_MM
from raxel.geometry.poses import tangent_bases
from raxel.show import Points, Surface, framed
from repro.judge.statistics import median_interval
from repro.page.method_looks import look_of
from repro.page.space import draw_scene
from repro.page.style import INK, legend_below, plot_estimates, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

PATHS = {
    ("published", "open"): "calibrated, lengths open",
    ("published", "given"): "calibrated, lengths given",
    ("true", "given"): "true mirror, lengths given",
}
ROUNDING = 1e-9
AROUND, ALONG = 60, 2
PLACES_MM = STEP_MM * np.array(EACH_STEP)
SIGHT = (0.6, -0.3, -0.75)


@figure("fig_5_20", needs=("table_5_7_runs",), evidence="rendered")
def fig_5_20(results):
    """Path of the cylinder, true and estimated, of the median run."""
    runs = MotionRuns(results)
    drawn_as = runs.drawn_camera()
    seed = runs.middling(runs.steps("off_mm", drawn_as)[-1])
    true = runs.array("marks.path", seed)
    along = true[-1] / np.linalg.norm(true[-1])
    frame = np.column_stack([along, tangent_bases(along[None])[0]])
    drawn, panels = new_figure(1, 2, height_in=3.6)
    paths = {"actual": true} | {
        words: runs.array(f"{camera}.{way}.path", seed)
        for (camera, way), words in PATHS.items()
    }
    paths = {words: path for words, path in paths.items() if path is not None}
    looks = {"actual": {"color": INK, "marker": "s"}}
    looks[PATHS["true", "given"]] = look_of("true mirror")
    rows = []
    for index, (words, path) in enumerate(paths.items()):
        places = path @ frame
        look = looks.get(words, series(index - 1))
        for k, panel in enumerate(panels, 1):
            panel.plot(places[:, 0], places[:, k], label=words, **look)
        rows += [(words, step, *place) for step, place in enumerate(places)]
    for panel, side in zip(
        panels, ("first perpendicular", "second perpendicular"), strict=True
    ):
        panel.set(
            xlabel="Position along the motion (mm)", ylabel=f"Offset, {side} (mm)"
        )
    legend_below(drawn, panels[0], ncols=2)
    last = runs.array(f"{drawn_as}.{WAY}.path", seed)[-1]
    off = np.linalg.norm(last - true[-1])
    told = runs.steps("off_mm", drawn_as)[-1][seed]
    return Drawing(
        drawn,
        columns(
            ("path", "step", "along_mm", "first_offset_mm", "second_offset_mm"), rows
        ),
        "Path of the cylinder, true and added up from pairs of images, with the mean "
        f"step scaled to {STEP_MM:g} mm. Second level, the run with the median final "
        "error of those that have a cylinder.",
        Check(
            bool(abs(off - told) < ROUNDING),
            f"the drawn final error of {off:.2f} mm is that of the trial",
        ),
    )


@figure("fig_5_21", needs=("table_5_7_runs",), evidence="rendered", scene=True)
def fig_5_21(results):
    """Reconstructed points and the cylinder through them."""
    runs = MotionRuns(results)
    camera = runs.drawn_camera()
    scaled = runs.of("scaled_mm", camera)
    seed = runs.middling(np.abs(scaled - RADIUS_MM))
    points = runs.array(f"{camera}.{WAY}.points", seed)
    at, axis, (radius,) = np.split(runs.array(f"{camera}.{WAY}.cylinder", seed), (3, 6))
    basis = tangent_bases(axis[None])[0]
    across, height = (points - at) @ basis, (points - at) @ axis
    drawn, (left, right) = new_figure(1, 2, height_in=3.8)
    drawn.set_layout_engine("none")
    left.set_position([0.1, 0.22, 0.38, 0.72])
    right.set_position([0.52, 0.14, 0.47, 0.82])
    turn = np.linspace(0, 2 * np.pi, AROUND + 1)
    circle = np.column_stack([np.cos(turn), np.sin(turn)])
    true = runs.of("scaled_mm", "true")[seed]
    for size, words, look in (
        (radius, "estimated", series(0)),
        (true, "true mirror", look_of("true mirror")),
        (RADIUS_MM, "truth", {"color": INK, "ls": "-", "lw": 1.0}),
    ):
        left.plot(*(size * circle).T, label=words, **look | {"marker": ""})
    for place in across:
        left.plot(*(place[:, None] + MARKER_MM * circle.T), color=series(1)["color"],
                  marker="", ls="-")  # fmt: skip
    left.set(xlabel="x across the axis (mm)", ylabel="y across the axis (mm)")
    left.set_aspect("equal")
    legend_below(drawn, left, ncols=3)
    ends = np.array([np.nanmin(height), np.nanmax(height)])
    wall = at + radius * (circle @ basis.T)[None] + ends[:, None, None] * axis
    known = np.isfinite(points).all(axis=1)
    scene = framed(
        [
            Surface(wall, series(0)["color"], 0.5, "estimated cylinder"),
            Points(points[known], series(1)["color"], "points", 12.0),
        ],
        SIGHT,
        up=tuple(-axis * np.sign(axis[1])),
        aspect=0.9,
        note="Points reconstructed from six images, and the cylinder fitted to them.",
    )
    draw_scene(right, scene)
    off = np.abs(np.linalg.norm(across[known], axis=1) - radius)
    told = runs.of("fit_mm", camera)[seed]
    return Drawing(
        drawn,
        columns(
            ("across_x_mm", "across_y_mm", "along_mm"),
            np.column_stack([across, height]).tolist(),
        ),
        f"Reconstructed points as markers of {MARKER_MM:g} mm, and the cylinder fitted "
        "to them, scaled by the mean step. Second level, the run with the median error "
        "of the radius. The circle of the true mirror has the same axis.",
        Check(
            bool(abs(off.mean() - told) < 1e-6),
            f"mean distance from the cylinder as drawn {off.mean():.3f} mm, as in the "
            "trial",
        ),
        scene,
    )


@figure("ext_motion_scale", needs=("table_5_7_runs",), evidence="rendered")
def ext_motion_scale(results):
    """Uncertainty of a length, by stage and by baseline."""
    drawn, (left, right) = new_figure(1, 2, height_in=3.6, sharey=True)
    rows = []
    for index, bench in enumerate(CONTRASTED):
        runs = MotionRuns(results, bench=bench)
        by_stage = [runs.column(f"stage{s}.told1.length_percent") for s in STAGES]
        by_way = [
            runs.column(f"stage{STAGES[-1]}.told{k}.length_percent") for k in EACH_STEP
        ]
        six = [runs.of("told_percent", "true", "together")]
        for panel, x, trials, look, label in (
            (left, STAGES_MM, by_stage, index, SAID[bench]),
            (right, PLACES_MM, by_way, index, SAID[bench]),
            (
                right,
                PLACES_MM[-1:],
                six,
                2 + index,
                f"{SAID[bench]}, six images at once",
            ),
        ):
            some = [
                (at, one[np.isfinite(one)])
                for at, one in zip(x, trials, strict=True)
                if np.isfinite(one).any()
            ]
            if some:
                rows += plot_estimates(
                    panel,
                    [at for at, _ in some],
                    [median_interval(one) for _, one in some],
                    ("deflection" if panel is left else "baseline", label),
                    look=series(look),
                    label=label,
                    bars=True,
                )
    left.set(xlabel="Deflection (mm)", yscale="log")
    left.set_ylabel("SD of the length (%)")
    right.set(xlabel="Baseline at 15 mm (mm)")
    legend_below(drawn, right, ncols=2)
    return Drawing(
        drawn,
        columns(("over", "rays", "x", "median", "low", "high"), rows),
        "Standard deviation with which rays of the true mirror determine a length, % "
        "of the length; medians over runs with 95 % intervals. Left: one step of "
        f"{STEP_MM:g} mm at each deflection; a flat mirror at the low-noise level "
        "determines none. Right: at 15 mm, from the first position to later ones with "
        "two images, and with all six at once.",
    )
