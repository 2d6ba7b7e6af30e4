"""Table 2.2: residuals of redrawn and of rendered seeds."""

from __future__ import annotations

import numpy as np

from chapters.shared.methods import METHODS, NAMES
from chapters.shared.zoom_rigs import ZOOMS
from repro.judge.statistics import SIGNIFICANCE, holm, with_worst
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Check, Table
from repro.run.results import summary

ROWS = {"rms_px": "RMS", "mean_px": "mean", "sd_px": "SD"}
SOURCES = {
    "table_2_2_redrawn": "redrawn",
    "table_2_2_rendered": "rendered",
}


@table(
    "table_2_2",
    needs=("table_2_2_redrawn", "table_2_2_rendered"),
    evidence="rendered",
)
def table_2_2(results):
    """Residuals of the calibration pictures, in px of the corrected view."""
    names = ["Method", "Error type", "Corners"]
    rows = [
        [NAMES[method], label, corners]
        + [
            cell_of(results[experiment], method, statistic, zoom)
            for zoom in ZOOMS
        ]
        for experiment, corners in SOURCES.items()
        for method in METHODS
        for statistic, label in ROWS.items()
    ]
    return Table(
        columns(names + [f"Set {zoom} (px)" for zoom in ZOOMS], rows),
        "Distortion residuals after perspective correction: medians over "
        "seeds with 95 % intervals. Corners redrawn: with errors of those "
        "found in rendered pictures; rendered: found in the pictures of "
        f"{results['table_2_2_rendered'].trials_per_condition} seeds, too few "
        "for an interval, so that their range stands in its place.",
        agreement(*(results[name] for name in SOURCES)),
    )


def agreement(redrawn, rendered):
    """Whether redrawn seeds differ from rendered ones: rank tests, Holm.

    A p-value that was not reached shows no equality: the text says how far
    the medians are apart.
    """
    from scipy.stats import mannwhitneyu

    p, ratios = [], []
    for method in METHODS:
        name = f"{method}.calibration.corrected.rms_px"
        for zoom in ZOOMS:
            both = [
                with_worst(ran.column(name, zoom=zoom))
                for ran in (redrawn, rendered)
            ]
            p.append(mannwhitneyu(*both).pvalue)
            ratios.append(np.median(both[0]) / np.median(both[1]))
    smallest = min(holm(p))
    return Check(
        bool(smallest > SIGNIFICANCE),
        "no difference shown between residuals of redrawn and rendered "
        f"seeds: smallest p of {len(p)} rank tests, corrected, "
        f"{smallest:.2g}; medians of redrawn seeds are {min(ratios):.2f} to "
        f"{max(ratios):.2f} times those of {len(both[1])} rendered ones",
    )


def cell_of(result, method, statistic, zoom):
    """Median and interval in words; failures are counted."""
    name = f"{method}.calibration.corrected.{statistic}"
    trials = result.column(name, zoom=zoom)
    failed = int(np.isnan(trials).sum())
    if failed == len(trials):
        return "failed in all seeds"
    row = summary([None if np.isnan(t) else float(t) for t in trials])
    low, high = row["median_interval"]
    text = f"{row['median']:.2f} ({low:.2f} to {high:.2f})"
    return text + (f", {failed} failed" if failed else "")
