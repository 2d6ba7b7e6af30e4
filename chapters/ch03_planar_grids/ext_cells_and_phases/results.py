"""What cells and steps do to an active grid: measured, and by the theory."""

from __future__ import annotations

import numpy as np

from chapters.ch03_planar_grids.ext_cells_and_phases.trials import (
    BLACK,
    BUDGETS,
    LIGHTS,
    LINEAR,
    ORDINARY,
    OUR_BLUR_PX,
    OUR_CELLS,
    OUR_NOISE,
    OUR_STEPS,
    WHITE,
    name_of,
    period_px,
    pictures_of,
)
from repro.judge.statistics import median_interval
from repro.page.reader import value
from repro.run.outcomes import Measured

SMOOTHED, BY_PIXEL = "smoothed", "by pixel"
WINDOW_PX = 7
# Windows whose mean sine is weaker than this are not smoothed (raxel's decoder).
WEAKEST_MEAN = 0.7
ROUNDING = 1 / 12  # variance of a grey value that is rounded
ENOUGH = 0.99  # share of the pixels that a grid has to decode to be advised
SWING = (WHITE - BLACK) / 2
PHASES = 720


def measured(result, name, key, grid):
    """Median of a value with its interval over the trials, None where none has it."""
    trials = result.column(f"{name}.{key}", **grid)
    if not np.isfinite(trials).any():
        return None
    found = median_interval(trials[np.isfinite(trials)])
    return Measured(found.value, found.low, found.high)


def middle(result, name, key, grid):
    """The median alone; nan where no trial has the value."""
    found = measured(result, name, key, grid)
    return np.nan if found is None else found.value


def widest(result, names):
    """How far, in %, an end of an interval lies from its median RMS error at most.

    names: of values, as `measured` takes them; for every grid that decodes anything.
    """
    found = [
        measured(result, name, "rms_px", grid_of(*grid))
        for name in names
        for grid in grids(result)
    ]
    ends = [max(one.high / one.value, one.value / one.low) for one in found if one]
    return 100 * (max(ends) - 1)


def swept(result, name):
    """The different values of a list that conditions have, in order."""
    return sorted({x for c in result.conditions for x in c[name]})


def grids(result):
    """(cells, steps) of every condition."""
    return [(c["cells"], c["steps"]) for c in result.conditions]


def grid_of(cells, steps):
    """What tells a condition from the others."""
    return {"cells": cells, "steps": steps}


def width_of(result):
    """Width of the pictures, px."""
    return result.conditions[0]["width_px"]


def is_readable(result, name, way, grid):
    """Whether every trial decodes enough pixels, and none into a wrong cell."""
    share = result.column(f"{name}.{way}.decoded", **grid)
    gross = result.column(f"{name}.{way}.gross", **grid)
    return bool(share.min() >= ENOUGH and gross.max() == 0)


def sigma_px(period, blur, noise, steps, way=BY_PIXEL):
    """Standard deviation of a coordinate, px, by the theory of the page.

    Arrays or numbers; period in px of the camera.
    """
    period = np.asarray(period, float)
    swing = SWING * np.exp(-2 * (np.pi * blur / period) ** 2)
    grey = np.sqrt(noise**2 + ROUNDING)
    each = period * grey * np.sqrt(2 / steps) / (2 * np.pi * swing)
    if way == BY_PIXEL:
        return each
    mean = window_mean(1, period)
    spread = np.sqrt((1 + window_mean(2, period)) / 2)
    smooth = each * spread / (WINDOW_PX * mean)
    return np.where(mean >= WEAKEST_MEAN, smooth, each)


def window_mean(order, period):
    """Mean over a window of the cosine of `order` times the phase from its middle."""
    return np.sinc(order * WINDOW_PX / period) / np.sinc(order / period)


def bias_px(period, blur, gamma, steps):
    """RMS error of a coordinate, px, that the response alone makes, by the theory."""
    phase = 2 * np.pi * np.arange(PHASES) / PHASES
    orders = np.fft.rfft((0.5 + 0.5 * np.sin(phase)) ** gamma)
    k = np.arange(len(orders))
    orders = orders * np.exp(-2 * (np.pi * blur * k / period) ** 2)
    turned = orders * np.exp(2j * np.pi * np.outer(np.arange(steps), k) / steps)
    light = np.fft.irfft(turned, PHASES, axis=1)
    angle = 2 * np.pi * np.arange(steps)[:, None] / steps
    sine = np.sum(light * np.cos(angle), axis=0)
    cosine = np.sum(light * np.sin(angle), axis=0)
    off = np.angle(np.exp(1j * (np.arctan2(sine, cosine) - phase)))
    return float(np.sqrt(np.mean(off**2)) * period / (2 * np.pi))


def rounding_px(period, blur, steps):
    """What rounding to whole grey levels adds, px, if it were noise."""
    return float(sigma_px(period, blur, 0.0, steps))


def best_cells(result, blur, noise, way):
    """(cells, their RMS error) of the readable grid with the least; None for none."""
    name = name_of(LINEAR, blur, noise)
    found = [
        (middle(result, name, f"{way}.rms_px", grid_of(*grid)), grid[0])
        for grid in grids(result)
        if is_readable(result, name, way, grid_of(*grid))
    ]
    return min(found)[::-1] if found else None


def rms(result, cells, steps, way, *, gamma=LINEAR, blur=OUR_BLUR_PX, noise=None):
    """Median RMS error of one grid in one condition, px."""
    noise = OUR_NOISE if noise is None else noise
    name = name_of(gamma, blur, noise)
    return middle(result, name, f"{way}.rms_px", grid_of(cells, steps))


def _ratio(result, cells, **where):
    """How many times the thesis's grid is worse than one of other cells."""
    ours = rms(result, OUR_CELLS, OUR_STEPS, SMOOTHED, **where)
    return ours / rms(result, cells, OUR_STEPS, SMOOTHED, **where)


def name_values(open_results):
    """Name what the prose quotes."""
    cells = open_results("ext_cells_runs")
    width = width_of(cells)
    sharp, soft = (min(swept(cells, "blurs_px")), max(swept(cells, "blurs_px")))
    value("trials", cells.trials_per_condition)
    value("fewer", open_results("ext_steps_runs").trials_per_condition)
    value("width", width)
    value("height", width // 2)
    value("sharp", sharp)
    value("soft", soft)
    value("noise", OUR_NOISE)
    for name, blur in (("sharp", sharp), ("soft", soft)):
        for way in (SMOOTHED, BY_PIXEL):
            best, error = best_cells(cells, blur, OUR_NOISE, way)
            short = "smooth" if way == SMOOTHED else "pixel"
            value(f"{name}.{short}.cells", best)
            value(f"{name}.{short}.period", period_px(best, width))
            value(f"{name}.{short}.rms", error)
        value(f"{name}.ours", rms(cells, 8, 4, SMOOTHED, blur=blur))
        value(f"{name}.period", 2 * np.pi * blur)
    best = best_cells(cells, sharp, OUR_NOISE, SMOOTHED)[0]
    value("gain", _ratio(cells, best, blur=sharp))
    value("more", pictures_of(best, OUR_STEPS) - pictures_of(8, OUR_STEPS))
    off, gross = _theory_and_gross(cells)
    value("theory", 100 * off)
    value("gross", gross)
    value("narrowest", _narrowest_smoothed())
    for name, number in _coverage(cells).items():
        value(f"within.{name}", 100 * number)
    _name_steps(open_results)


def _name_steps(open_results):
    steps = open_results("ext_steps_runs")
    width = width_of(steps)
    period = period_px(OUR_CELLS, width)
    value("period", period)
    least, most = min(swept(steps, "gammas")), max(swept(steps, "gammas"))
    value("gamma.least", least)
    value("gamma.most", most)
    for count in sorted({n for _, n in grids(steps)}):
        worst = max(
            rms(steps, OUR_CELLS, count, BY_PIXEL, gamma=g, noise=0.0)
            for g in swept(steps, "gammas")
        )
        value(f"bias.{count}", worst)
        at = rms(steps, OUR_CELLS, count, BY_PIXEL, gamma=ORDINARY, noise=0.0)
        value(f"ordinary.{count}", at)
    value("noise_alone", float(sigma_px(period, OUR_BLUR_PX, OUR_NOISE, 4)))
    pictures = open_results("ext_pictures_runs")
    blur = min(swept(pictures, "blurs_px"))
    for total in BUDGETS:
        found = {
            rms(pictures, *grid, SMOOTHED, gamma=ORDINARY, blur=blur): grid
            for grid in BUDGETS[total]
        }
        cells, count = found[min(found)]
        value(f"of{total}.cells", cells)
        value(f"of{total}.steps", count)
        value(f"of{total}.rms", min(found))
        value(f"of{total}.worst", max(found))
    light = open_results("ext_light_runs")
    for k, which in enumerate(LIGHTS[1:]):
        spread = [
            light.column(f"{which}.{BY_PIXEL}.rms_px", **grid_of(*grid))
            for grid in grids(light)
        ]
        medians = np.median(spread, axis=1)
        name = ("sines", "light")[k]
        value(f"{name}.spread", 100 * (medians.max() / medians.min() - 1))


def _theory_and_gross(result):
    """(median difference from the theory as a share, all gross errors)."""
    off, gross = [], 0
    for blur in swept(result, "blurs_px"):
        for noise in swept(result, "noises"):
            name = name_of(LINEAR, blur, noise)
            for cells, steps in grids(result):
                grid = grid_of(cells, steps)
                gross += result.column(f"{name}.{BY_PIXEL}.gross", **grid).sum()
                gross += result.column(f"{name}.{SMOOTHED}.gross", **grid).sum()
                if is_readable(result, name, BY_PIXEL, grid):
                    theory = sigma_px(
                        period_px(cells, width_of(result)), blur, noise, steps
                    )
                    found = middle(result, name, f"{BY_PIXEL}.rms_px", grid)
                    off.append(abs(found / theory - 1))
    return float(np.median(off)), int(gross)


def _narrowest_smoothed():
    """The narrowest period, px, whose windows are smoothed."""
    periods = np.linspace(WINDOW_PX + 1, 4 * WINDOW_PX, 2101)
    return float(periods[window_mean(1, periods) >= WEAKEST_MEAN][0])


def _coverage(result):
    """Least and largest median share within one stated sigma, readable grids."""
    shares = [
        middle(result, name, f"{way}.within", grid_of(*grid))
        for name, way, grid in _readable(result)
    ]
    return {"least": min(shares), "most": max(shares)}


def _readable(result):
    for blur in swept(result, "blurs_px"):
        for noise in swept(result, "noises"):
            name = name_of(LINEAR, blur, noise)
            for way in (SMOOTHED, BY_PIXEL):
                for grid in grids(result):
                    if is_readable(result, name, way, grid_of(*grid)):
                        yield name, way, grid
