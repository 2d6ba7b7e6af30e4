"""Fig. 4.2: errors of the linear stages against noise."""

from chapters.ch04_central_generic.s1_5_simulated.results import (
    PRIMARY,
    QUANTITIES,
    STAGES,
    WORDS,
    medians,
)
from chapters.ch04_central_generic.s1_5_simulated.trials import LEVELS
from chapters.shared.methods import LINEAR_NAMES
from repro.page.method_looks import look_of
from repro.page.style import figure as new_figure
from repro.page.style import legend_below, plot_estimates
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
    """Six errors along the levels of noise, in the primary reading."""
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
        "against the noise of the pixels, for the standard method as printed, "
        "with its bundle adjustment, well conditioned, and for CGSP. Medians "
        "over trials with 95 % intervals; both axes are logarithmic. The "
        "error of a translation is that of its length, as in the thesis.",
    )
