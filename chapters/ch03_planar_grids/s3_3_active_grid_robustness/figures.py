"""Fig. 3.15, and the errors by the true corners."""

from functools import partial

import numpy as np

from chapters.ch03_planar_grids.s3_3_active_grid_robustness.results import (
    SWEEPS,
    SWEPT,
    errors,
    levels_of,
    residuals,
    swept,
)
from chapters.ch03_planar_grids.s3_3_active_grid_robustness.trials.sweeps import (
    EXPOSURES,
    METHODS,
    OVER,
    TRUE,
    WITHIN,
)
from repro.page.method_looks import look_of
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

AXES = {
    "distance": "Camera-grid distance (mm)",
    "orientation": "Grid orientation (deg)",
    "blur": "Gaussian blur, SD (px)",
    "noise": "Gaussian noise, SD (grey levels)",
}


def _along(panel, result, sweep, method, of, look, label):
    """Draw median and range over sets of one measure along a sweep; return the data.

    of: (result, sweep, level, method) -> (sets,).
    """
    levels = levels_of(result, sweep)
    found = np.array([of(result, sweep, level, method) for level in levels])
    found[~np.isfinite(found)] = np.nan
    low, middle, high = (
        statistic(found, axis=1) for statistic in (np.min, np.median, np.max)
    )
    panel.plot(levels, middle, label=label, **look)
    band = {"color": look["color"], "alpha": 0.18, "linewidth": 0}
    panel.fill_between(levels, low, high, **band)
    return list(zip(levels, middle, low, high, strict=True))


@figure("fig_3_15", needs=SWEPT, evidence="rendered")
def fig_3_15(results):
    """Draw the residuals of three methods along four sweeps."""
    result = swept(results)
    drawn, panels = new_figure(2, 2, height_in=6.4)
    rows = []
    for panel, sweep in zip(panels.flat, SWEEPS, strict=True):
        for method in (*METHODS, TRUE):
            look = look_of(method)
            found = _along(panel, result, sweep, method, residuals, look, method)
            rows += [(sweep, level, method, *rest) for level, *rest in found]
        panel.set(xlabel=AXES[sweep], ylabel="RMS residual (mm)", ylim=(0, None))
    _legend(drawn, panels[0, 0], 4)
    return Drawing(
        drawn,
        columns(("sweep", "level", "method", "rms_mm", "low_mm", "high_mm"), rows),
        "RMS residual of the chessboard's corners after a homography from the "
        "second active grid, in mm on the chessboard: median and range over "
        f"{_sets(result)}. Dotted: true corners, whose residual is the second "
        "grid's own error (floor). Exposure below a full well, window of 15 px.",
    )


@figure("ext_active_errors", needs=SWEPT, evidence="rendered")
def ext_active_errors(results):
    """Draw the errors by the true corners along the sweeps, with both exposures."""
    result = swept(results)
    drawn, panels = new_figure(2, 2, height_in=6.6, sharey=True)
    rows = []
    for panel, sweep in zip(panels.flat, SWEEPS, strict=True):
        for exposure in EXPOSURES:
            for method in METHODS:
                line = "-" if exposure == WITHIN else "--"
                look = look_of(method) | {"linestyle": line}
                label = f"{method}{', overexposed' * (exposure == OVER)}"
                of = partial(errors, exposure=exposure)
                found = _along(panel, result, sweep, method, of, look, label)
                rows += [
                    (sweep, level, exposure, method, *rest) for level, *rest in found
                ]
        panel.set(xlabel=AXES[sweep], ylabel="RMS error (px)", yscale="log")
    _legend(drawn, panels[0, 0], 3)
    return Drawing(
        drawn,
        columns(
            (
                "sweep", "level", "exposure", "method",
                "rms_px", "low_px", "high_px",
            ),
            rows,
        ),
        "RMS distance (px) of the localised corners from the true ones: median "
        f"and range over {_sets(result)}. Dashed: overexposed by a fifth above "
        "a full well.",
    )  # fmt: skip


def _legend(drawn, panel, columns_in_it):
    """Draw one legend above all panels."""
    handles, labels = panel.get_legend_handles_labels()
    drawn.legend(
        handles, labels, loc="outside upper center", ncols=columns_in_it,
        fontsize=8,
    )  # fmt: skip


def _sets(result):
    count = len(result.levels("set"))
    return "one set of images" if count == 1 else f"{count} sets of images"
