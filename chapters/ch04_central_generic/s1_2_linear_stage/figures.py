"""What the linear stage does as grids become parallel."""

from __future__ import annotations

import numpy as np

from chapters.ch04_central_generic.s1_2_linear_stage.results import WARNS
from repro.judge.statistics import median_interval
from repro.page.style import INK, plot_interval, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

TITLES = {"base": "grid 2 to the base", "grids": "grid 3 to grid 2"}
ZERO_DEG = 0.02  # where an angle of 0 is drawn
REFUSES = 5.0  # margin over the noise


@figure("ext_degeneracy", needs=("ext_degeneracy_sweep",), evidence="synthetic")
def ext_degeneracy(results):
    """Centre error, measured degeneracy and refusals over one angle."""
    found = results["ext_degeneracy_sweep"]
    drawn, axes = new_figure(3, 2, height_in=7.2, sharex=True, sharey="row")
    rows = []
    for column, (which, title) in enumerate(TITLES.items()):
        conditions = sorted(
            (c for c in found.conditions if c["which"] == which),
            key=lambda c: c["angle_deg"],
        )
        angles = np.array([c["angle_deg"] for c in conditions])
        x = np.where(angles > 0, angles, ZERO_DEG)
        for panel, name, index, label in (
            (axes[0, column], "unguarded_mm", 1, "if nothing were refused"),
            (axes[1, column], "degeneracy", 0, "singular values 3 / 1"),
        ):
            medians = [median_interval(found.column(name, **c)) for c in conditions]
            middle, low, high = np.array([m[:3] for m in medians]).T
            top = 1e4
            plot_interval(
                panel, x, np.minimum(middle, top), np.minimum(low, top),
                np.minimum(high, top), index=index, label=label,
            )  # fmt: skip
            rows += [
                (which, at, name, *m[:3]) for at, m in zip(angles, medians, strict=True)
            ]
        refused = np.array([found.column("refused", **c).mean() for c in conditions])
        axes[2, column].plot(x, 100 * refused, **series(2))
        rows += [
            (which, at, "refused", share, share, share)
            for at, share in zip(angles, refused, strict=True)
        ]
        axes[0, column].set(yscale="log", title=title)
        axes[1, column].set(yscale="log")
        axes[1, column].axhline(WARNS, color=INK, lw=0.9, ls=":", marker="")
        axes[2, column].set(xscale="log")
        axes[2, column].set_xlabel("Angle between the planes (deg)")
        shown = [0.02, 0.1, 1, 10]
        axes[2, column].set_xticks(shown, ["0", "0.1", "1", "10"])
    axes[0, 0].set_ylabel("Centre error (mm)")
    axes[1, 0].set_ylabel("Degeneracy (1)")
    axes[2, 0].set_ylabel("Refused (%)")
    axes[0, 0].legend()
    axes[1, 0].legend()
    return Drawing(
        drawn,
        columns(("which", "angle_deg", "series", "value", "low", "high"), rows),
        "Two planes become parallel, with 0.5 px of noise: the error that the "
        "centre has or would have (medians with 95 % intervals), the measured "
        f"degeneracy (dotted: {WARNS}, below which a centre deserves suspicion), "
        "and the share of trials that the linear stage refuses. An angle of 0 "
        "is drawn at the left end.",
    )
