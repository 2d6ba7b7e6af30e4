"""The localisers of section 3.1.3 side by side."""

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
    """The best single setting, and what a choice by distance would save."""
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
        "method",
        "best window (px)",
        "best blur SD (px)",
        "median residual (px)",
        "most above a bin's own best (%)",
        "saved by a choice per bin: median (%)",
        "saved: mean (%)",
    )
    return Table(
        columns(names, rows),
        "The single best setting of either method, by how much it is above "
        "the best of a bin in the worst bin (luck within the bin included), "
        "and how much of the residual a choice per bin saves: chosen on one "
        "half of the images, scored on the other, with 95 % intervals. "
        "Negative: the choice costs.",
    )
