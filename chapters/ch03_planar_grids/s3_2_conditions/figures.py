"""Fig. 3.14, and the conditions of section 3.3.2."""

import numpy as np
from matplotlib.ticker import FixedFormatter, FixedLocator

from chapters.ch03_planar_grids.s3_2_conditions.results import (
    CAMERAS,
    METHODS,
    WAYS,
    all_orders,
    in_light,
    levels_run,
    logistic_curve,
    merging_of,
    numbers_of,
)
from chapters.ch03_planar_grids.s3_2_conditions.trials.sheet_views import level_name
from chapters.shared.grid_detectors import CELECT, OPENCV
from repro.judge.statistics import proportion
from repro.page.method_looks import look_of
from repro.page.style import figure as new_figure
from repro.page.style import legend_below, plot_interval, series
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

MARGIN_PX = 30
RED, YELLOW, GREEN = "#e6201f", "#ffd60a", "#1fb25a"
BINS = 6
OFFSET = 1.06


@figure("fig_3_14", needs=("fig_3_14_parts",), evidence="rendered")
def fig_3_14(results):
    """Draw the parts that CELECT and OpenCV extract from one image per camera."""
    result = results["fig_3_14_parts"]
    drawn, panels = new_figure(2, 2, height_in=6.6)
    rows, inside = [], []
    for of_camera, camera in zip(panels, CAMERAS, strict=True):
        for panel, method in zip(of_camera, (CELECT, OPENCV), strict=True):
            found = result.arrays(f"{method}.corners", camera=camera)
            picture = result.arrays("picture", camera=camera)[0]
            lattice = result.arrays("lattice", camera=camera)[0]
            here = result.column(f"{method}.count", camera=camera)[0] > 0
            corners = found[0] if here else None
            _draw_part(panel, picture, lattice, corners)
            if here and method == OPENCV:
                _draw_paint(panel, result, camera)
            size = "none"
            if here:
                long, short = sorted(corners.shape[:2], reverse=True)
                size = f"{long} × {short}"
                inside.append(_shares_corners(corners, lattice))
                rows += [
                    (camera, METHODS[method], index, *corner)
                    for index, corner in enumerate(corners.reshape(-1, 2))
                ]
            letter = "ab"[CAMERAS.index(camera)]
            name = METHODS[method] if method == CELECT else "OpenCV"
            panel.set_title(f"({letter}) {camera}, {name}: {size}")
    return Drawing(
        drawn,
        columns(("panel", "method", "corner", "u_px", "v_px"), rows),
        "Extracted parts of large grids without a border. Left: the largest part "
        "that CELECT extracts from the unmodified image. Right: the largest part "
        "that OpenCV's findChessboardCorners returns when everything around it is "
        "painted white. Red: corners. Yellow and green: their order.",
        check=Check(
            bool(inside) and all(inside), "every drawn corner is a corner of the grid"
        ),
    )


def _draw_part(panel, picture, lattice, corners):
    low = lattice.reshape(-1, 2).min(axis=0) - MARGIN_PX
    high = lattice.reshape(-1, 2).max(axis=0) + MARGIN_PX
    panel.imshow(picture, cmap="gray", vmin=0, vmax=255)
    if corners is not None:
        panel.plot(*corners.transpose(2, 1, 0), "-", color=GREEN, lw=0.7, marker="")
        panel.plot(*corners.transpose(2, 0, 1), "-", color=YELLOW, lw=0.7, marker="")
        panel.plot(*corners.reshape(-1, 2).T, "o", color=RED, ms=1.8, linestyle="")
    panel.set(
        xlim=(max(low[0], -0.5), min(high[0], picture.shape[1] - 0.5)),
        ylim=(min(high[1], picture.shape[0] - 0.5), max(low[1], -0.5)),
        xlabel="u (px)",
        ylabel="v (px)",
    )
    panel.grid(visible=False)


def _draw_paint(panel, result, camera):
    """Draw the painted image over the original."""
    bordered = result.arrays(f"{OPENCV}.painted", camera=camera)[0]
    u, v = result.arrays(f"{OPENCV}.first", camera=camera)[0]
    height, width = bordered.shape
    extent = (u - 0.5, u + width - 0.5, v + height - 0.5, v - 0.5)
    limits = {"xlim": panel.get_xlim(), "ylim": panel.get_ylim()}
    panel.set_facecolor("white")
    panel.images[0].set_visible(False)
    panel.imshow(bordered, cmap="gray", vmin=0, vmax=255, extent=extent)
    panel.set(**limits)


def _shares_corners(corners, lattice):
    apart = np.abs(corners[:, :, None, None] - lattice).sum(axis=-1)
    return bool((apart.min(axis=(2, 3)) == 0).all())


@figure(
    "ext_conditions",
    needs=(
        "exp_c3_low_contrast",
        "exp_c3_shadow",
        "exp_c3_trace_direction",
        "exp_c3_merge_images",
    ),
    evidence="rendered",
)
def ext_conditions(results):
    """Draw success by light, shadow, click order and size variation."""
    drawn, panels = new_figure(2, 2, height_in=6.6)
    rows = []
    _draw_light(panels[0, 0], results["exp_c3_low_contrast"], rows)
    _draw_shadow(panels[0, 1], results["exp_c3_shadow"], rows)
    _draw_orders(panels[1, 0], results["exp_c3_trace_direction"], rows)
    _draw_merging(panels[1, 1], results, rows)
    legend_below(drawn, panels[0, 0], ncols=2)
    return Drawing(
        drawn,
        columns(("panel", "series", "x", "y", "low", "high"), rows),
        "Share of boards returned complete and in order, with 95 % intervals, whole "
        "range of poses. (a) Mirror ball, by light on the board. (b) Fisheye, "
        "without and with a soft shadow that takes 30 % of the light. (c) CELECT, "
        "with the first click on each outer corner, by size of its square, in both "
        "directions. (d) Share of fisheye images with a merge failure of CELECT, by "
        "the largest ratio of steps along one contour, in groups of equal size, "
        "with a logistic fit.",
    )


def _draw(panel, letter, x, trials, look, label, rows):
    """Draw shares of trials with their intervals, and add their data to rows."""
    shares = np.array([proportion(t)[:3] for t in trials])
    at = np.asarray(x, float)
    plot_interval(panel, at, *100 * shares.T, look=look, label=label, bars=True)
    rows += [(letter, label, x, *share) for x, share in zip(x, shares, strict=True)]


def _name_ticks(panel, places, names):
    panel.xaxis.set_major_locator(FixedLocator(places))
    panel.xaxis.set_major_formatter(FixedFormatter(names))


def _draw_light(panel, result, rows):
    levels = levels_run(result)
    for index, (method, label) in enumerate(METHODS.items()):
        trials = [in_light(result, v, method) for v in levels]
        # Offset from each other, so that every interval is visible.
        x = np.array(levels) * OFFSET ** (index - 2)
        _draw(panel, "a", x, trials, look_of(label), label, rows)
    grey = [
        np.median(numbers_of(result, f"{level_name(v)}.contrast_grey")) for v in levels
    ]
    for level, contrast in zip(levels, grey, strict=True):
        panel.annotate(f"{contrast:.0f}", (level, 104), ha="center", fontsize=7.5)
    panel.set_xscale("log")
    panel.set_xticks(levels, [f"{v:g}" for v in levels], rotation=45)
    panel.minorticks_off()
    panel.set(
        ylim=(-3, 112),
        title="(a) light (above: contrast, grey levels)",
        xlabel="Light on the board (share of full light)",
        ylabel="Success (%)",
    )


def _draw_shadow(panel, result, rows):
    for index, (method, label) in enumerate(METHODS.items()):
        trials = [
            numbers_of(result, f"{name}.{method}") for name in ("plain", "shadow")
        ]
        x = np.array([0, 1]) + 0.06 * (index - 2)
        _draw(panel, "b", x, trials, look_of(label), label, rows)
    _name_ticks(panel, [0, 1], ["no shadow", "shadow"])
    panel.set(
        xlim=(-0.4, 1.4), ylim=(-3, 103), title="(b) soft shadow", ylabel="Success (%)"
    )


def _draw_orders(panel, result, rows):
    orders = all_orders(result)
    for index, way in enumerate(WAYS):
        x = np.arange(1, 5) + 0.08 * (index - 0.5)
        label = "clockwise" if way == "clockwise" else "anticlockwise"
        _draw(panel, "c", x, orders[index], series(index + 5), label, rows)
    squares = ["smallest\nsquare", "second", "third", "largest\nsquare"]
    _name_ticks(panel, [1, 2, 3, 4], squares)
    panel.set(ylim=(0, 103), title="(c) first corner clicked", ylabel="Success (%)")
    panel.legend(loc="upper right")


def _draw_merging(panel, results, rows):
    ratio, failed, _ = merging_of(results)
    groups = np.array_split(np.argsort(ratio), min(BINS, len(ratio)))
    x = [float(np.median(ratio[g])) for g in groups]
    _draw(panel, "d", x, [failed[g] for g in groups], series(0), "merge failure", rows)
    along = np.linspace(ratio.min(), ratio.max(), 60)
    curve = logistic_curve(ratio, failed, along)
    look = series(1) | {"marker": ""}
    panel.plot(along, 100 * curve, label="logistic fit", **look)
    panel.set(
        ylim=(-3, 103),
        title="(d) size variation",
        xlabel="Longest step over shortest (ratio)",
        ylabel="Images with a merge failure (%)",
    )
    panel.legend(loc="lower right")
