"""Fig. 4.2, and the steps from the standard linear stage to CGSP."""

import numpy as np
from matplotlib.ticker import FixedFormatter

from chapters.ch04_central_generic.s1_5_simulated.results import (
    PRIMARY,
    QUANTITIES,
    STAGES,
    STEP_NAMES,
    WORDS,
    centre_after,
    medians,
)
from chapters.ch04_central_generic.s1_5_simulated.trials import LEVELS, NOISE_PX, STEPS
from chapters.shared.methods import LINEAR_NAMES
from repro.page.method_looks import look_of
from repro.page.style import figure as new_figure
from repro.page.style import legend_below, plot_estimates, series
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

UNITS = {"r2": "deg", "r3": "deg"}
CURVES = (
    ("as_printed", "linear"),
    ("as_printed", "ba"),
    ("well_conditioned", "linear"),
    ("cgsp", "linear"),
)


@figure("fig_4_2", needs=("fig_4_2_redrawn",), evidence="synthetic")
def fig_4_2(results):
    """Six errors against the noise level, in the primary interpretation."""
    result = results["fig_4_2_redrawn"]
    drawn, axes = new_figure(2, 3, height_in=5.6, sharex=True)
    rows = []
    for panel, quantity in zip(axes.flat, QUANTITIES, strict=True):
        for method, stage in CURVES:
            found = medians(result, PRIMARY, method, stage, quantity)
            name = LINEAR_NAMES[method]
            look = {
                "look": look_of(name, hollow=stage == "ba"),
                "label": name + STAGES[stage],
            }
            rows += plot_estimates(
                panel, LEVELS, found, (quantity, method, stage), **look
            )
        panel.set(xscale="log", yscale="log", title=WORDS[quantity])
        panel.set_ylabel(f"Error ({UNITS.get(quantity, 'mm')})")
    for panel in axes[1]:
        panel.set_xlabel("Noise SD (px)")
    legend_below(drawn, axes[0, 0], ncols=2)
    return Drawing(
        drawn,
        columns(
            ("quantity", "method", "stage", "noise_px", "median", "low", "high"), rows
        ),
        "Errors of the centre, of the poses of grids 2 and 3, and of the rays "
        "against the pixel noise. Methods: standard as printed, the same with "
        "bundle adjustment, standard well conditioned, and CGSP. Medians over "
        "trials with 95 % intervals, logarithmic axes. The translation error "
        "is that of the length, as in the thesis.",
    )


@figure("ext_what_cgsp_buys_figure", needs=("ext_cgsp_steps",), evidence="synthetic")
def what_cgsp_buys(results):
    """Centre error after every change, from top to bottom."""
    result = results["ext_cgsp_steps"]
    drawn, axes = new_figure(height_in=3.4)
    rows = np.arange(len(STEPS))[::-1]
    middle, low, high = np.array([centre_after(result, step)[:3] for step in STEPS]).T
    look = series(0) | {"linestyle": ""}
    axes.errorbar(middle, rows, xerr=[middle - low, high - middle], capsize=3, **look)
    axes.set_yticks(rows)
    axes.yaxis.set_major_formatter(FixedFormatter([STEP_NAMES[step] for step in STEPS]))
    axes.set(xscale="log", xlabel="Median error of the centre (mm)")
    return Drawing(
        drawn,
        columns(
            ("method", "median_mm", "low_mm", "high_mm"),
            zip(STEPS, middle, low, high, strict=True),
        ),
        f"Error of the camera's centre at {NOISE_PX} px noise, from the standard "
        "linear stage as printed (top) to CGSP and its extensions, with one "
        "change per line. Medians over trials with 95 % intervals, logarithmic "
        "axis.",
    )
