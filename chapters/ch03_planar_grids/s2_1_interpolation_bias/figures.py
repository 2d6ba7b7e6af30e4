"""Figs. 3.6 and 3.7, and the errors at a ridge of two mirrors."""

import numpy as np

from chapters.ch03_planar_grids.s2_1_interpolation_bias.results import (
    MAGNIFIED,
    READINGS,
    formula_mm,
    of_other_corners,
    swept,
    trials_of_vectors,
)
from chapters.ch03_planar_grids.s2_1_interpolation_bias.trials.scenes import SIDE_MM
from repro.judge.statistics import median_interval
from repro.page.method_looks import look_of
from repro.page.style import figure as new_figure
from repro.page.style import plot_interval, series
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

SHOWN_MM = (1e-2, 1e3)
INK = "#1b1f24"
RIDGE_NAMES = {
    "unknown": "interpolation, ridge unknown",
    "7 x 7": "decoding, 7 × 7 filter",
    "none": "decoding, no filter",
}


@figure("fig_3_6", needs=("fig_3_6_vectors",), evidence="synthetic")
def fig_3_6(results):
    """Error vectors of 500 points, for both choices of corners."""
    result = results["fig_3_6_vectors"]
    pitch = result.conditions[0]["pitch_mm"]
    drawn, axes = new_figure(1, 2, height_in=3.9, sharex=True, sharey=True)
    ticks = np.arange(0, SIDE_MM + 1, 60)
    rows, asked = [], len(result.arrays("points")[0])
    for panel, reading, letter in zip(axes, READINGS, "ab", strict=True):
        points, errors = trials_of_vectors(result, reading)[0]
        rows += [(reading, *p, *e) for p, e in zip(points, errors, strict=True)]
        _arrows(panel, points, errors, series(0)["color"])
        panel.set(
            title=f"({letter}) {reading}",
            aspect="equal",
            xlabel="x (mm)",
            xticks=ticks,
            yticks=ticks,
        )
    _arrows(axes[0], *of_other_corners(result), series(1)["color"])
    axes[0].invert_yaxis()
    axes[0].set_ylabel("y (mm)")
    shown = [sum(row[0] == reading for row in rows) for reading in READINGS]
    names = ("corners", "x_mm", "y_mm", "error_x_mm", "error_y_mm")
    return Drawing(
        drawn,
        columns(names, rows),
        f"Interpolation errors of {asked} random points on a grid with a pitch of "
        f"{pitch} mm. Vectors point from the true (dot) to the interpolated point, "
        f"magnified {MAGNIFIED} times, with y downwards as in images. (a) The four "
        "nearest corners, no three collinear on the grid, as in the thesis. "
        "Orange: these are not the corners of the enclosing square. (b) The "
        "corners of the enclosing square.",
        Check(
            shown[0] == asked and 0.95 * asked <= shown[1] <= asked,
            f"{shown[0]} and {shown[1]} of {asked} points are drawn; outside "
            "the outermost corners a point can be in no square of the image",
        ),
    )


def _arrows(panel, points, errors, colour):
    """Draw points (n, 2) and their errors (n, 2), magnified."""
    ends = points + MAGNIFIED * errors
    lines = np.stack([points, ends, np.full_like(ends, np.nan)], 1)
    panel.plot(*lines.reshape(-1, 2).T, "-", color=colour, lw=0.9)
    panel.plot(*points.T, ".", color=colour, ms=2.5)


@figure("fig_3_7", needs=("fig_3_7_pitches",), evidence="synthetic")
def fig_3_7(results):
    """RMS over the pitch for both choices of corners, and the formula."""
    result = results["fig_3_7_pitches"]
    drawn, axes = new_figure(1, 2, height_in=3.3)
    rows = []
    for k, reading in enumerate(READINGS):
        pitch, errors = swept(result, reading)
        found = np.array([median_interval(trials)[:3] for trials in errors])
        for panel in axes:
            plot_interval(panel, pitch, *found.T, look=series(k), label=reading)
        rows += [(reading, p, *ends) for p, ends in zip(pitch, found, strict=True)]
    fine = np.linspace(pitch[0], pitch[-1], 60)
    for panel in axes:
        panel.plot(fine, formula_mm(fine), ":", color=INK, label="formula")
        panel.set(xlabel="Grid pitch (mm)", ylabel="RMS error (mm)")
    axes[0].legend()
    axes[0].set(title="Linear axes")
    axes[1].set(xscale="log", yscale="log", title="Logarithmic axes")
    shown = [p for p in pitch if p in (5, 10, 20, 30, 60)]
    axes[1].set_xticks(shown, [f"{p:g}" for p in shown])
    axes[1].minorticks_off()
    names = ("corners", "pitch_mm", "rms_mm", "low", "high")
    return Drawing(
        drawn,
        columns(names, rows),
        "RMS error of interpolated points over the pitch of the grid: medians of "
        f"{result.trials_per_condition} trials with 500 points each. Bands: 95 % "
        "intervals, hardly wider than the lines. Dotted: second-order formula of "
        "the Model, with $k_1$ alone.",
    )


@figure("ext_two_facets", needs=("exp_c3_interp_discontinuous",), evidence="rendered")
def ext_two_facets(results):
    """RMS error over the distance from the ridge."""
    result = results["exp_c3_interp_discontinuous"]
    drawn, axes = new_figure(height_in=3.2)
    rows, places = [], result.arrays("from_ridge_px")
    for name, label in RIDGE_NAMES.items():
        place, size = _over_trials(places, result.arrays(f"{name}.by_column_mm"))
        # Rounding errors would be drawn as a line down to the axis.
        drawn_size = np.where(size < SHOWN_MM[0], np.nan, size)
        masked = np.flatnonzero(np.diff(place) > 1) + 1
        gaps = (np.insert(a, masked, np.nan) for a in (place, drawn_size))
        look = series(0) if name == "unknown" else look_of(label)
        axes.semilogy(*gaps, label=label, **look)
        rows += [(label, *row) for row in zip(place, size, strict=True)]
    axes.set(
        xlabel="Distance from the ridge (px)", ylabel="RMS error (mm)", ylim=SHOWN_MM
    )
    axes.legend(loc="lower center", bbox_to_anchor=(0.5, 1.0), ncols=3)
    return Drawing(
        drawn,
        columns(("method", "from_ridge_px", "rms_mm"), rows),
        "RMS error over the distance from the ridge of two mirrors, for "
        "interpolation and decoding. RMS over the trusted pixels of a column, "
        f"medians of {result.trials_per_condition} trials. Interpolation fails "
        "where corners of the other mirror are among the nearest four, decoding "
        "only where blur or its filter mixes both sides. Where the blue curve "
        "ends, all corners belong to the pixel's own mirror and the error is "
        "rounding.",
    )


def _over_trials(places, sizes):
    """Positions (n,) and the median (n,) over trials at each of them."""
    place, size = np.concatenate(places), np.concatenate(sizes)
    each = np.unique(place)
    return each, np.array([np.median(size[place == p]) for p in each])
