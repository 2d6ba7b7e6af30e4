"""Errors against cells, against the response, and for a given number of pictures."""

from __future__ import annotations

import numpy as np
from matplotlib.ticker import (
    FixedFormatter,
    FixedLocator,
    FuncFormatter,
    LogLocator,
    NullLocator,
)

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
    LINEAR,
    OUR_BLUR_PX,
    OUR_CELLS,
    OUR_NOISE,
    name_of,
    period_px,
)
from repro.page.style import figure as new_figure
from repro.page.style import series
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

CURVE_POINTS = 120
HIGHEST_PX = 1.0
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


def _curve(axes, x, line, index):
    """The theory of a series."""
    axes.plot(x, line, **dict(series(index), marker="", linewidth=1))


def _plain_numbers(axis):
    """Labels 0.02 instead of powers of ten."""
    for place in (axis.set_major_formatter, axis.set_minor_formatter):
        place(FuncFormatter(lambda number, _: f"{number:g}"))


def _note(data, *cells):
    for column, cell in zip(data, cells, strict=True):
        data[column].append(cell)


def _cells_axis(axes, ticks, whole):
    """Cells, and below each the width of one in px; `whole`: that of the monitor."""
    axes.set_xscale("log", base=2)
    axes.xaxis.set_major_locator(FixedLocator(ticks))
    axes.xaxis.set_major_formatter(
        FixedFormatter([f"{n}\n{whole / n:.0f}" for n in ticks])
    )
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set_xlabel("Cells (1), and their width in the picture (px)")


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
                theory = float(sigma_px(period, blur, OUR_NOISE, steps, way))
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
            _curve(axes, curve, line, index)
            _errorbar(axes, ticks, found, index, label=f"blur {blur:g} px")
        axes.set_title("7 × 7 smoothing" if way == SMOOTHED else way)
        axes.set_yscale("log")
        _cells_axis(axes, ticks, period_px(1, width))
    panels[0].set_ylabel("RMS error of a coordinate (px)")
    panels[0].set_ylim(top=HIGHEST_PX)
    _plain_numbers(panels[0].yaxis)
    panels[0].yaxis.set_minor_locator(LogLocator(subs=(2, 5)))
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
            theory = np.hypot(bias_px(period, OUR_BLUR_PX, gamma, steps), floor)
            ends = [one.value, one.low, one.high]
            _note(data, steps, gamma, *ends, float(theory))
        line = [np.hypot(bias_px(period, OUR_BLUR_PX, g, steps), floor) for g in curve]
        _curve(axes, curve, line, index)
        _errorbar(axes, gammas, found, index, label=f"{steps} steps")
    noise = float(sigma_px(period, OUR_BLUR_PX, OUR_NOISE, 4))
    axes.axhline(noise, color="#4a4a4a", ls=":", lw=1.2)
    axes.annotate(
        f"noise of {OUR_NOISE:g} grey levels, 4 steps",
        (1.7, noise),
        ha="center",
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
