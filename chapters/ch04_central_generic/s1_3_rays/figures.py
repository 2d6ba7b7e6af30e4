"""The figure of section 4.1.3: what weights make of rays."""

from __future__ import annotations

import numpy as np
from matplotlib.ticker import FixedLocator, NullLocator

from chapters.ch04_central_generic.s1_3_rays.results import VARIANCE, ray_error
from chapters.ch04_central_generic.s1_3_rays.trials import FACTORS, NOISE, POSED
from repro.page.style import figure as new_figure
from repro.page.style import plot_interval, series
from repro.run.experiment import figure
from repro.run.outcomes import Drawing


@figure("ext_ray_weights", needs=("ext_ray_weights_trials",), evidence="synthetic")
def ray_weights(results):
    """Error of rays against the weight of the linear stage's grids."""
    result = results["ext_ray_weights_trials"]
    drawn, axes = new_figure(1, 2, height_in=4.0)
    names = ("noise_in", "posed_from", "weights", "median_mm", "low", "high")
    data = {name: [] for name in names}
    for panel, domain in zip(axes, NOISE, strict=True):
        for index, posed in enumerate(POSED):
            found = {
                weights: ray_error(result, weights, domain, posed)[:3]
                for weights in (*(f"{f:g}" for f in FACTORS), VARIANCE)
            }
            for weights, row in found.items():
                told = (domain, posed, weights, *row)
                for name, cell in zip(names, told, strict=True):
                    data[name].append(cell)
            best = found.pop(VARIANCE)[0]
            plot_interval(
                panel,
                np.array(FACTORS),
                *np.array(list(found.values())).T,
                index=index,
                label=f"other grids posed from {posed} rays",
            )
            panel.axhline(best, color=series(index)["color"], lw=1, ls=":")
        panel.set(
            xscale="log",
            xlabel="Weight of linear grids over others (1)",
            ylabel="Rays to true points (mm)",
            title=f"noise of {NOISE[domain]:g} {domain}",
        )
        panel.xaxis.set_major_locator(FixedLocator([0.125, 0.5, 1, 4, 16, 64]))
        panel.xaxis.set_minor_locator(NullLocator())
        panel.xaxis.set_major_formatter(lambda x, _: f"{x:g}")
        panel.set_ylim(bottom=0)
    handles, labels = axes[0].get_legend_handles_labels()
    drawn.legend(handles, labels, loc="outside lower center", ncols=2)
    return Drawing(
        drawn,
        data,
        "Distance of the rays from the true points of six grids, against the "
        "weight that the three grids of the linear stage have in the "
        "centroid; the other three were posed from a number of rays. Medians "
        "over trials with 95 % intervals. Dotted: weights from the variance "
        "of every point. Noise is drawn in the image (left) or on the grids.",
    )
