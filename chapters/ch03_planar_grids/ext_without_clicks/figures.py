"""The figure of the page on extraction without clicks."""

from __future__ import annotations

import numpy as np

from chapters.ch03_planar_grids.ext_without_clicks.results import over
from chapters.ch03_planar_grids.ext_without_clicks.trials.requests import (
    RIGHT_PX,
    SWEPT,
)
from repro.page.style import figure as new_figure
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing


@figure(
    "ext_click_free_sweeps", needs=("ext_without_clicks_sweeps",), evidence="rendered"
)
def ext_click_free_sweeps(results):
    """The worst corner of each board over five sweeps, and the refusals."""
    result = results["ext_without_clicks_sweeps"]
    drawn, axes = new_figure(2, 3, height_in=4.4)
    data = {name: [] for name in ("sweep", "level", "worst_px", "found")}
    for axis, (sweep, (_, label, unit)) in zip(axes.flat, SWEPT.items(), strict=False):
        for one in result.conditions:
            if one["sweep"] != sweep:
                continue
            off = result.column("worst_px", **one)
            found = result.column("found", **one)
            for x, y in zip(found, off, strict=True):
                data["sweep"].append(sweep)
                data["level"].append(one["level"])
                data["worst_px"].append(y)
                data["found"].append(x)
            right = np.isfinite(off)
            axis.plot([one["level"]] * right.sum(), off[right], "o", color="C0", ms=4)
            lost = np.count_nonzero(found == 0)
            axis.plot([one["level"]] * lost, [1.0] * lost, "x", color="C1", ms=5)
        axis.axhline(RIGHT_PX, color="0.6", lw=0.8)
        axis.set_ylim(0, 1.15)
        axis.set_xlabel(f"{label} ({unit})")
        axis.set_ylabel("worst corner (px)")
    drawn.delaxes(axes.flat[-1])
    drawn.tight_layout()
    off = over(result, "wrong")
    return Drawing(
        drawn,
        data,
        "Boards of 3.3.1 with one thing changed. Dots: the corner farthest from the "
        "truth, of boards that were returned. Crosses: boards that were refused.",
        Check(
            off.sum() == 0,
            f"{int(off.sum())} of {len(off)} boards were returned with a corner more "
            f"than {RIGHT_PX:g} px off, or of a wrong size; the aim is none",
        ),
    )
