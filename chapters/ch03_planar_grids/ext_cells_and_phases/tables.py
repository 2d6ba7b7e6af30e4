"""Which cells and how many steps to take, and all numbers behind it."""

from itertools import product

import numpy as np

from chapters.ch03_planar_grids.ext_cells_and_phases.results import (
    BY_PIXEL,
    ENOUGH,
    SMOOTHED,
    WAYS,
    best_cells,
    decoded,
    grids,
    read_twice,
    rms,
    sigma_px,
    swept,
    widest,
    width_of,
)
from chapters.ch03_planar_grids.ext_cells_and_phases.trials import (
    BUDGETS,
    FULL_WELL_E,
    LIGHTS,
    LINEAR,
    ORDINARY,
    OUR_BLUR_PX,
    OUR_CELLS,
    OUR_NOISE,
    OUR_STEPS,
    READINGS,
    name_of,
    period_px,
    pictures_of,
)
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Check, Table


@table("ext_cells_advice", needs=("ext_cells_runs",), evidence="rendered")
def ext_cells_advice(results):
    """The best cells for each blur and noise, and what the thesis's eight cost."""
    result = results["ext_cells_runs"]
    rows = [
        [blur, noise, *(c for way in WAYS for c in _best(result, blur, noise, way))]
        for blur, noise in product(swept(result, "blurs_px"), swept(result, "noises"))
    ]
    heads = ["Blur SD (px)", "Noise SD (grey levels)"]
    for way in WAYS:
        heads += [
            f"{way}: cells",
            f"{way}: width of one (px)",
            f"{way}: RMS error (px)",
            f"{way}: that of 8 cells / this",
        ]
    return Table(
        columns(heads, rows),
        "The best of the tested numbers of cells, with four steps: least "
        "median RMS error of those that decode 99 % of the pixels and none "
        "into a wrong cell. The width of a cell, in px of the camera, is "
        "what carries over to another picture.",
    )


def _best(result, blur, noise, way):
    """The best cells, how wide one is, their error, and that of eight over it."""
    best = best_cells(result, blur, noise, way)
    if best is None:
        return [None] * 4
    count, error = best
    ours = rms(result, OUR_CELLS, OUR_STEPS, way, blur=blur, noise=noise)
    return [count, period_px(count, width_of(result)), error, ours / error]


@table("ext_cells_scores", needs=("ext_cells_runs",), evidence="rendered")
def ext_cells_scores(results):
    """Every grid at one noise: errors, stated SD, pixels decoded."""
    result = results["ext_cells_runs"]
    names = {b: name_of(LINEAR, b, OUR_NOISE) for b in swept(result, "blurs_px")}
    rows = [
        [blur, grid[0], way, *_scores(decoded(result, name, way)[grid])]
        for blur, name in names.items()
        for grid in grids(result)
        for way in WAYS
    ]
    heads = (
        "Blur SD (px)",
        "Cells",
        "Decoded",
        "RMS error (px)",
        "Median (px)",
        "95 % below (px)",
        "Stated SD (px)",
        "Within it (%)",
        "Pixels read (%)",
        "In a wrong cell (pixels)",
    )
    return Table(
        columns(heads, rows),
        f"All grids with four steps under noise of SD {OUR_NOISE:g}, medians "
        "over the views; errors are of one coordinate. Within it: errors of "
        "at most one stated SD, 68 % if they are normal. In a wrong cell: "
        "off by half a cell or more, over all views. The 95 % intervals of "
        f"the RMS errors end within {widest(result, names.values()):.0f} % of them.",
        Check(
            all(row[-1] == 0 for row in rows if row[-2] >= 100 * ENOUGH),
            "no grid that reads 99 % has a pixel in a wrong cell",
        ),
    )


def _scores(one):
    keys = ("rms_px", "median_px", "p95_px", "sigma_px", "within", "decoded")
    *found, within, read = (one.median(key) for key in keys)
    cells = (*found, 100 * within, 100 * read)
    return [
        *(x if np.isfinite(x) else None for x in cells),
        int(one.column("gross").sum()),
    ]


@table("ext_steps_advice", needs=("ext_steps_runs",), evidence="rendered")
def ext_steps_advice(results):
    """The error of each number of steps by gamma, and the steps that suffice."""
    result = results["ext_steps_runs"]
    period = period_px(OUR_CELLS, width_of(result))
    counts, rows = [steps for _, steps in grids(result)], []
    for gamma in swept(result, "gammas"):
        of_grid = decoded(result, name_of(gamma, OUR_BLUR_PX, 0.0), BY_PIXEL).values()
        found = [one.median("rms_px") for one in of_grid]
        enough = [
            _enough(period, n, error, one.column("gross").sum())
            for n, error, one in zip(counts, found, of_grid, strict=True)
        ]
        rows.append([gamma, *found, *_first(counts, enough)])
    heads = [
        "Gamma",
        *(f"{n} steps (px)" for n in counts),
        *(f"steps for noise {noise:g}" for noise in NOISES),
    ]
    return Table(
        columns(heads, rows),
        f"Median RMS error (px) that the response makes without noise, with "
        f"{OUR_CELLS} cells of {period:.0f} px, by pixel; and the fewest of "
        "the tested steps with which it is less than half of the error that "
        "noise of that SD makes, so that it adds less than 12 %.",
    )


@table("ext_steps_coverage", needs=("ext_corrected_runs",), evidence="rendered")
def ext_steps_coverage(results):
    """Errors beside their stated SD, with the response left and undone."""
    result = results["ext_corrected_runs"]
    rows, corrected = [], []
    for steps, reading, of_gamma in read_twice(result):
        for gamma, ways in of_gamma.items():
            rows.append([gamma, steps, reading, *_covered(ways)])
            if not READINGS[reading]:
                corrected.append(100 * ways[SMOOTHED].median("within"))
    rows.sort(key=lambda row: row[:2])
    heads = ["Gamma", "Steps", "Response", "RMS error (px)", "stated SD (px)"]
    heads += [f"within {k} SD (%)" for k in (1, 2, 3)]
    heads += ["by pixel: RMS error (px)", "by pixel: within 1 SD (%)"]
    least, most = min(corrected), max(corrected)
    return Table(
        columns([*heads, "shift told (px)"], rows),
        "The same pictures with the response as it is seen, as in the thesis, and "
        "corrected, smoothed and by pixel. Normal errors are within 1, 2, 3 SDs in "
        "68, 95 and 99.7 %. Shift told: by how much, RMS, the decoder says that the "
        f"response shifts places. Noise of SD {OUR_NOISE:g} grey levels, {OUR_CELLS} "
        f"cells of {period_px(OUR_CELLS, width_of(result)):.0f} px, medians over the "
        "views. The 95 % intervals of the RMS errors end within "
        f"{_widest_read(result):.0f} % of them.",
        Check(
            COVERED[0] <= least and most <= COVERED[1],
            f"corrected and smoothed, {least:.0f} to {most:.0f} % of the errors are "
            "within one stated SD with every gamma",
        ),
    )


COVERED = 63, 75  # %: in a small picture few windows share no pixel


def _covered(ways):
    """RMS error, SD, % within 1, 2, 3 of it; by pixel; and the shift told."""
    smoothed, by_pixel = ways[SMOOTHED], ways[BY_PIXEL]
    told = smoothed.median("told_px")
    return [
        *(smoothed.median(key) for key in ("rms_px", "sigma_px")),
        *(100 * smoothed.median(key) for key in ("within", "within_2", "within_3")),
        by_pixel.median("rms_px"),
        100 * by_pixel.median("within"),
        told if np.isfinite(told) else None,
    ]


def _widest_read(result):
    """How far, in %, an end of an interval lies from its median RMS error at most."""
    found = [
        one.measured("rms_px")
        for *_, of_gamma in read_twice(result)
        for ways in of_gamma.values()
        for one in ways.values()
    ]
    return 100 * (max(max(m.high / m.value, m.value / m.low) for m in found) - 1)


NOISES = (1.0, 3.0, 8.0)


def _enough(period, steps, error, gross):
    """For each of NOISES: whether the response adds little to what noise does."""
    return [
        gross == 0 and error < sigma_px(period, OUR_BLUR_PX, noise, steps) / 2
        for noise in NOISES
    ]


def _first(counts, enough):
    """The fewest steps that are enough, for each noise."""
    return [
        next((n for n, good in zip(counts, column, strict=True) if good), None)
        for column in zip(*enough, strict=True)
    ]


@table("ext_equal_pictures", needs=("ext_pictures_runs",), evidence="rendered")
def ext_equal_pictures(results):
    """Errors of grids that take the same number of pictures."""
    result = results["ext_pictures_runs"]
    blurs = swept(result, "blurs_px")
    names = [name_of(ORDINARY, blur, OUR_NOISE) for blur in blurs]
    columns_of = [decoded(result, name, way) for way in WAYS for name in names]
    rows = [
        [total, *grid, *(_if_readable(of_grid[grid]) for of_grid in columns_of)]
        for total, tested in BUDGETS.items()
        for grid in tested
    ]
    heads = ["Pictures", "Cells", "Steps"]
    heads += [f"{way}, blur {blur:g} px (px)" for way in WAYS for blur in blurs]
    taken = all(pictures_of(*row[1:3]) == row[0] for row in rows)
    return Table(
        columns(heads, rows),
        "Median RMS error of grids that take equally many pictures, for both axes "
        "with all inverses: finer cells against more steps. Monitor of gamma "
        f"{ORDINARY:g}, noise of SD {OUR_NOISE:g} grey levels. No number: "
        "fewer than 99 % of the pixels are decoded, or some into a wrong "
        f"cell. The 95 % intervals end within {widest(result, names):.0f} % "
        "of the medians.",
        Check(taken, "the pictures of every grid add up"),
    )


def _if_readable(one):
    return one.median("rms_px") if one.readable else None


@table("ext_steps_light", needs=("ext_light_runs",), evidence="rendered")
def ext_steps_light(results):
    """Steps compared with the same exposure each, the same pictures, the same light."""
    result = results["ext_light_runs"]
    in_light = [decoded(result, which, BY_PIXEL) for which in LIGHTS]
    rows = [
        [grid[1], *(of_grid[grid].median("rms_px") for of_grid in in_light)]
        for grid in grids(result)
    ]
    heads = [
        "Steps",
        "one picture a step, each exposed alike (px)",
        "24 pictures of sines an axis (px)",
        "light of four steps in all (px)",
    ]
    return Table(
        columns(heads, rows),
        "Median RMS error of a coordinate with a linear response and the noise of "
        f"a sensor of {FULL_WELL_E:.0f} electrons: only the pictures and the "
        "light count.",
    )
