"""Figure of section 4.1.3: error of the rays against the weights."""

from matplotlib.ticker import FixedLocator, NullLocator

from chapters.ch04_central_generic.s1_3_rays.results import VARIANCE, ray_error
from chapters.ch04_central_generic.s1_3_rays.trials import FACTORS, NOISE, POSED
from repro.page.style import figure as new_figure
from repro.page.style import legend_below, plot_estimates, series
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing


@figure("ext_ray_weights", needs=("ext_ray_weights_trials",), evidence="synthetic")
def ray_weights(results):
    """Error of rays against the weight of the linear stage's grids."""
    result = results["ext_ray_weights_trials"]
    drawn, axes = new_figure(1, 2, height_in=4.0)
    rows = []
    for panel, domain in zip(axes, NOISE, strict=True):
        for index, posed in enumerate(POSED):
            found = [
                ray_error(result, f"{factor:g}", domain, posed) for factor in FACTORS
            ]
            label = f"other poses from {posed} rays"
            look = series(index)
            drawn_rows = plot_estimates(panel, FACTORS, found, look=look, label=label)
            best = ray_error(result, VARIANCE, domain, posed)
            panel.axhline(best.value, color=look["color"], lw=1, ls=":")
            rows += [(domain, posed, f"{at:g}", *row) for at, *row in drawn_rows]
            rows.append((domain, posed, VARIANCE, *best[:3]))
        panel.set(
            xscale="log",
            xlabel="Weight of the linear grids, relative to others",
            ylabel="Ray-point distance, true points (mm)",
            title=f"noise {NOISE[domain]:g} {domain}",
        )
        panel.xaxis.set_major_locator(FixedLocator([0.125, 0.5, 1, 4, 16, 64]))
        panel.xaxis.set_minor_locator(NullLocator())
        panel.xaxis.set_major_formatter(lambda x, _: f"{x:g}")
        panel.set_ylim(bottom=0)
    legend_below(drawn, axes[0], ncols=2)
    return Drawing(
        drawn,
        columns(
            ("noise_in", "posed_from", "weights", "median_mm", "low", "high"), rows
        ),
        "Distance of the rays from the true points of six grids against the "
        "weight of the three linear grids in the centroid. The poses of the "
        "other three grids come from 6, 40 or 999 rays. Medians over trials "
        "with 95 % intervals. Dotted: weights from the predicted variance of "
        "every point. Left: noise in the image; right: noise on the grids.",
    )
