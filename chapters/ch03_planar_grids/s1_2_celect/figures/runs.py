"""Figs 3.1, 3.2 and 3.4, from recorded runs."""

import numpy as np

from chapters.ch03_planar_grids.s1_2_celect.results import (
    Run,
    line_ends,
    turning_step,
    which_view,
)
from raxel.features.celect import CelectSettings
from raxel.features.celect.hough import angle_apart
from repro.page.style import figure as new_figure
from repro.page.style import series
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

GREY = {"cmap": "gray", "vmin": 0, "vmax": 255, "interpolation": "nearest"}
BLUE, RED, GREEN, PINK = (series(i)["color"] for i in range(4))
YELLOW = series(5)["color"]
VIEW_RADII = 2.6


def draw_image(axes, image):
    """Draw the image of a run, with axes in pixels."""
    axes.imshow(image, **GREY)
    axes.grid(False)
    axes.set(xlabel="u (px)", ylabel="v (px)")


def mark(axes, point, text, offset, colour="white"):
    """Label a point, with an arrow."""
    axes.annotate(
        text,
        point,
        xytext=offset,
        textcoords="offset points",
        color="black",
        fontsize=9.5,
        bbox={"boxstyle": "round,pad=0.15", "fc": colour, "alpha": 0.9},
        arrowprops={"arrowstyle": "-", "color": colour, "linewidth": 1.0},
    )


def draw_window(axes, run, index, band):
    """Draw a window: image, circle, edge pixels, chosen line with its band."""
    import matplotlib.patches as patches

    centre, radius, line, anchor = run.step(index)
    draw_image(axes, run.image)
    axes.add_patch(
        patches.Circle(centre, radius, fill=False, color=YELLOW, linewidth=2)
    )
    axes.plot(
        *run.of_step("edges", index).T,
        "s",
        color=BLUE,
        markersize=2.4,
        linestyle="none",
        label="edge pixels $S_c$",
    )
    ends = line_ends(centre, radius, line)
    axes.plot(*ends.T, "-", color=RED, linewidth=1.6, label="line $L_w$")
    for side in (-1, 1):
        shifted = line_ends(centre, radius, line + [side * band, 0])
        axes.plot(*shifted.T, ":", color=RED, linewidth=1.0)
    corners = run.of_step("corners", index)
    axes.plot(
        *corners.T,
        "x",
        color=PINK,
        markersize=9,
        markeredgewidth=2,
        linestyle="none",
        label="candidates $n_q$",
    )
    axes.plot(*centre, "o", color=YELLOW, markersize=6, linestyle="none")
    axes.plot(*anchor, "o", color=GREEN, markersize=6, linestyle="none")
    reach = VIEW_RADII * radius
    (u, v), across = centre, np.array([-reach, reach])
    axes.set(xlim=u + across, ylim=v - across)


def towards(axes, start, end, text, colour):
    """Draw a labelled dashed line from a corner towards another one."""
    axes.plot(*np.array([start, end]).T, "--", color=colour, linewidth=1.3)
    reach = np.linalg.norm(end - start)
    width = abs(np.diff(axes.get_xlim())[0])
    spot = start + (end - start) / reach * min(reach, 0.36 * width)
    axes.text(
        *spot,
        text,
        color="black",
        fontsize=9,
        ha="center",
        bbox={"boxstyle": "round,pad=0.12", "fc": colour, "alpha": 0.85},
    )


@figure("fig_3_1", needs=("fig_3_1_run", "fig_3_1_cameras"), evidence="rendered")
def fig_3_1(results):
    """The first window of a run, at the first corner."""
    run = Run(results["fig_3_1_run"])
    drawn, (whole, axes) = new_figure(1, 2, height_in=3.9)
    band = CelectSettings().edge_band * run.s[0]
    draw_window(axes, run, 0, band)
    corners = run.outer
    towards(axes, corners[0], corners[1], "$L_1$", GREEN)
    towards(axes, corners[0], corners[3], "$L_4$", PINK)
    mark(axes, run.step(0)[0], "$p_{cur} = c_1$", (-62, 26))
    mark(axes, run.step(0)[3], "$p_{new}$", (-44, 20))
    axes.legend(loc="lower left", fontsize=7.5)
    axes.set_title("Window at $c_1$")
    draw_image(whole, run.image)
    whole.plot(*corners[[0, 1, 2, 3, 0]].T, "--", color=GREEN, linewidth=1.3)
    for k, corner in enumerate(corners):
        mark(whole, corner, f"$c_{k + 1}$", (8, 8))
        middle = (corner + corners[(k + 1) % 4]) / 2
        whole.text(
            *middle,
            f"$L_{k + 1}$",
            fontsize=8.5,
            ha="center",
            va="center",
            bbox={"boxstyle": "round,pad=0.12", "fc": GREEN, "alpha": 0.85},
        )
    for contour in range(len(run.s)):
        whole.plot(
            *run.anchors(contour).T,
            ".-",
            color=YELLOW if contour < 4 else BLUE,
            linewidth=1,
            markersize=3,
        )
    whole.set_title("Corners, side lines, traces")
    numbers = ("u_px", "v_px", "radius_px", "R_px", "theta_deg")
    data = {
        "step": list(range(len(run.steps))),
        "contour": run.steps[:, 0].astype(int).tolist(),
        **dict(zip(numbers, run.steps[:, 1:6].T.tolist(), strict=True)),
    }
    return Drawing(
        drawn,
        data,
        "Quantities of CELECT in a run on a rendered fisheye image"
        f"{which_view(results['fig_3_1_run'])}. Left: "
        "corners $c_i$, side lines $L_i$, anchors on the four sides (yellow) and "
        "in the columns (blue). Right: the first window, of radius $r = s_1$, "
        "with edge pixels $S_c$, the line $L_w$ and its band $t_5$ (dotted), "
        "candidate corners $n_q$ and the next anchor $p_{new}$.",
        window_check(run),
    )


def window_check(run):
    """Check that every anchor is within its window and within t5 of its line."""
    settings, ratios = CelectSettings(), []
    for index in np.flatnonzero(run.steps[1:, 0] == run.steps[:-1, 0]):
        centre, radius, line, anchor = run.step(index)
        start, end = line_ends(centre, radius, line)
        along = (end - start) / np.linalg.norm(end - start)
        off = abs(np.cross(along, anchor - start))
        s = run.s[int(run.steps[index, 0])]
        band = max(settings.edge_band * s, settings.least_band_px)
        ratios += [off / band, np.linalg.norm(anchor - centre) / radius]
    return Check(
        max(ratios) <= 1 + 1e-9,
        f"all {len(run.steps)} anchors are in their window and within t5 of their line",
    )


@figure("fig_3_2", needs=("fig_3_1_run", "fig_3_1_cameras"), evidence="rendered")
def fig_3_2(results):
    """A later window: the line nearest in orientation to the previous one."""
    run = Run(results["fig_3_1_run"])
    settings = CelectSettings()
    index = turning_step(run)
    drawn, (axes, hough) = new_figure(1, 2, height_in=3.9, width_ratios=(1.25, 1))
    s = run.s[int(run.steps[index, 0])]
    draw_window(axes, run, index, settings.edge_band * s)
    centre, radius, line, anchor = run.step(index)
    previous, _, before, _ = run.step(index - 1)
    axes.plot(*previous, "o", color=RED, markersize=6, linestyle="none")
    angle = np.radians(before[1])
    along = np.array([np.cos(angle), np.sin(angle)])
    tip = centre + 1.25 * radius * (along * np.sign(along @ (centre - previous)))
    arrow = {"arrowstyle": "->", "color": GREEN, "linewidth": 1.6}
    axes.annotate("", tip, centre, arrowprops=arrow)
    mark(axes, tip, r"$\theta_{prev}$", (-44, 12))
    mark(axes, previous, "$p_{prev}$", (-40, 22))
    mark(axes, centre, "$p_{cur}$", (-8, 30))
    mark(axes, anchor, "$p_{new}$", (8, 24))
    axes.legend(loc="lower left", fontsize=7.5)
    axes.set_title("Window at $p_{cur}$")
    lines = run.of_step("lines", index)
    near = settings.near_centre * s
    hough.axhspan(-near, near, color=GREEN, alpha=0.15, label="$|R| < t_3$")
    hough.plot(
        lines[:, 1], lines[:, 0], "o", color=BLUE, linestyle="none", label="peaks $S_h$"
    )
    hough.plot(
        line[1],
        line[0],
        "o",
        color=RED,
        markersize=11,
        fillstyle="none",
        linestyle="none",
        label="chosen $h_p$",
    )
    hough.axvline(before[1], color=GREEN, linestyle="--", label=r"$\theta_{prev}$")
    hough.set(
        xlim=(0, 180),
        ylim=(-radius, radius),
        xlabel=r"Orientation $\theta$ (deg)",
        ylabel="Distance $R$ from the centre (px)",
        title="Lines in Hough space",
    )
    hough.legend(loc="upper right", fontsize=7.5)
    return Drawing(
        drawn,
        {
            "R_px": lines[:, 0].tolist(),
            "theta_deg": lines[:, 1].tolist(),
            "chosen": [bool(np.allclose(row, line)) for row in lines],
        },
        "A window away from the corners, in the same run. Left: quantities as in "
        "Fig. 3.1, with the previous anchor and orientation. Right: the lines of "
        "this window in Hough space. Of the lines with $|R| < t_3$, the one "
        "nearest in orientation to the previous line is chosen (3.11).",
        turn_check(run),
    )


def turn_check(run):
    """Check (3.11) at every step except the first of a contour."""
    least = []
    for index in 1 + np.flatnonzero(run.steps[1:, 0] == run.steps[:-1, 0]):
        lines, before = run.of_step("lines", index), run.steps[index - 1, 5]
        limit = CelectSettings().near_centre * run.s[int(run.steps[index, 0])]
        turns = angle_apart(lines[np.abs(lines[:, 0]) < limit, 1], before)
        least.append(angle_apart(run.steps[index, 5], before) <= turns.min() + 1e-9)
    return Check(
        all(least),
        f"the line nearest in orientation was chosen at all {len(least)} later steps",
    )


@figure("fig_3_4", needs=("fig_3_4_run",), evidence="rendered")
def fig_3_4(results):
    """Candidates and corners of a run on a mirror image."""
    run = Run(results["fig_3_4_run"])
    drawn, (traces, corners) = new_figure(1, 2, height_in=3.9)
    raw = np.unique(run.corners[:, 1:], axis=0)
    low, high = raw.min(axis=0) - 20, raw.max(axis=0) + 20
    for axes in (traces, corners):
        draw_image(axes, run.image)
        axes.set(xlim=(low[0], high[0]), ylim=(high[1], low[1]))
    for contour in range(len(run.s)):
        traces.plot(
            *run.anchors(contour).T, ".-", color=YELLOW, linewidth=1.0, markersize=3
        )
    traces.plot(*raw.T, "x", color=RED, markersize=4, linestyle="none")
    traces.set_title(f"Traces, {len(raw)} candidates")
    grid = run.grid.reshape(-1, 2)
    corners.plot(
        *grid.T, "o", color=RED, markersize=5, fillstyle="none", linestyle="none"
    )
    corners.set_title(f"{len(grid)} corners")
    order = {
        "row": np.repeat(np.arange(len(run.grid)), run.grid.shape[1]).tolist(),
        "column": np.tile(np.arange(run.grid.shape[1]), len(run.grid)).tolist(),
        "u_px": grid[:, 0].tolist(),
        "v_px": grid[:, 1].tolist(),
    }
    largest = float(results["fig_3_4_run"].column("max_px")[0])
    return Drawing(
        drawn,
        order,
        "CELECT on a rendered image of a hyperboloidal mirror"
        f"{which_view(results['fig_3_4_run'])}. Left: anchors and "
        "all candidate corners, several per corner. Right: corners after "
        "merging.",
        Check(
            len(raw) > len(grid) and largest <= 8,
            f"{len(raw)} candidates were merged into {len(grid)} corners, none "
            f"more than {largest:.1f} px from its true position",
        ),
    )
