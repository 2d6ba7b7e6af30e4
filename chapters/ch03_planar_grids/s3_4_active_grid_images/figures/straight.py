"""Fig. 3.17: the room through the fisheye, and remapped."""

import numpy as np

from chapters.ch03_planar_grids.s3_4_active_grid_images.results import LINES, lines_of
from chapters.ch03_planar_grids.s3_4_active_grid_images.trials.captures import rig_of
from chapters.ch03_planar_grids.s3_4_active_grid_images.trials.straight import MM_PER_PX
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

VIEW = "long wall"


@figure("fig_3_17", needs=("fig_3_17_lines",), evidence="rendered")
def fig_3_17(results):
    """Draw the room through the fisheye, and remapped to the active grid's plane."""
    ran = results[LINES]
    taken, laid = (ran.select(view=VIEW).arrays(name)[0] for name in ("taken", "laid"))
    lines = lines_of(ran, view=VIEW)[0]
    drawn, axes = new_figure(1, 2, height_in=2.9)
    for panel, picture, title in zip(
        axes, (taken, laid), ("(a) as taken", "(b) remapped"), strict=True
    ):
        panel.imshow(picture, interpolation="antialiased")
        panel.set_axis_off()
        panel.set_title(title)
    rows = zip(lines.before, lines.after, lines.vertical, strict=True)
    return Drawing(
        drawn,
        columns(("bent_before", "bent_after", "vertical"), rows),
        "(a) Image of a room through the 10.5 mm fisheye. (b) The same image remapped "
        f"to the plane of one active grid, {MM_PER_PX:g} mm per px. Black: not "
        "decoded. Verticals converge because the grid is pitched.",
        Check(
            bool(np.any(laid > 0)) and taken.shape[1] == rig_width(ran),
            "the image has the width of the rig's camera, and part of it is remapped",
        ),
    )


def rig_width(ran):
    """Return the width (px) of the rig's images."""
    return rig_of(ran.conditions[0]["rig"]).camera.width
