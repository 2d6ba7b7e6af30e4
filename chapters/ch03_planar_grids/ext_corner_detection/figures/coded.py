"""Table and figure of the coded grid (6.3.1)."""

from __future__ import annotations

import numpy as np
from matplotlib.ticker import FixedFormatter

from chapters.ch03_planar_grids.ext_corner_detection.trials.coded import (
    OUTCOMES,
)
from repro.page.style import figure as new_figure
from repro.run.experiment import figure, table
from repro.run.outcomes import Check, Drawing, Table

COLOURS = ("#009e73", "#56b4e9", "#d5d9de", "#e69f00", "#d55e00")
HATCHES = ("", "..", "", "//", "xx")
MARGIN_PX = 40


def name_of(condition):
    """How a condition is called in table and figure."""
    if condition["grid"] != "coded":
        return condition["grid"]
    return (
        f"{condition['marks']}, {condition['fov_deg']}°, "
        f"noise {condition['noise_sd']}"
    )


def counts(result, condition):
    """How often each of OUTCOMES came, (5,) int."""
    outcomes = result.texts("outcome", **condition)
    return np.array([outcomes.count(name) for name in OUTCOMES])


@table(
    "ext_coded_places",
    needs=("ext_coded_grid_runs",),
    evidence="rendered",
)
def ext_coded_places(results):
    """What became of the clicked blocks, and how their marks were read."""
    result = results["ext_coded_grid_runs"]
    trials = result.trials_per_condition
    found = [counts(result, c) for c in result.conditions]
    columns = {"picture": [name_of(c) for c in result.conditions]}
    for number, outcome in enumerate(OUTCOMES):
        columns[f"{outcome} (%)"] = [
            f"{100 * n[number] / trials:.0f}" for n in found
        ]
    columns["wrong marks"] = [_marks(result, c) for c in result.conditions]
    total = int(sum(n.sum() for n in found))
    wrong = int(sum(n[-1] for n in found))
    return Table(
        columns,
        f"Blocks of 6 × 6 corners, {trials} of each kind: contrast of the "
        "marks, field of view, noise SD in grey levels. Right: every corner "
        "within 8 px and with its true number on the grid. A corner off: "
        "the numbers are true, but not all corners within 8 px. Wrong marks: "
        "of the 25 of a block, at the best place, on average where all "
        "corners are within 8 px.",
        Check(
            total == trials * len(found) and wrong <= 0.01 * total,
            f"{wrong} of {total} blocks are put in a wrong place",
        ),
    )


def _marks(result, condition):
    ordered = result.column("ordered", **condition) == 1
    errors = result.column("errors", **condition)[ordered]
    return f"{errors.mean():.2f}" if len(errors) else ""


@figure(
    "ext_coded_grid",
    needs=("ext_coded_grid_runs", "ext_coded_grid_picture"),
    evidence="rendered",
)
def ext_coded_grid(results):
    """A picture with its block's numbers, and outcomes by picture."""
    drawn, panels = new_figure(1, 2, height_in=4.6, width_ratios=(1.15, 1))
    data = {k: [] for k in ("panel", "what", "a", "b", "u_px", "v_px")}
    right = _draw_block(panels[0], results["ext_coded_grid_picture"], data)
    _draw_outcomes(panels[1], results["ext_coded_grid_runs"], data)
    handles, labels = panels[1].get_legend_handles_labels()
    drawn.legend(handles, labels, loc="outside lower center", ncols=3)
    return Drawing(
        drawn,
        data,
        "(a) A coded grid through a fisheye of 134° (the first of some "
        "pictures whose block was found): a block of 6 × 6 corners, and row "
        "and column on the grid of four of them. Circles: clicks. (b) What "
        "became of the blocks of all pictures: contrast of the marks, field "
        "of view, noise SD.",
        Check(right == "right", f"the block of (a) is {right}"),
    )


def _draw_block(panel, result, data):
    """Draw the first block that was found; returns what became of it."""
    picture, clicked, corners, numbers = (
        result.arrays(name)[0]
        for name in ("picture", "clicks", "corners", "numbers")
    )
    panel.imshow(picture, cmap="gray", vmin=0, vmax=255)
    panel.grid(visible=False)
    panel.plot(*clicked.T, "o", mfc="none", mec="#56b4e9", mew=1.8, ms=9)
    points = corners.reshape(-1, 2)
    panel.plot(*points.T, ".", color="#d55e00", ms=6)
    for i, j in ((0, 0), (0, -1), (-1, -1), (-1, 0)):
        away = corners[i, j] - points.mean(axis=0)
        panel.annotate(
            f"{numbers[i, j][0]}, {numbers[i, j][1]}",
            corners[i, j] + 26 * away / np.linalg.norm(away),
            color="white",
            fontsize=9,
            ha="center",
            va="center",
            bbox={"boxstyle": "round,pad=0.2", "fc": "#1b1f24"},
        )
    for (row, column), (u, v) in zip(
        numbers.reshape(-1, 2), points, strict=True
    ):
        cells = ("a", "corner", row, column, u, v)
        for name, cell in zip(data, cells, strict=True):
            data[name].append(cell)
    low = points.min(axis=0) - 2 * MARGIN_PX
    high = points.max(axis=0) + 2 * MARGIN_PX
    panel.set_xlim(low[0], high[0])
    panel.set_ylim(high[1], low[1])
    panel.set_title("(a) a block and its place")
    panel.set_xlabel("u (px)")
    panel.set_ylabel("v (px)")
    located = ("right", "a corner off", "wrong place")
    found = [o for o in result.texts("outcome") if o in located]
    return found[0]


def _draw_outcomes(panel, result, data):
    names = [name_of(c) for c in result.conditions]
    found = np.array([counts(result, c) for c in result.conditions])
    shares = 100 * found / result.trials_per_condition
    rows = np.arange(len(names))
    left = np.zeros(len(names))
    for number, outcome in enumerate(OUTCOMES):
        panel.barh(
            rows,
            shares[:, number],
            left=left,
            color=COLOURS[number],
            hatch=HATCHES[number],
            edgecolor="#4a4a4a",
            linewidth=0.5,
            label=outcome,
        )
        left += shares[:, number]
        for name, share in zip(names, shares[:, number], strict=True):
            cells = ("b", f"{name}: {outcome} (%)", share, *[np.nan] * 3)
            for column, cell in zip(data, cells, strict=True):
                data[column].append(cell)
    panel.set_yticks(rows)
    panel.yaxis.set_major_formatter(FixedFormatter(names))
    panel.invert_yaxis()
    panel.set_xlim(0, 100)
    panel.set_title("(b) outcomes")
    panel.set_xlabel("Blocks (%)")
