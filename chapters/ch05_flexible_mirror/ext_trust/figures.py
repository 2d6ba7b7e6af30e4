"""Rays over the stages, predicted beside true errors, support, and the prior."""

import numpy as np

from chapters.ch05_flexible_mirror.ext_trust.results import (
    PRIOR_RUNS,
    RUNS,
    STAGES,
    SUPPORT_RUNS,
    SURFACES,
    WAYS,
    angles,
    not_refused,
    refusals,
)
from chapters.ch05_flexible_mirror.ext_trust.trials.scene import PRIORS
from chapters.ch05_flexible_mirror.ext_trust.trials.sweeps import PRIORS_MM, REACHES
from repro.judge.statistics import median_interval
from repro.page.style import INK, legend_below, plot_estimates, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

COURSES = {
    "plain": ("stage by stage, no prior", series(0)),
    "prior": ("stage by stage, prior", series(1)),
    "prior.bundle": ("all stages together, prior", series(2)),
}
GUIDE = {"color": INK, "linestyle": ":", "marker": ""}
NO_PRIOR_MM = 3.0  # where the figure has "none"


@figure(
    "ext_mirror_trust_figure", needs=("ext_mirror_trust_runs",), evidence="synthetic"
)
def trust_figure(results):
    """Mean ray angle over the stages, smooth and uneven, on A and on B."""
    result, rows = results[RUNS], []
    drawn, axes = new_figure(2, 2, height_in=5.8, sharex=True, sharey="row")
    for row, (surface, condition) in zip(axes, SURFACES.items(), strict=True):
        for panel, geometry in zip(row, "AB", strict=True):
            for shift, (way, (label, look)) in enumerate(COURSES.items(), -1):
                found = angles(result, way, condition, geometry)
                rows += plot_estimates(
                    panel, np.add(STAGES, 0.06 * shift), found,
                    (geometry, surface, label), look=look, label=label, bars=True,
                )  # fmt: skip
            panel.set_title(f"{geometry}, {surface}")
        row[0].set_ylim(bottom=0)
        row[0].set_ylabel("Mean ray angle (degrees)")
    for panel in axes[1]:
        panel.set_xticks(list(STAGES))
        panel.set_xlabel("Stage, 5 mm each (1)")
    legend_below(drawn, axes[0, 0], ncols=3)
    return Drawing(
        drawn,
        columns(("geometry", "surface", "way", "stage", "deg", "low", "high"), rows),
        "Error of the rays over three deflections, stage by stage without and with a "
        "prior, and with all stages adjusted together: mean angles to the true rays "
        "over the whole mirror. Medians over "
        f"{result.trials_per_condition} seeds with 95 % intervals.",
    )


@figure(
    "ext_mirror_coverage_figure", needs=("ext_mirror_trust_runs",), evidence="synthetic"
)
def coverage_figure(results):
    """True over predicted error of the rays at stage 3, a point for each seed."""
    result, rows = results[RUNS], []
    drawn, axes = new_figure(1, 2, height_in=4.0, sharex=True, sharey=True)
    for panel, geometry in zip(axes, "AB", strict=True):
        ends = []
        for number, (label, name) in enumerate(
            (("stage by stage", "prior.stage3"),
             ("all stages together", "prior.bundle.stage3.whole"))
        ):  # fmt: skip
            for surface, condition in SURFACES.items():
                trials = result.select(geometry=geometry, **condition)
                x, y = (
                    trials.column(f"{name}.{kind}_deg")
                    for kind in ("predicted", "true")
                )
                look = series(number) | {"linestyle": ""}
                fill = "none" if condition["aberration_um"] else "full"
                said = f"{label}, {surface}"
                panel.plot(x, y, label=said, fillstyle=fill, **look)
                ends += [*x, *y]
                rows += [(geometry, said, *pair) for pair in zip(x, y, strict=True)]
        low, high = np.nanmin(ends) / 1.2, np.nanmax(ends) * 1.2
        panel.plot([low, high], [low, high], label="as predicted", **GUIDE)
        panel.set(xscale="log", yscale="log", title=geometry)
        panel.set_xlabel("Predicted ray error (degrees)")
    axes[0].set_ylabel("True ray error (degrees)")
    legend_below(drawn, axes[0], ncols=2)
    return Drawing(
        drawn,
        columns(("geometry", "prediction", "predicted_deg", "true_deg"), rows),
        "What a calibration predicts of its rays at stage 3, and how far they are off: "
        "root mean squares over the whole mirror, a point for each seed. Above the "
        "dotted line more was promised than kept. Both axes are logarithmic.",
    )


@figure(
    "ext_mirror_support_figure",
    needs=("ext_mirror_support_runs",),
    evidence="synthetic",
)
def support_figure(results):
    """Error at the free edge and residual, as corners there are taken away."""
    result, rows = results[SUPPORT_RUNS], []
    drawn, axes = new_figure(2, 2, height_in=5.4, sharex="col", sharey="row")
    places = np.arange(len(REACHES))
    for column, geometry in zip(axes.T, "AB", strict=True):
        trials = result.select(geometry=geometry)
        for panel, name in zip(column, ("edge_deg", "residual_mm"), strict=True):
            for number, way in enumerate(PRIORS):
                found = [not_refused(trials, k, way, name) for k in range(len(REACHES))]
                rows += plot_estimates(
                    panel, places + 0.1 * number, found, (geometry, way, name),
                    look=series(number), label=WAYS[way], bars=True,
                )  # fmt: skip
        counts = [_corners(trials, k) for k in range(len(REACHES))]
        said = ["all", *(f"{reach:g}" for reach in REACHES[1:])]
        column[0].set(title=geometry, yscale="log")
        column[1].set_xticks(
            places, [f"{s}\n({n})" for s, n in zip(said, counts, strict=True)]
        )
        column[1].set_xlabel("Reach of the corners (1)")
    axes[0, 0].set_ylabel("Ray error at the edge (degrees)")
    axes[1, 0].set_ylabel("Residual (mm)")
    axes[1, 0].set_ylim(bottom=0)
    legend_below(drawn, axes[0, 0], ncols=2)
    refused = "; ".join(
        f"{geometry}: {', '.join(map(str, refusals(result, geometry)))}"
        for geometry in "AB"
    )
    return Drawing(
        drawn,
        columns(("geometry", "way", "what", "place", "median", "low", "high"), rows),
        "What happens where no corner reaches the free edge: rays there are wrong by "
        "degrees (above, logarithmic), and the residual says nothing (below). Reach: "
        "share of the knot interval next to the free edge in which corners are kept, "
        "in brackets how many these are. Stage 1, with the prior and without; medians "
        f"of the seeds that were not refused, of {result.trials_per_condition}, with "
        f"95 % intervals. Refused without the prior, from left to right: {refused}.",
    )


def _corners(trials, k):
    """Median number of corners in the interval next to the free edge."""
    return int(np.nanmedian(trials.column(f"reach{k}.prior.features")))


@figure(
    "ext_mirror_prior_figure", needs=("ext_mirror_prior_runs",), evidence="synthetic"
)
def prior_figure(results):
    """Mean ray angle at stage 3 against the strength of the prior."""
    result, rows = results[PRIOR_RUNS], []
    drawn, axes = new_figure(height_in=3.9)
    x = [NO_PRIOR_MM if sd is None else sd for sd in PRIORS_MM.values()]
    cases = [(g, name) for g in "AB" for name in SURFACES]
    for number, (geometry, surface) in enumerate(cases):
        trials = result.select(geometry=geometry, **SURFACES[surface])
        found = [median_interval(trials.column(f"{p}.angle_deg")) for p in PRIORS_MM]
        label = f"{geometry}, {surface}"
        apart = np.multiply(x, 1.06 ** (number - 1.5))
        rows += plot_estimates(
            axes, apart, found, (geometry, surface), look=series(number), label=label,
            bars=True,
        )  # fmt: skip
    axes.axvline(PRIORS["prior"], label="chosen", **GUIDE)
    axes.set(xscale="log", xlabel="Standard deviation of the prior (mm)")
    axes.set_ylabel("Mean ray angle, stage 3 (degrees)")
    axes.set_ylim(bottom=0)
    axes.set_xticks(
        x, ["none" if sd is None else f"{sd:g}" for sd in PRIORS_MM.values()]
    )
    axes.minorticks_off()
    legend_below(drawn, axes, ncols=3)
    return Drawing(
        drawn,
        columns(("geometry", "surface", "sd_mm", "median_deg", "low", "high"), rows),
        "What a prior on the bending does to the rays at stage 3, from a strong one "
        "(left) to none (right), on seeds that no other run has. Medians over "
        f"{result.trials_per_condition} seeds with 95 % intervals; the horizontal axis "
        "is logarithmic.",
    )
