"""Fig. 3.17: the room as taken and as laid out, and its edges one by one."""

import numpy as np

from chapters.ch03_planar_grids.s3_4_active_grid_images.figures.surroundings import (
    drawn_surroundings,
)
from chapters.ch03_planar_grids.s3_4_active_grid_images.results import (
    HALF_PITCH,
    LINES,
    OF_LINES,
    lines_of,
)
from chapters.ch03_planar_grids.s3_4_active_grid_images.trials.captures import rig_of
from chapters.ch03_planar_grids.s3_4_active_grid_images.trials.straight import (
    MM_PER_PX,
    T_world_camera,
)
from raxel.lab import room
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


@figure("ext_fig_3_17_lines", needs=("fig_3_17_lines",), evidence="rendered")
def ext_fig_3_17_lines(results):
    """How bent each edge of the room is, before and after."""
    ran = results[LINES]
    drawn, axes = new_figure(1, 2, height_in=3.4, sharex=True, sharey=True)
    rows = []
    for panel, view, letter in zip(axes, ("long wall", "corner"), "ab", strict=True):
        for points, mark, label in (
            ("found in the picture", "o", "found in the pictures"),
            ("projected from truth", "x", "projected from truth"),
        ):
            lines = lines_of(ran, {"line_points": points}, view=view)
            before, after = (
                np.concatenate([100 * getattr(one, when) for one in lines])
                for when in ("before", "after")
            )
            panel.plot(before, after, mark, ms=3.5, label=label, alpha=0.7)
            rows += [(view, points, *pair) for pair in zip(before, after, strict=True)]
        panel.axhline(1, color="0.5", lw=1, ls="--")
        panel.axvline(5, color="0.5", lw=1, ls="--")
        panel.set(
            title=f"({letter}) towards the {view}", xlabel="Bent before (% of length)"
        )
    axes[0].set(xscale="log", yscale="log", ylabel="Bent after (% of length)")
    axes[1].legend(loc="lower right")
    return Drawing(
        drawn,
        columns(("view", "points", "before_percent", "after_percent"), rows),
        "Every edge of the room that can be measured, all seeds: largest distance of "
        "its points from their best line over its length. Dashed: what the "
        "claim allows "
        "after, and asks for before.",
    )


@figure("ext_fig_3_17_verticals", needs=OF_LINES, evidence="rendered")
def ext_fig_3_17_verticals(results):
    """The lean of every vertical, beside the one that the grid's pose predicts."""
    drawn, axes = new_figure(height_in=3.6)
    rows = []
    for ran, mark, word in (
        (results[LINES], "o", "pitched"),
        (results[HALF_PITCH], "s", "half as much"),
    ):
        seeds = ran.select(view=VIEW).levels("seed")
        for seed, lines in zip(seeds, lines_of(ran, view=VIEW), strict=True):
            up = lines.vertical
            rows += [
                (word, seed, lines.pitch, *pair)
                for pair in zip(lines.predicted[up], lines.lean[up], strict=True)
            ]
        mine = np.array([row[3:] for row in rows if row[0] == word])
        axes.plot(*mine.T, mark, ms=5, label=word, fillstyle="none")
    ends = np.array(axes.get_xlim())
    axes.plot(ends, ends, color="0.5", lw=1, label="as predicted")
    axes.set(xlabel="Predicted lean (deg)", ylabel="Lean in the picture (deg)")
    axes.legend()
    off = max(abs(row[4] - row[3]) for row in rows)
    return Drawing(
        drawn,
        columns(("grid", "seed", "pitch_deg", "predicted_deg", "found_deg"), rows),
        "Verticals of the room in the remapped pictures: angle from the columns, and "
        f"what pose and pitch of the grid say of it; at most {off:.2f} deg apart.",
    )


@figure("ext_fig_3_17_room", needs=("fig_3_17_lines",), evidence="analytic", scene=True)
def ext_fig_3_17_room(results):
    """The fisheye in its room."""
    return drawn_surroundings(
        room(),
        rig_of("d200-fisheye").camera,
        T_world_camera(VIEW),
        "The fisheye of Fig. 3.17 in the middle of the room, level, facing the long "
        "wall. Blue: rays at the edge of its field of view, cut off at one length. The "
        "camera is drawn larger than it is.",
    )
