"""Errors of rays by table and by update, case by case."""

import numpy as np

from chapters.ch05_flexible_mirror.ext_lookup.results import RUNS, SAID, WAYS, measured
from repro.judge.statistics import median_interval
from repro.page.style import figure as new_figure
from repro.page.style import legend_below, plot_estimates, series
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

SHORT = ("2.5", "5\n(entry)", "7.5", "12.5", "7.5,\n3°", "7.5,\n8°", "18")


@figure(
    "ext_mirror_lookup_figure", needs=("ext_mirror_lookup_runs",), evidence="synthetic"
)
def lookup_figure(results):
    """Mean ray angle of every case, a colour for each way."""
    result, rows = results[RUNS], []
    drawn, axes = new_figure(1, 2, height_in=4.2, sharey=True)
    places = np.arange(len(SAID))
    for panel, geometry in zip(axes, "AB", strict=True):
        for number, (way, label) in enumerate(WAYS.items()):
            found = [
                median_interval(measured(result, geometry, way, case, "angle_deg"))
                for case in SAID
            ]
            rows += plot_estimates(
                panel, places + 0.13 * (number - 1.5), found, (geometry, way),
                look=series(number) | {"linestyle": ""}, label=label, bars=True,
            )  # fmt: skip
        panel.set(title=geometry, yscale="log")
        panel.set_xticks(places, SHORT)
        panel.set_xlabel("Deflection (mm)")
    axes[0].set_ylabel("Mean ray angle (degrees)")
    legend_below(drawn, axes[0], ncols=2)
    return Drawing(
        drawn,
        columns(("geometry", "way", "case", "median", "low", "high"), rows),
        "Error of the rays when the shape is looked up by the mirror's boundary, and "
        "when it is updated from a board. The table has 0, 5, 10 and 15 mm; a poorer "
        "one 0 and 15 mm alone. Angles are the rulings of a twisted sheet, which no "
        "entry has. Mean angles to the true rays over the whole mirror, medians over "
        f"{result.trials_per_condition} seeds with 95 % intervals; the vertical axis "
        "is logarithmic.",
    )
