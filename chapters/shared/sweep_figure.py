"""Claims at the bench's noise, drawn from half to twice its factor."""

from math import ceil

import numpy as np

from chapters.shared.noise_sweep import ALONG_THE_SWEEP
from repro.judge.seeds import SHARE_OF_SEEDS
from repro.page.style import INK, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.outcomes import Drawing

ACROSS = 3  # panels in a row
ROW_IN = 1.75
SHARE = "Share of seeds (1)"
RATIO = "Ratio (1)"


def shares_along(found_at):
    """Share of seeds in which a claim is true, along the sweep, and the bound.

    found_at(noise): as `counterpart_over_the_sweep` takes it.
    """
    shares = [np.mean(found_at(noise)[0]) for noise in ALONG_THE_SWEEP.values()]
    return shares, SHARE_OF_SEEDS, SHARE


def draw_sweep(panels, caption):
    """The Drawing of {claim: (values along the sweep, bound, label of the axis)}."""
    rows = ceil(len(panels) / ACROSS)
    drawn, axes = new_figure(rows, ACROSS, height_in=ROW_IN * rows + 0.4, sharex=True)
    multiples = list(ALONG_THE_SWEEP)
    data = []
    for panel in axes.flat[len(panels) :]:
        panel.set_axis_off()
    for panel, (claim, (values, bound, label)) in zip(
        axes.flat, panels.items(), strict=False
    ):
        panel.plot(multiples, values, **series(0))
        panel.axhline(bound, color=INK, lw=1.0, ls="--")
        panel.set_xscale("log")
        panel.set_xticks(multiples, [f"{m:g}" for m in multiples])
        panel.minorticks_off()
        panel.set(title=claim.removeprefix("c4_"), ylabel=label)
        panel.title.set(fontsize=8.5)
        if label == SHARE:
            panel.set_ylim(-0.05, 1.05)
        data += [(claim, m, v, bound) for m, v in zip(multiples, values, strict=True)]
    for panel in axes.flat[max(0, len(panels) - ACROSS) : len(panels)]:
        panel.set_xlabel("Of the factor (1)")
        panel.xaxis.set_tick_params(labelbottom=True)
    return Drawing(
        drawn,
        columns(("claim", "multiple", "value", "bound"), data),
        f"{caption} Dashed: the bound of the test. A line that crosses it leaves the "
        "verdict open.",
    )
