"""The figure of the page on extraction without clicks."""

import numpy as np

from chapters.ch03_planar_grids.ext_without_clicks.results import known
from chapters.ch03_planar_grids.ext_without_clicks.trials.requests import (
    RIGHT_PX,
    SWEPT,
)
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing


@figure(
    "ext_click_free_sweeps", needs=("ext_without_clicks_sweeps",), evidence="rendered"
)
def ext_click_free_sweeps(results):
    """The worst corner of each board over five sweeps, and the refusals."""
    result = results["ext_without_clicks_sweeps"]
    drawn, axes = new_figure(2, 3, height_in=4.4)
    sweeps, rows = result.by("sweep"), []
    for axis, (sweep, (_, label, unit)) in zip(axes.flat, SWEPT.items(), strict=False):
        of_level = sweeps[sweep].by("level") if sweep in sweeps else {}
        for level, trials in of_level.items():
            off, found = trials.column("worst_px"), trials.column("found")
            rows += [(sweep, level, *of) for of in zip(off, found, strict=True)]
            right, lost = off[np.isfinite(off)], np.count_nonzero(found == 0)
            axis.plot([level] * len(right), right, "o", color="C0", ms=4)
            axis.plot([level] * lost, [1.0] * lost, "x", color="C1", ms=5)
        axis.axhline(RIGHT_PX, color="0.6", lw=0.8)
        axis.set(ylim=(0, 1.15), xlabel=f"{label} ({unit})", ylabel="worst corner (px)")
    drawn.delaxes(axes.flat[-1])
    drawn.tight_layout()
    off = known(result, "wrong")
    return Drawing(
        drawn,
        columns(("sweep", "level", "worst_px", "found"), rows),
        "Boards of 3.3.1 with one thing changed. Dots: the corner farthest from the "
        "truth, of boards that were returned. Crosses: boards that were refused.",
        Check(
            off.sum() == 0,
            f"{int(off.sum())} of {len(off)} boards were returned with a corner more "
            f"than {RIGHT_PX:g} px off, or of a wrong size; the aim is none",
        ),
    )
