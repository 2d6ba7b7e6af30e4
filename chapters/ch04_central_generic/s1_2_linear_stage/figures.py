"""What the linear stage does as grids become parallel."""

import numpy as np

from chapters.ch04_central_generic.s1_2_linear_stage.results import WARNS
from repro.judge.statistics import median_interval
from repro.page.style import INK, plot_estimates, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

TITLES = {"base": "grid 2 to the base", "grids": "grid 3 to grid 2"}
ZERO_DEG = 0.02  # where an angle of 0 is drawn
HIGHEST = 1e4  # mm, where larger medians are drawn


@figure("ext_degeneracy", needs=("ext_degeneracy_sweep",), evidence="synthetic")
def ext_degeneracy(results):
    """Centre error, measured degeneracy and refusals over one angle."""
    found = results["ext_degeneracy_sweep"]
    drawn, axes = new_figure(3, 2, height_in=7.2, sharex=True, sharey="row")
    rows = []
    for column, (which, title) in enumerate(TITLES.items()):
        trials = dict(sorted(found.by("angle_deg", which=which).items()))
        x = [angle or ZERO_DEG for angle in trials]
        for panel, name, index, label in (
            (axes[0, column], "unguarded_mm", 1, "if nothing were refused"),
            (axes[1, column], "degeneracy", 0, "singular values 3 / 1"),
        ):
            medians = [median_interval(one.column(name))[:3] for one in trials.values()]
            plot_estimates(
                panel, x, np.minimum(medians, HIGHEST), look=series(index), label=label
            )
            rows += [
                (which, at, name, *median)
                for at, median in zip(trials, medians, strict=True)
            ]
        refused = [one.column("refused").mean() for one in trials.values()]
        axes[2, column].plot(x, 100 * np.array(refused), **series(2))
        rows += [
            (which, at, "refused", share, share, share)
            for at, share in zip(trials, refused, strict=True)
        ]
        axes[0, column].set(yscale="log", title=title)
        axes[1, column].set(yscale="log")
        axes[1, column].axhline(WARNS, color=INK, lw=0.9, ls=":", marker="")
        axes[2, column].set(xscale="log")
        axes[2, column].set_xlabel("Angle between the planes (deg)")
        axes[2, column].set_xticks([0.02, 0.1, 1, 10], ["0", "0.1", "1", "10"])
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
