"""Results of this page read: values of the prose, figures, tables, judgements."""

import numpy as np

from chapters.shared.general import (
    FACADE_ZOOM,
    HALF_VIEW_DEG,
    MIN_ON_LINE,
    OF_SEEDS,
    PITCH_DEG,
    ZoomCase,
    generic_wins,
    zoom_camera,
)
from chapters.shared.methods import NAMES
from repro.page import look_of, new_figure, value
from repro.run import Check, Drawing, claim, columns, figure, with_worst

# Distances from straight lines, from the simulated runs of section 2.5.2.


HALF_PX = 110  # half the side of the enlarged parts


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    results = {name: open_results(name) for name in OF_SEEDS}
    edges = edges_of(open_results("table_2_2_rendered"))
    found = {
        **{
            name: line_median(ZoomCase(results), name)
            for name in ("generic", "parametric")
        },
        "generic_smooth": line_median(
            ZoomCase(results, {"interpolation": "smooth"}), "generic"
        ),
        "bend": np.nanmax(distances(edges)["parametric"]),
        "pitch": PITCH_DEG,
        "half_view": HALF_VIEW_DEG,
    }
    for name, number in found.items():
        value(name, number)


def line_median(case, name):
    """Return a method's median distance (px) from straight lines, over runs."""
    return float(np.median(with_worst(line_trials(case, name))))


def line_trials(case, name):
    """Return RMS distances (px) from straight lines of a method, over runs (n,)."""
    path = case["standard_method"], name, case["residual_scale"]
    return case.column("lines", FACADE_ZOOM, *path)


def edges_of(rendered):
    """Return the front's edges (edges, points, 2), as taken and as corrected, px."""
    names = ("as_taken", "parametric", "generic_as_printed")
    return {name: rendered.arrays("edges", name, zoom=FACADE_ZOOM)[0] for name in names}


def shared(edges):
    """Return which points (edges, points) both corrected images show."""
    return np.isfinite(
        edges["parametric"][..., 0] + edges["generic_as_printed"][..., 0]
    )


def from_line(edge, known):
    """Return signed distances (points,) of an edge from the line of known points."""
    centre, along = best_line(edge[known])
    return (edge - centre) @ [-along[1], along[0]]


def best_line(points):
    """Return a point and the direction of the best line (total least squares)."""
    centre = points.mean(axis=0)
    return centre, np.linalg.svd(points - centre)[2][0]


def line_through(points, reach_px=2000.0):
    """Return two distant points (2, 2) on the best line of points."""
    centre, along = best_line(points)
    return centre + np.outer([-reach_px, reach_px], along)


def distances(edges):
    """Return distances (edges, points) in px from lines of shared points, by method."""
    both, out = shared(edges), {}
    for method in ("parametric", "generic_as_printed"):
        out[method] = np.full(both.shape, np.nan)
        for number in np.flatnonzero(np.sum(both, axis=1) >= MIN_ON_LINE):
            edge = edges[method][number]
            out[method][number] = np.abs(from_line(edge, both[number]))
    return out


def most_bent(edges):
    """Return the edge that the parametric correction bends most, and a point.

    The point is halfway between where the edge leaves the boards and where it is
    farthest from its line, but at most HALF_PX / 2 from the former.
    """
    off = distances(edges)["parametric"]
    number, worst = np.unravel_index(np.nanargmax(off), off.shape)
    known = np.flatnonzero(shared(edges)[number])
    leaves = known[np.argmin(np.abs(known - worst))]
    start, end = edges["parametric"][number, [leaves, worst]]
    far = np.linalg.norm(end - start)
    return number, start + (end - start) / max(2.0, 2 * far / HALF_PX)


# Fig. 2.7: a building front, corrected with both calibrations.


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
        image = rendered.arrays(name, zoom=FACADE_ZOOM)[0]
        panel.imshow(image, cmap="gray", vmin=0, vmax=255)
        panel.set_axis_off()
        panel.set_anchor("W")
        if title.startswith(("(b)", "(d)")):
            panel.add_patch(frame_around(at))
        if title.startswith(("(c)", "(e)")):
            edge = edges[name.removeprefix("view.")][chosen]
            title += f": {draw_part(panel, edge, both[chosen], at)}"
        panel.set_title(title)
        shown["panel"].append(title)
        shown["share_of_picture_shown"].append(float(np.mean(image > 0)))
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
    camera = zoom_camera(FACADE_ZOOM)
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


# The claim of section 2.5.3, tested as the registry words it.


@claim(
    "c2_periphery",
    needs=OF_SEEDS,
    evidence="rendered",
    readings=("standard_method", "residual_scale", "interpolation"),
)
def judge_periphery(results, options):
    """Near the edge, generic lines are straighter than parametric ones."""
    case = ZoomCase(results, options)
    generic, parametric = (
        line_trials(case, name) for name in ("generic", "parametric")
    )
    return generic_wins(generic, parametric, "RMS distance from straight lines")
