"""Errors over what was stated for them, for every set of the record at once."""

import numpy as np
from matplotlib.ticker import FixedFormatter

from chapters.guides.stated_errors.results import RECORD_RUN, column, groups
from repro.page.style import INK, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

WANTED = 0.8, 1.3
GAUSSIAN = 100 - 99.73
LEAST = 0.02  # of the axis: none at all lies there
TALL = 0.28  # dots of one group spread over so much of a line, each way


@figure("ext_stated_coverage", needs=("ext_stated_record",), evidence="rendered")
def ext_stated_coverage(results):
    """Ratio of errors to stated ones, and how many lie beyond three of these."""
    kept, rows = groups(results[RECORD_RUN]), []
    drawn, (ratios, beyonds) = new_figure(1, 2, height_in=3.0, sharey=True)
    for line, (label, (record, part, own)) in enumerate(kept.items()):
        ratio = column(record, part, "ratio")[own]
        beyond = 100 - column(record, part, "within3")[own]
        known = np.isfinite(ratio)
        y = line + np.linspace(-TALL, TALL, known.sum())
        look = series(line)
        dots = {"color": look["color"], "marker": look["marker"], "linestyle": "none"}
        ratios.plot(ratio[known], y, markersize=4, **dots)
        beyonds.plot(np.maximum(beyond[known], LEAST), y, markersize=4, **dots)
        pairs = zip(ratio[known], beyond[known], strict=True)
        rows += [(label, float(a), float(b)) for a, b in pairs]
    ratios.axvspan(*WANTED, color=INK, alpha=0.08, linewidth=0)
    ratios.axvline(1, color=INK, linewidth=0.8)
    ratios.set(xscale="log", xlabel="Error over stated (1)")
    ratios.set_xticks([0.5, 1, 2, 5], ["0.5", "1", "2", "5"], minor=False)
    ratios.set_xticks([], minor=True)
    ratios.set_yticks(range(len(kept)))
    ratios.yaxis.set_major_formatter(FixedFormatter(list(kept)))
    ratios.invert_yaxis()
    beyonds.axvline(GAUSSIAN, color=INK, linewidth=0.8, linestyle=":")
    beyonds.set(xscale="log", xlabel="Beyond three stated SDs (%)")
    marks = [LEAST, 0.1, 1, 10, 100]
    beyonds.set_xticks(marks, ["none", "0.1", "1", "10", "100"], minor=False)
    beyonds.set_xticks([], minor=True)
    return Drawing(
        drawn,
        columns(("group", "error over stated", "beyond three (%)"), rows),
        "Each mark is a set of the tables below, in their order. Left: errors over "
        f"what was stated for them; grey: {WANTED[0]:g} to {WANTED[1]:g}. Right: how "
        "many errors are larger than three stated standard deviations; dotted: the "
        f"{GAUSSIAN:.2g} % of a Gaussian.",
    )
