"""The figures of section 3.3.1."""

from __future__ import annotations

import numpy as np

from chapters.ch03_planar_grids.s3_1_robustness.results import (
    SWEEPS,
    experiment_of,
    levels_of,
    successes,
)
from chapters.shared.localiser_basin import (
    HALF_WINDOWS,
    LOCALISED_PX,
    largest_by_start,
    starts_of,
)
from chapters.shared.synthetic_board import SIZE_PX, SyntheticBoard
from repro.page.style import figure as new_figure
from repro.page.style import plot_interval, series
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing
from repro.run.results import summary

SHARE = "#d5d9de"
LABELS = {
    "noise": "Noise SD (grey levels)",
    "blur": "Blur SD (px)",
    "square": "Square before bending (px)",
    "fov": "Field of view (deg)",
    "yaw": "Yaw (deg)",
}
TITLES = {
    "noise": "(a) noise",
    "blur": "(b) blur",
    "square": "(c) size of the squares",
    "fov": "(d) fisheye distortion",
    "yaw": "(e) perspective",
}


@figure("fig_3_10", needs=("fig_3_10_pictures",), evidence="rendered")
def fig_3_10(results):
    """The board before and after bending, with its corners."""
    result = results["fig_3_10_pictures"]
    drawn, panels = new_figure(1, 2, height_in=3.9)
    data = {"panel": [], "corner": [], "u_px": [], "v_px": []}
    for panel, shape, title in zip(
        panels,
        ("flat", "bent"),
        ("(a) before bending", "(b) FOV 134°"),
        strict=True,
    ):
        (picture,) = result.arrays("picture", shape=shape)
        (corners,) = result.arrays("corners", shape=shape)
        panel.imshow(picture, cmap="gray", vmin=0, vmax=255)
        panel.plot(*corners.T, "o", color="#d55e00", ms=2.5)
        panel.grid(visible=False)
        panel.set_title(title)
        panel.set_xlabel("u (px)")
        for index, (u, v) in enumerate(corners):
            for column, cell in zip(
                data, (shape, index, u, v), strict=True
            ):
                data[column].append(cell)
    for panel in panels:
        panel.set_ylabel("v (px)")
    board = SyntheticBoard()
    flat, bent = (
        result.arrays("corners", shape=s)[0] for s in ("flat", "bent")
    )
    middle = (SIZE_PX - 1) / 2
    before, after = (
        np.linalg.norm(c - middle, axis=1) for c in (flat, bent)
    )
    law = (
        2 * board.focal_px * np.sin(np.arctan(before / board.focal_px) / 2)
    )
    worst = float(np.abs(after - law).max())
    return Drawing(
        drawn,
        data,
        "Synthetic chessboard (a) before bending and (b) seen by an "
        "equisolid fisheye with 134° on the diagonal. Dots: the corners "
        "to be found.",
        check=Check(
            worst < 1e-6,
            "radii of all corners follow r = 2 f sin(atan(R/f)/2) to "
            f"{worst:.0e} px",
        ),
    )


@figure(
    "fig_3_11",
    needs=(
        "fig_3_11_noise",
        "fig_3_11_blur",
        "fig_3_11_square",
        "fig_3_11_fov",
        "fig_3_11_yaw",
        "fig_3_11_localised",
    ),
    evidence="rendered",
)
def fig_3_11(results):
    """Errors and successes along five sweeps, and the localiser's basin."""
    drawn, panels = new_figure(3, 2, height_in=9.2)
    data = {
        name: []
        for name in (
            "panel",
            "x",
            "largest",
            "mean",
            "low",
            "high",
            "right",
        )
    }
    for panel, sweep in zip(panels.flat, SWEEPS, strict=False):
        _draw_sweep(panel, results[experiment_of(sweep)], sweep, data)
    _draw_basin(panels[2, 1], results["fig_3_11_localised"], data)
    handles, labels = panels[0, 0].get_legend_handles_labels()
    drawn.legend(handles, labels, loc="outside lower center", ncols=3)
    return Drawing(
        drawn,
        data,
        "CELECT on the synthetic board, before localisation: error of the "
        "successful trials (left axes: the largest error of any corner, "
        "and the median over trials of the mean error, with its 95 % "
        "interval) and share of successful trials (grey, right axes), for "
        "(a) noise, (b) blur, (c) square size, (d) field of view and (e) "
        "yaw. (f) Error after localisation against the error of the start.",
    )


def _draw_sweep(panel, result, sweep, data):
    name = SWEEPS[sweep]
    levels = levels_of(result, name, levels="full range")
    x = SIZE_PX / levels if sweep == "square" else levels.astype(float)
    rows = [_row(result, {name: v, "levels": "full range"}) for v in levels]
    largest, mean, low, high, right = np.array(rows).T
    shares = panel.twinx()
    shares.fill_between(x, 100 * right, color=SHARE, linewidth=0)
    shares.plot(x, 100 * right, ".", color="#8d949c")
    shares.grid(visible=False)
    shares.set_ylim(0, 105)
    shares.set_ylabel("Successful (%)")
    panel.set_zorder(shares.get_zorder() + 1)
    panel.patch.set_visible(False)
    look = series(1)
    panel.plot(x, largest, label="largest error", **look)
    plot_interval(panel, x, mean, low, high, index=0, label="mean error")
    panel.fill_between([], [], color=SHARE, label="successful trials")
    panel.set_ylim(bottom=0)
    panel.set_title(TITLES[sweep])
    panel.set_xlabel(LABELS[sweep])
    panel.set_ylabel("Error (px)")
    for cells in zip(x, *np.array(rows).T, strict=True):
        for column, cell in zip(data, (sweep, *cells), strict=True):
            data[column].append(cell)


def _draw_basin(panel, result, data):
    """Largest error over corners and trials after OpenCV's localisation."""
    starts = starts_of(result)
    for index, (window, half) in enumerate(HALF_WINDOWS.items()):
        worst = largest_by_start(result, window)
        side = 2 * half + 1
        panel.plot(
            starts,
            worst,
            label=f"largest error, {side} × {side} px",
            **series(2 + index),
        )
        for start, error in zip(starts, worst, strict=True):
            cells = (f"localised, {window}", start, error, *[np.nan] * 4)
            for column, cell in zip(data, cells, strict=True):
                data[column].append(cell)
    panel.axhline(LOCALISED_PX, color="#4a4a4a", linewidth=1, linestyle=":")
    panel.annotate(
        f"{LOCALISED_PX} px",
        (starts[-1], LOCALISED_PX),
        ha="right",
        va="bottom",
    )
    panel.set_yscale("log")
    panel.set_ylim(0.02, 200)
    panel.set_title("(f) after localisation")
    panel.set_xlabel("Error of the start (px)")
    panel.set_ylabel("Error (px)")
    panel.legend(loc="upper left")


def _row(result, condition):
    """(largest, median of means, low, high, share right) of one level."""
    largest = result.column("max_px", **condition)
    right = successes(result, **condition).mean()
    means = result.column("mean_px", **condition)
    means = means[np.isfinite(means)]
    if not len(means):
        return (np.nan,) * 4 + (right,)
    middle = summary(means)
    low, high = middle["median_interval"]
    return np.nanmax(largest), middle["median"], low, high, right
