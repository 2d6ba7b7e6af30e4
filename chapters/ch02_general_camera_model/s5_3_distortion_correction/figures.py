"""Fig. 2.7: a building front, corrected with both calibrations."""

import numpy as np

from chapters.ch02_general_camera_model.s5_3_distortion_correction.results import (
    HALF_PX,
    distances,
    edges_of,
    from_line,
    line_through,
    most_bent,
    shared,
)
from chapters.shared.methods import NAMES
from chapters.shared.zoom_rigs import FACADE_ZOOM, camera_of
from repro.page.method_looks import look_of
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

PANELS = (
    ("facade", "(a) as taken"),
    ("view.parametric", "(b) parametric"),
    ("view.parametric", "(c) part of (b)"),
    ("view.generic_as_printed", "(d) generic"),
    ("view.generic_as_printed", "(e) part of (d)"),
    ("view.upright", "(f) as (d), plane upright"),
)
MIN_DRAWN_PX = 0.001
COLOUR = "#d55e00"


@figure("fig_2_7", needs=("table_2_2_rendered",), evidence="rendered")
def fig_2_7(results):
    """Draw the front as taken, corrected with both calibrations, and upright."""
    rendered = results["table_2_2_rendered"]
    edges = edges_of(rendered)
    both = shared(edges)
    chosen, at = most_bent(edges)
    drawn, axes = new_figure(3, 2, height_in=7.6)
    shown = {"panel": [], "share_of_picture_shown": []}
    for panel, (name, title) in zip(axes.flat, PANELS, strict=True):
        picture = rendered.arrays(name, zoom=FACADE_ZOOM)[0]
        panel.imshow(picture, cmap="gray", vmin=0, vmax=255)
        panel.set_axis_off()
        panel.set_anchor("W")
        if title.startswith(("(b)", "(d)")):
            panel.add_patch(frame_around(at))
        if title.startswith(("(c)", "(e)")):
            edge = edges[name.removeprefix("view.")][chosen]
            title += f": {draw_part(panel, edge, both[chosen], at)}"
        panel.set_title(title)
        shown["panel"].append(title)
        shown["share_of_picture_shown"].append(float(np.mean(picture > 0)))
    return Drawing(
        drawn,
        shown,
        "A building front imaged with the lens of set 2: (a) as taken; (b), "
        "(d) corrected with each calibration of one rendered run; (c), (e) "
        "enlarged parts at the edge that the parametric correction bends "
        "most; (f) generic correction on a plane parallel to the front's "
        "verticals. Dashed: the best line of that edge where both methods "
        "show it, extrapolated. Black: no ray.",
        Check(
            shown["share_of_picture_shown"][3] > 0.05,
            "the generic correction shows a part of the front",
        ),
    )


def draw_part(panel, edge, both, at):
    """Enlarge an image about a point, draw the line of an edge, return its bend."""
    off = from_line(edge, both)
    panel.plot(*line_through(edge[both]).T, "--", color=COLOUR, lw=1.2)
    panel.set(
        xlim=(at[0] - HALF_PX, at[0] + HALF_PX), ylim=(at[1] + HALF_PX, at[1] - HALF_PX)
    )
    here = np.all(np.abs(edge - at) < HALF_PX, axis=1)
    return f"edge up to {np.max(np.abs(off[here])):.1f} px off"


@figure("ext_fig_2_7_lines", needs=("table_2_2_rendered",), evidence="rendered")
def ext_fig_2_7_lines(results):
    """Draw the edges' distances from their lines, by the distance from mid-image."""
    edges = edges_of(results["table_2_2_rendered"])
    camera = camera_of(FACADE_ZOOM)
    middle = (np.array([camera.width, camera.height]) - 1) / 2
    radius = np.linalg.norm(edges["as_taken"] - middle, axis=2)
    both = shared(edges)
    drawn, axes = new_figure(1, 2, height_in=3.2, sharex=True, sharey=True)
    rows = []
    for panel, (method, off), letter in zip(
        axes, distances(edges).items(), "ab", strict=True
    ):
        off = np.maximum(off, MIN_DRAWN_PX)
        for inside, mark, label in (
            (~both, "0.6", "outside the boards"),
            (both, look_of(NAMES[method])["color"], "on the boards"),
        ):
            some = inside & np.isfinite(off)
            panel.plot(radius[some], off[some], ".", ms=2, color=mark, label=label)
            rows += [
                (method, label, *pair)
                for pair in zip(radius[some], off[some], strict=True)
            ]
        panel.set(
            title=f"({letter}) {NAMES[method]}",
            xlabel="Distance from the image centre (px)",
        )
        panel.legend(loc="upper left", markerscale=4)
    axes[0].set(yscale="log", ylabel="Distance from the line (px)")
    return Drawing(
        drawn,
        columns(("method", "where", "radius_px", "distance_px"), rows),
        "Distance of points of the front's straight edges from the best line "
        "of their edge, in the corrected images of Fig. 2.7. Lines are fitted "
        "where both methods show the edge. Grey: points where no board was, "
        "which only the parametric method shows. Distances below "
        f"{MIN_DRAWN_PX} px are drawn at that value.",
    )


def frame_around(at):
    """Return the outline of the enlarged part."""
    from matplotlib.patches import Rectangle

    corner = np.asarray(at) - HALF_PX
    return Rectangle(corner, 2 * HALF_PX, 2 * HALF_PX, fill=False, color=COLOUR, lw=1.5)
