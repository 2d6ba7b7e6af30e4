"""Stage counts of all cases, the failures of Fig. 3.11, and the two orderings."""

from __future__ import annotations

from collections import Counter

import numpy as np

from chapters.ch03_planar_grids.ext_why_it_fails.figures.drawing import (
    draw_stages,
)
from chapters.ch03_planar_grids.ext_why_it_fails.figures.pairs import (
    shares_of,
    stages_of,
)
from chapters.ch03_planar_grids.ext_why_it_fails.trials.cases import CASES
from chapters.ch03_planar_grids.ext_why_it_fails.trials.stages import (
    DONE,
    STAGES,
)
from chapters.shared.robustness import DEFAULTS
from chapters.shared.synthetic_board import SIZE_PX
from repro.page.style import figure as new_figure
from repro.page.style import series
from repro.run.experiment import figure, table
from repro.run.outcomes import Drawing, Table

TITLES = {
    "clearance": "clearance",
    "first_corner": "first corner, (a)",
    "wrong_contour": "first corner, (b)",
    "direction": "direction",
    "window": "window",
    "curvature": "curvature",
    "size_variation": "size variation",
    "blur_noise": "blur and noise",
}
SWEEPS = {
    "noise_sd": "noise {0}",
    "blur_px": "blur {0} px",
    "squares_across": "squares {1:.0f} px",
    "fov_deg": "FOV {0}°",
    "yaw_deg": "yaw {0}°",
}
FAMILIES = {"arc": "Arc of the board", "fov": "Field of view"}
LINE, PLANE = "line that joins a row's ends", "homography of four clicks"


@table(
    "ext_why_stages",
    needs=(
        "ext_why_clearance",
        "ext_why_first_corner",
        "ext_why_wrong_contour",
        "ext_why_direction",
        "ext_why_window",
        "ext_why_curvature",
        "ext_why_size_variation",
        "ext_why_blur_noise",
    ),
    evidence="rendered",
)
def ext_why_stages(results):
    """The drawn levels of all cases, by the stage that lost them."""
    columns = {"condition": [], "level": [], "trials": [], DONE: []}
    columns |= {stage: [] for stage in STAGES}
    columns["returned, but wrong"] = []
    for case, title in TITLES.items():
        result = results[f"ext_why_{case}"]
        stages = stages_of(result)
        for name, level in CASES[case]["drawn"].items():
            lost = Counter(stages[level])
            wrong = result.column(f"{level}.silently_wrong").sum()
            cells = (title, name, len(stages[level]), lost[DONE])
            cells += tuple(lost[stage] for stage in STAGES) + (int(wrong),)
            for column, cell in zip(columns.values(), cells, strict=True):
                column.append(cell)
    kept = {
        name: cells
        for name, cells in columns.items()
        if name not in STAGES or any(cells)
    }
    return Table(
        kept,
        "Random variations of every drawn pair, counted by the stage that lost "
        "them. Stages that lost none are left out.",
    )


@figure("ext_why_sweeps", needs=("ext_why_sweeps",), evidence="rendered")
def ext_why_sweeps(results):
    """The failures of Fig. 3.11 by stage."""
    result = results["ext_why_sweeps"]
    stages = {}
    for condition in result.conditions:
        name, value = next(
            (key, condition[key])
            for key in SWEEPS
            if condition[key] != DEFAULTS[key]
        )
        label = SWEEPS[name].format(value, SIZE_PX / value)
        stages[label] = result.texts("stage", **condition)
    drawn, panel = new_figure(1, 1, height_in=4.2)
    draw_stages(panel, shares_of(stages), "Level of the sweep")
    panel.tick_params(axis="x", labelrotation=90)
    data = {"level": [], "stage": [], "trials": []}
    for level, lost in stages.items():
        for stage, count in sorted(Counter(lost).items()):
            cells = (level, stage, count)
            for column, cell in zip(data, cells, strict=True):
                data[column].append(cell)
    return Drawing(
        drawn,
        data,
        "The lost trials of Fig. 3.11: which stage lost them. Noise in grey "
        "levels, blur in px, FOV and yaw in degrees; one thing is changed at a "
        "time.",
    )


@figure(
    "ext_why_orderings", needs=("ext_why_orderings",), evidence="synthetic"
)
def ext_why_orderings(results):
    """Where the two orderings of 1.2.1 fail, and their criteria."""
    result = results["ext_why_orderings"]
    drawn, panels = new_figure(2, 2, height_in=5.6, sharex="col")
    data = {
        name: []
        for name in (
            "family",
            "bend_deg",
            "line",
            "homography",
            "margin",
            "stray",
        )
    }
    for column, (family, title) in enumerate(FAMILIES.items()):
        bends = [
            c["bend_deg"]
            for c in result.conditions
            if c["family"] == family
        ]
        means = {
            name: np.array(
                [
                    result.column(name, family=family, bend_deg=b).mean()
                    for b in bends
                ]
            )
            for name in ("line", "homography", "margin", "stray")
        }
        top, bottom = panels[:, column]
        top.plot(bends, 100 * means["line"], label=LINE, **series(0))
        top.plot(bends, 100 * means["homography"], label=PLANE, **series(1))
        top.set_title(title)
        top.set_ylabel("Ordered right (%)")
        bottom.plot(
            bends, means["margin"], label="margin of a row", **series(0)
        )
        bottom.plot(
            bends, means["stray"], label="stray of a corner", **series(1)
        )
        bottom.axhline(0, color="#4a4a4a", lw=1)
        bottom.axhline(0.5, color="#4a4a4a", lw=1, ls=":")
        bottom.set_ylim(-1.5, 3)
        bottom.set_xlabel(f"{title} (deg)")
        bottom.set_ylabel("Squares (1)")
        for k, bend in enumerate(bends):
            cells = (family, bend, *(m[k] for m in means.values()))
            for name, cell in zip(data, cells, strict=True):
                data[name].append(cell)
    panels[0, 0].legend()
    panels[1, 0].legend()
    return Drawing(
        drawn,
        data,
        "Two orderings of section 1.2.1 on true corners with an error of "
        "0.5 px. Top: share of trials with every corner in its place. Below, "
        "in squares: by how much the nearest corner of another row is farther "
        "from the line that joins a row's ends than the row's own farthest "
        "(below 0 the first ordering has to fail), and how far a corner is from "
        "its place under the homography (dotted: half a square).",
    )


def first_failure(result, name, family):
    """The smallest bend (deg) at which an ordering fails in a trial; nan if none."""
    for condition in result.conditions:
        if condition["family"] == family:
            bend = condition["bend_deg"]
            right = result.column(name, family=family, bend_deg=bend)
            if right.mean() < 1:
                return float(bend)
    return float("nan")
