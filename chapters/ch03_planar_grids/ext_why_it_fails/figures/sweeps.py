"""What is lost as a picture gets harder: the sweeps of Fig. 3.11, and two orderings."""

import numpy as np

from chapters.ch03_planar_grids.ext_why_it_fails.figures.drawing import draw_stages
from chapters.ch03_planar_grids.ext_why_it_fails.results import (
    SWEEPS,
    counted,
    shares_of,
)
from chapters.shared.robustness import DEFAULTS
from chapters.shared.synthetic_board import SIZE_PX
from repro.page.style import figure as new_figure
from repro.page.style import series
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

FAMILIES = {"arc": "Arc of the board", "fov": "Field of view"}
LINE, PLANE = "line that joins a row's ends", "homography of four clicks"


@figure("ext_why_sweeps", needs=("ext_why_sweeps",), evidence="rendered")
def ext_why_sweeps(results):
    """The failures of Fig. 3.11 by stage."""
    result = results["ext_why_sweeps"]
    stages = {}
    for condition in result.conditions:
        name, value = next(
            (key, condition[key]) for key in SWEEPS if condition[key] != DEFAULTS[key]
        )
        label = SWEEPS[name].format(value, SIZE_PX / value)
        stages[label] = result.texts("stage", **condition)
    drawn, panel = new_figure(1, 1, height_in=4.2)
    draw_stages(panel, shares_of(stages), "Level of the sweep")
    panel.tick_params(axis="x", labelrotation=90)
    return Drawing(
        drawn,
        counted(stages),
        "Levels of Fig. 3.11 at which boards are lost, in trials of their own and "
        "fewer: the first thing that went wrong, which need not be where CELECT "
        "gave up. Noise in grey "
        "levels, blur in px, FOV and yaw in degrees; one thing is changed at a "
        "time.",
    )


@figure("ext_why_orderings", needs=("ext_why_orderings",), evidence="synthetic")
def ext_why_orderings(results):
    """Where the two orderings of 1.2.1 fail, and their criteria."""
    result = results["ext_why_orderings"]
    drawn, panels = new_figure(2, 2, height_in=5.6, sharex="col")
    names, rows = ("line", "homography", "margin", "stray"), []
    for column, (family, title) in enumerate(FAMILIES.items()):
        of_bend = result.by("bend_deg", family=family)
        bends = list(of_bend)
        means = {
            name: np.array([of.column(name).mean() for of in of_bend.values()])
            for name in names
        }
        top, bottom = panels[:, column]
        top.plot(bends, 100 * means["line"], label=LINE, **series(0))
        top.plot(bends, 100 * means["homography"], label=PLANE, **series(1))
        top.set(title=title, ylabel="Ordered right (%)")
        bottom.plot(bends, means["margin"], label="margin of a row", **series(0))
        bottom.plot(bends, means["stray"], label="stray of a corner", **series(1))
        bottom.axhline(0, color="#4a4a4a", lw=1)
        bottom.axhline(0.5, color="#4a4a4a", lw=1, ls=":")
        bottom.set(ylim=(-1.5, 3), xlabel=f"{title} (deg)", ylabel="Squares (1)")
        rows += [(family, *row) for row in zip(bends, *means.values(), strict=True)]
    panels[0, 0].legend()
    panels[1, 0].legend()
    return Drawing(
        drawn,
        columns(("family", "bend_deg", *names), rows),
        "Two orderings of section 1.2.1 on true corners with an error of "
        "0.5 px. Top: share of trials with every corner in its place. Below, "
        "in squares: by how much the nearest corner of another row is farther "
        "from the line that joins a row's ends than the row's own farthest "
        "(below 0 the first ordering has to fail), and how far a corner is from "
        "its place under the homography (dotted: half a square).",
    )
