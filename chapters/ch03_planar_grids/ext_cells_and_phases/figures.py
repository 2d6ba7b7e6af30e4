"""Errors against cells, against the response, and for a given number of pictures."""

import numpy as np
from matplotlib.ticker import FuncFormatter, LogLocator, NullLocator

from chapters.ch03_planar_grids.ext_cells_and_phases.results import (
    BY_PIXEL,
    SMOOTHED,
    WAYS,
    bias_px,
    decoded,
    grids,
    read_twice,
    rounding_px,
    sigma_px,
    smoothed_px,
    swept,
    width_of,
)
from chapters.ch03_planar_grids.ext_cells_and_phases.trials import (
    LINEAR,
    OUR_BLUR_PX,
    OUR_CELLS,
    OUR_NOISE,
    READINGS,
    name_of,
    period_px,
)
from repro.page.style import figure as new_figure
from repro.page.style import legend_below, series
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing, Measured

CURVE_POINTS = 120
HIGHEST_PX = 1.0
ENDS = ("median", "low", "high")


def _errorbar(axes, x, found, index, **more):
    """Markers with their intervals; `found` holds Measured or None."""
    kept = [(at, *_ends(one)) for at, one in zip(x, found, strict=True) if one]
    if not kept:
        return
    at, middle, low, high = np.array(kept).T
    look = dict(series(index), linestyle="none")
    bars = [middle - low, high - middle]
    axes.errorbar(at, middle, yerr=bars, capsize=3, **look, **more)


def _ends(one):
    """(median, low, high) of Measured; nan for None."""
    return (one.value, one.low, one.high) if one else (np.nan,) * 3


def _curve(axes, x, line, index):
    """The theory of a series."""
    axes.plot(x, line, **dict(series(index), marker="", linewidth=1))


def _plain_numbers(axis):
    """Labels 0.02 instead of powers of ten."""
    for place in (axis.set_major_formatter, axis.set_minor_formatter):
        place(FuncFormatter(lambda number, _: f"{number:g}"))


def _cells_axis(axes, ticks, whole):
    """Cells, and below each the width of one in px; `whole`: that of the monitor."""
    axes.set_xscale("log", base=2)
    axes.set_xticks(ticks, [f"{n}\n{whole / n:.0f}" for n in ticks])
    axes.xaxis.set_minor_locator(NullLocator())
    axes.set(xlabel="Cells (1), and their width in the picture (px)")


@figure("ext_cells", needs=("ext_cells_runs",), evidence="rendered")
def ext_cells(results):
    """RMS error against cells, by blur, smoothed and by pixel, with the theory."""
    result = results["ext_cells_runs"]
    width, blurs = width_of(result), swept(result, "blurs_px")
    ticks = [cells for cells, _ in grids(result)]
    names = ("way", "blur_px", "cells", "period_px", *ENDS, "theory")
    drawn, panels = new_figure(1, 2, height_in=4.4, sharey=True)
    curve = np.geomspace(ticks[0], ticks[-1], CURVE_POINTS)
    rows, off = [], []
    for axes, way in zip(panels, WAYS, strict=True):
        for index, blur in enumerate(blurs):
            found = []
            of_grid = decoded(result, name_of(LINEAR, blur, OUR_NOISE), way)
            for (cells, steps), one in of_grid.items():
                found.append(one.measured("rms_px") if one.readable else None)
                period, ends = period_px(cells, width), _ends(found[-1])
                theory = float(sigma_px(period, blur, OUR_NOISE, steps, way))
                rows.append((way, blur, cells, period, *ends, theory))
                off.append(abs(ends[0] / theory - 1))
            periods = period_px(1, width) / curve
            _curve(axes, curve, sigma_px(periods, blur, OUR_NOISE, steps, way), index)
            _errorbar(axes, ticks, found, index, label=f"blur {blur:g} px")
        axes.set(title="7 × 7 smoothing" if way == SMOOTHED else way, yscale="log")
        _cells_axis(axes, ticks, period_px(1, width))
    panels[0].set(ylabel="RMS error of a coordinate (px)", ylim=(None, HIGHEST_PX))
    _plain_numbers(panels[0].yaxis)
    panels[0].yaxis.set_minor_locator(LogLocator(subs=(2, 5)))
    half = float(np.nanmedian(off))
    legend_below(drawn, panels[1], ncols=4)
    return Drawing(
        drawn,
        columns(names, rows),
        "Error of a decoded coordinate against the number of cells, with "
        f"noise of SD {OUR_NOISE:g} grey levels and four steps. Markers: "
        "median over the views, bars its 95 % interval; only where at least "
        "99 % of the pixels are decoded, and none into a wrong cell. Lines: "
        "the theory of this page, with nothing fitted.",
        Check(
            half < 0.1,
            f"half of the markers are within {100 * half:.1f} % of the theory",
        ),
    )


@figure("ext_steps", needs=("ext_steps_runs",), evidence="rendered")
def ext_steps(results):
    """RMS error that the monitor's response makes, by the number of steps."""
    result = results["ext_steps_runs"]
    period = period_px(OUR_CELLS, width_of(result))
    gammas = swept(result, "gammas")
    curve = np.linspace(gammas[0], gammas[-1], CURVE_POINTS)
    names, rows = ("steps", "gamma", *ENDS, "theory"), []
    drawn, axes = new_figure(height_in=4.2)
    of_gamma = [
        decoded(result, name_of(gamma, OUR_BLUR_PX, 0.0), BY_PIXEL) for gamma in gammas
    ]
    for index, (cells, steps) in enumerate(grids(result)):
        found = [of_grid[cells, steps].measured("rms_px") for of_grid in of_gamma]
        rows += [
            (steps, gamma, *_ends(one), _theory(period, gamma, steps))
            for gamma, one in zip(gammas, found, strict=True)
        ]
        _curve(axes, curve, [_theory(period, g, steps) for g in curve], index)
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
    axes.set(
        yscale="log",
        xlabel="Gamma of the monitor (1)",
        ylabel="RMS error of a coordinate (px)",
    )
    drawn.legend(loc="outside lower center", ncols=5)
    return Drawing(
        drawn,
        columns(names, rows),
        "What a response that is not linear leaves without any noise, with "
        f"{OUR_CELLS} cells ({period:.0f} px each) and no smoothing. Lines: "
        "the theory, with the rounding to whole grey levels added as noise. "
        "Markers with 3 steps lie above the line where the error leads some "
        "pixels into a wrong cell.",
    )


def _theory(period, gamma, steps):
    """RMS error that response and rounding make, px."""
    bias = bias_px(period, OUR_BLUR_PX, gamma, steps)
    return float(np.hypot(bias, rounding_px(period, OUR_BLUR_PX, steps)))


SHOWN = {"seen": "not corrected", "corrected": "corrected"}
NORMAL = 68.3  # %, of normal errors within one standard deviation
APART = 0.03  # of gamma, between series that would hide each other
AGREE = 0.15


@figure("ext_steps_corrected", needs=("ext_corrected_runs",), evidence="rendered")
def ext_steps_corrected(results):
    """Errors and stated SD behind a gamma, left as it is and undone."""
    result = results["ext_corrected_runs"]
    period, gammas = period_px(OUR_CELLS, width_of(result)), swept(result, "gammas")
    curve = np.linspace(gammas[0], gammas[-1], CURVE_POINTS)
    names = ("steps", "reading", "gamma", *ENDS, "theory")
    names += tuple(f"within, {end} (%)" for end in ENDS)
    drawn, (errors, shares) = new_figure(1, 2, height_in=4.2)
    rows, off = [], []
    for index, (steps, reading, of_gamma) in enumerate(read_twice(result)):
        smoothed = [ways[SMOOTHED] for ways in of_gamma.values()]
        rms = [one.measured("rms_px") for one in smoothed]
        within = [_percent(one.measured("within")) for one in smoothed]
        theory = [smoothed_px(period, gamma, steps, reading) for gamma in gammas]
        for gamma, error, one, share in zip(gammas, rms, theory, within, strict=True):
            rows.append((steps, reading, gamma, *_ends(error), one, *_ends(share)))
            off.append(abs(error.value / one - 1))
        line = [smoothed_px(period, gamma, steps, reading) for gamma in curve]
        _curve(errors, curve, line, index)
        at = np.add(gammas, 0 if READINGS[reading] else APART)
        label = f"{steps} steps, {SHOWN[reading]}"
        _errorbar(errors, at, rms, index, label=label)
        _errorbar(shares, at, within, index)
    shares.axhline(NORMAL, color="#4a4a4a", ls=":", lw=1.2)
    for axes in (errors, shares):
        axes.set(xlabel="Gamma of the monitor (1)", ylim=(0, None))
    errors.set_ylabel("RMS error of a coordinate (px)")
    shares.set_ylabel("Errors within one stated SD (%)")
    legend_below(drawn, errors, ncols=2)
    return Drawing(
        drawn,
        columns(names, rows),
        "What the response does to places is undone: the same pictures, decoded "
        "as the thesis does and corrected, by gamma, with the 7 × 7 smoothing, "
        f"noise of SD {OUR_NOISE:g} grey levels and {OUR_CELLS} cells of "
        f"{period:.0f} px. Left: error; lines are the theory, that of noise "
        "alone for what is corrected. Right: how many errors the stated SD "
        f"covers, {NORMAL:g} % if they are normal (dotted). Medians over the "
        "views with 95 % intervals; those of corrected places stand a little aside.",
        Check(
            max(off) < AGREE,
            f"every error is within {100 * max(off):.0f} % of the theory",
        ),
    )


def _percent(one):
    """Measured in %; None for None."""
    return one and Measured(*(100 * end for end in _ends(one)))
