"""Results of this page read: values of the prose, figures, tables, judgements."""

import numpy as np

from chapters.ch04_central_generic.s1_3_rays.experiment import FACTORS, NOISE, POSED
from repro.page import legend_below, new_figure, plot_estimates, rounded, series, value
from repro.run import (
    Drawing,
    Reading,
    claim,
    columns,
    figure,
    median_interval,
    median_ratio,
)

# Estimates for the figure and the prose of section 4.1.3.


VARIANCE = "variance"


def ray_error(result, weights, domain, posed):
    """Return the median error of the rays (mm) with some weights, an Estimate."""
    return median_interval(result.column("ray_mm", posed, weights, domain=domain))


def factor_errors(result, domain, posed):
    """Return `ray_error` of every weight of FACTORS."""
    return [ray_error(result, f"{factor:g}", domain, posed) for factor in FACTORS]


def name_values(open_results):
    """Name the numbers that the prose quotes; image noise."""
    result = open_results("ext_ray_weights_trials")
    few, many = POSED[0], POSED[-1]
    best = {}
    for name, posed in (("few", few), ("many", many)):
        errors = [found.value for found in factor_errors(result, "px", posed)]
        best[name] = FACTORS[int(np.argmin(errors))]
        value(f"factor.{name}", best[name])
    for name, posed, weights in (
        ("few.one", few, ("1", f"{best['few']:g}")),
        ("many.gain", many, (f"{best['many']:g}", VARIANCE)),
    ):
        errors = result.column("ray_mm", posed, weights, domain="px")
        ratio = median_ratio(*errors, paired=True)
        value(name, rounded(ratio.value, (ratio.low, ratio.high)))
    for weights in (VARIANCE, "linear grids alone"):
        value(f"many.{weights}", ray_error(result, weights, "px", many).value)


# Figure of section 4.1.3: error of the rays against the weights.


@figure("ext_ray_weights", needs=("ext_ray_weights_trials",), evidence="synthetic")
def ray_weights(results):
    """Error of rays against the weight of the linear stage's grids."""
    from matplotlib.ticker import FixedLocator, NullLocator

    result = results["ext_ray_weights_trials"]
    drawn, axes = new_figure(1, 2, height_in=4.0)
    rows = []
    for panel, domain in zip(axes, NOISE, strict=True):
        for index, posed in enumerate(POSED):
            found = factor_errors(result, domain, posed)
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


# Test of the claim of section 4.1.3, as the registry states it.


@claim("c4_mats_intersection", needs=("exp_c4_mats_intersection",), evidence="analytic")
def judge_mats_intersection(results):
    """-M^T S, stacked, equals M_i S ray by ray, sign included."""
    result = results["exp_c4_mats_intersection"]
    largest = float(result.column(("printed", "stacked")).max())
    return Reading.of(
        largest < 1e-12,
        largest,
        reason="largest difference of a homogeneous coordinate, as a "
        "share of the point's largest; points differ from rays met with "
        f"the plane directly by {result.column('on_grid_mm').max():.1g} "
        "mm at most",
    )
