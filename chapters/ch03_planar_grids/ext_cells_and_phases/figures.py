"""Errors against cells, against the response, and for a given number of pictures."""

from __future__ import annotations

import numpy as np
from matplotlib.ticker import FixedFormatter, FixedLocator, NullLocator

from chapters.ch03_planar_grids.ext_cells_and_phases.results import (
    BY_PIXEL,
    SMOOTHED,
    bias_px,
    grid_of,
    grids,
    is_readable,
    measured,
    rounding_px,
    sigma_px,
    swept,
    width_of,
)
from chapters.ch03_planar_grids.ext_cells_and_phases.trials import (
    BUDGETS,
    LINEAR,
    ORDINARY,
    OUR_BLUR_PX,
    OUR_CELLS,
    OUR_NOISE,
    name_of,
    period_px,
    pictures_of,
)
from repro.page.style import figure as new_figure
from repro.page.style import series
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

CURVE_POINTS = 120
HIGHEST_PX = 2.0
ENDS = ("median", "low", "high")


def _errorbar(axes, x, found, index, **more):
    """Markers with their intervals; `found` holds Measured or None."""
    kept = [(at, one) for at, one in zip(x, found, strict=True) if one]
    if not kept:
        return
    at, ones = zip(*kept, strict=True)
    middle, low, high = (
        np.array([getattr(one, end) for one in ones])
        for end in ("value", "low", "high")
    )
    look = dict(series(index), linestyle="none")
    bars = [middle - low, high - middle]
    axes.errorbar(at, middle, yerr=bars, capsize=3, **look, **more)


def _note(data, *cells):
    for column, cell in zip(data, cells, strict=True):
        data[column].append(cell)


def _cells_axis(axes, ticks):
    axes.set_xscale("log", base=2)
    axes.xaxis.set_major_locator(FixedLocator(ticks))
    axes.xaxis.set_major_formatter(FixedFormatter([str(n) for n in ticks]))
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xlabel("Cells across the monitor (1)")


@figure("ext_cells", needs=("ext_cells_runs",), evidence="rendered")
def ext_cells(results):
    """RMS error against cells, by blur, smoothed and by pixel, with the theory."""
    result = results["ext_cells_runs"]
    width, blurs = width_of(result), swept(result, "blurs_px")
    ticks = [cells for cells, _ in grids(result)]
    names = ("way", "blur_px", "cells", "period_px", *ENDS, "theory")
    data = {name: [] for name in names}
    drawn, panels = new_figure(1, 2, height_in=4.4, sharey=True)
    curve = np.geomspace(ticks[0], ticks[-1], CURVE_POINTS)
    off = []
    for axes, way in zip(panels, (SMOOTHED, BY_PIXEL), strict=True):
        for index, blur in enumerate(blurs):
            name, found = name_of(LINEAR, blur, OUR_NOISE), []
            for cells, steps in grids(result):
                grid = grid_of(cells, steps)
                good = is_readable(result, name, way, grid)
                one = measured(result, name, f"{way}.rms_px", grid)
                found.append(one if good else None)
                period = period_px(cells, width)
                theory = float(
                    sigma_px(period, blur, OUR_NOISE, steps, way)
                )
                ends = (
                    [found[-1].value, found[-1].low, found[-1].high]
                    if found[-1]
                    else [np.nan] * 3
                )
                _note(data, way, blur, cells, period, *ends, theory)
                if found[-1]:
                    off.append(abs(found[-1].value / theory - 1))
            periods = period_px(1, width) / curve
            line = sigma_px(periods, blur, OUR_NOISE, grid["steps"], way)
            axes.plot(
                curve, line, color=series(index)["color"], lw=1, alpha=0.8
            )
            _errorbar(axes, ticks, found, index, label=f"blur {blur:g} px")
        axes.set_title("7 × 7 smoothing" if way == SMOOTHED else way)
        axes.set_yscale("log")
        _cells_axis(axes, ticks)
    panels[0].set_ylabel("RMS error of a coordinate (px)")
    panels[0].set_ylim(top=HIGHEST_PX)
    handles, labels = panels[1].get_legend_handles_labels()
    drawn.legend(handles, labels, loc="outside lower center", ncols=4)
    return Drawing(
        drawn,
        data,
        "Error of a decoded coordinate against the number of cells, with "
        f"noise of SD {OUR_NOISE:g} grey levels and four steps. Markers: "
        "median over the views, bars its 95 % interval; only where at least "
        "99 % of the pixels are decoded, and none into a wrong cell. Lines: "
        "the theory of this page, with nothing fitted.",
        Check(
            float(np.median(off)) < 0.1,
            f"half of the markers are within {100 * np.median(off):.1f} % of "
            "the theory",
        ),
    )


@figure("ext_steps", needs=("ext_steps_runs",), evidence="rendered")
def ext_steps(results):
    """RMS error that the monitor's response makes, by the number of steps."""
    result = results["ext_steps_runs"]
    period = period_px(OUR_CELLS, width_of(result))
    gammas = swept(result, "gammas")
    curve = np.linspace(gammas[0], gammas[-1], CURVE_POINTS)
    names = ("steps", "gamma", *ENDS, "theory")
    data = {name: [] for name in names}
    drawn, axes = new_figure(height_in=4.2)
    for index, (cells, steps) in enumerate(grids(result)):
        grid, found = grid_of(cells, steps), []
        floor = rounding_px(period, OUR_BLUR_PX, steps)
        for gamma in gammas:
            name = name_of(gamma, OUR_BLUR_PX, 0.0)
            one = measured(result, name, f"{BY_PIXEL}.rms_px", grid)
            found.append(one)
            theory = np.hypot(
                bias_px(period, OUR_BLUR_PX, gamma, steps), floor
            )
            ends = [one.value, one.low, one.high]
            _note(data, steps, gamma, *ends, float(theory))
        line = [
            np.hypot(bias_px(period, OUR_BLUR_PX, g, steps), floor)
            for g in curve
        ]
        axes.plot(curve, line, color=series(index)["color"], lw=1)
        _errorbar(axes, gammas, found, index, label=f"{steps} steps")
    noise = float(sigma_px(period, OUR_BLUR_PX, OUR_NOISE, 4))
    axes.axhline(noise, color="#4a4a4a", ls=":", lw=1.2)
    axes.annotate(
        f"noise of {OUR_NOISE:g} grey levels, 4 steps",
        (curve[-1], noise),
        ha="right",
        va="bottom",
        fontsize=9,
    )
    axes.set_yscale("log")
    axes.set_xlabel("Gamma of the monitor (1)")
    axes.set_ylabel("RMS error of a coordinate (px)")
    drawn.legend(loc="outside lower center", ncols=5)
    return Drawing(
        drawn,
        data,
        "What a response that is not linear leaves without any noise, with "
        f"{OUR_CELLS} cells ({period:.0f} px each) and no smoothing. Lines: "
        "the theory, with the rounding to whole grey levels added as noise. "
        "Markers with 3 steps lie above the line where the error leads some "
        "pixels into a wrong cell.",
    )


@figure(
    "ext_equal_pictures", needs=("ext_pictures_runs",), evidence="rendered"
)
def ext_equal_pictures(results):
    """Errors of grids that take the same number of pictures."""
    result = results["ext_pictures_runs"]
    ordered = [
        (total, grid) for total in BUDGETS for grid in BUDGETS[total]
    ]
    places = np.arange(len(ordered)) + np.repeat(
        np.arange(len(BUDGETS)), [len(BUDGETS[n]) for n in BUDGETS]
    )
    names = ("pictures", "cells", "steps", "way", "blur_px", *ENDS)
    data = {name: [] for name in names}
    drawn, panels = new_figure(1, 2, height_in=4.2, sharey=True)
    for axes, way in zip(panels, (SMOOTHED, BY_PIXEL), strict=True):
        for index, blur in enumerate(swept(result, "blurs_px")):
            name, found = name_of(ORDINARY, blur, OUR_NOISE), []
            for total, (cells, steps) in ordered:
                grid = grid_of(cells, steps)
                good = is_readable(result, name, way, grid)
                one = measured(result, name, f"{way}.rms_px", grid)
                one = one if good else None
                found.append(one)
                ends = (
                    [one.value, one.low, one.high] if one else [np.nan] * 3
                )
                _note(data, total, cells, steps, way, blur, *ends)
            shift = 0.16 * (index - 1)
            label = f"blur {blur:g} px"
            _errorbar(axes, places + shift, found, index, label=label)
        axes.set_yscale("log")
        axes.set_title("7 × 7 smoothing" if way == SMOOTHED else way)
        axes.set_xticks(places)
        labels = [
            f"{cells} cells\n{steps} st." for _, (cells, steps) in ordered
        ]
        axes.xaxis.set_major_formatter(FixedFormatter(labels))
        axes.tick_params(axis="x", labelsize=7.5)
        first = len(BUDGETS[min(BUDGETS)])
        axes.axvline(first, color="#4a4a4a", lw=1)
    panels[0].set_ylabel("RMS error of a coordinate (px)")
    handles, labels = panels[1].get_legend_handles_labels()
    drawn.legend(handles, labels, loc="outside lower center", ncols=3)
    same = all(pictures_of(*grid) == total for total, grid in ordered)
    few, many = sorted(BUDGETS)
    return Drawing(
        drawn,
        data,
        f"Grids that take {few} pictures (left of the line) and {many} "
        "(right), for both axes with all inverses: finer cells against more "
        f"steps. Monitor of gamma {ORDINARY:g}, noise of SD {OUR_NOISE:g} "
        "grey levels. No marker: fewer than 99 % of the pixels are decoded, "
        "or some into a wrong cell.",
        Check(same, "the pictures of every grid add up"),
    )
