"""Table of the localisers of section 3.1.3."""

import numpy as np

from chapters.ch03_planar_grids.s1_3_localisation.results import (
    Swept,
    best_setting,
    excess_of_one_setting,
    gain_of_bins,
)
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table


@table(
    "ext_localiser_choice",
    needs=("fig_3_5_derivative", "fig_3_5_saddle"),
    evidence="rendered",
)
def ext_localiser_choice(results):
    """Best single setting of each localiser, and gain of a choice by distance."""
    rows = []
    for name, title in (("derivative", "derivative"), ("saddle", "saddle point")):
        swept = Swept(results[f"fig_3_5_{name}"])
        window, blur, median = best_setting(swept)
        saved = [gain_of_bins(swept, s) for s in (np.median, np.mean)]
        rows.append(
            (
                title,
                int(window),
                None if np.isnan(blur) else float(blur),
                float(median),
                100 * float(excess_of_one_setting(swept) - 1),
                *(Measured(100 * s.value, 100 * s.low, 100 * s.high) for s in saved),
            )
        )
    names = (
        "Method",
        "Best window (px)",
        "Best blur SD (px)",
        "Median residual (px)",
        "Largest excess over a bin's best (%)",
        "Median saved per bin (%)",
        "Mean saved per bin (%)",
    )
    return Table(
        columns(names, rows),
        "Best single setting of each method and its median residual. Excess: "
        "over the best setting of the worst bin, chance included. Saved: part "
        "of the residual that a choice per bin saves, chosen on one half of the "
        "images and scored on the other, with 95 % intervals. Negative: the "
        "choice costs.",
    )
