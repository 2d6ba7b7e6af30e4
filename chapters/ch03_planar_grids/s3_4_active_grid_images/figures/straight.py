"""Fig. 3.17: the room as taken and as laid out, and its edges one by one."""

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
    """The room through the fisheye, and on the plane of the active grid."""
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
        "A room through the 10.5 mm fisheye, and the same picture laid out on the "
        f"plane of one active grid with {MM_PER_PX:g} mm of the grid per px. "
        "Black: nothing "
        "decoded. The grid is pitched, so verticals converge.",
        Check(
            bool(np.any(laid > 0)) and taken.shape[1] == rig_width(ran),
            "the picture taken is the rig's, and part of it is remapped",
        ),
    )


def rig_width(ran):
    """Width (px) of the pictures of the rig."""
    return rig_of(ran.conditions[0]["rig"]).camera.width
