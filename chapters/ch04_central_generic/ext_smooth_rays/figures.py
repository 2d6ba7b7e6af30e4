"""Ray errors of tables and fields."""

from chapters.ch04_central_generic.ext_smooth_rays.results import NAMES, NOISES, median
from chapters.ch04_central_generic.ext_smooth_rays.trials import METHODS
from repro.page.method_looks import look_of
from repro.page.style import figure as new_figure
from repro.page.style import legend_below, plot_estimates
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

MEASURES = {
    "left_px": ("after a homography", "Residual, corrected view (px)"),
    "off_px": ("after a rotation", "Distance in the image (px)"),
}


@figure("ext_smooth_rays_figure", needs=("ext_smooth_rays_runs",), evidence="synthetic")
def smooth_rays_figure(results):
    """Both measures against noise, for every method."""
    result = results["ext_smooth_rays_runs"]
    drawn, panels = new_figure(1, 2, height_in=3.6)
    rows = []
    for axes, (measure, (title, label)) in zip(panels, MEASURES.items(), strict=True):
        for method in METHODS:
            name = f"{method}.{measure}"
            found = [
                median(result, name, lens="bent", noise=noise, grids=3)
                for noise in NOISES
            ]
            look = {"look": look_of(NAMES[method]), "label": NAMES[method]}
            rows += plot_estimates(axes, NOISES, found, (measure, method), **look)
        axes.set(xscale="log", yscale="log", title=title, ylabel=label)
        axes.set_xlabel("Noise (px)")
        axes.set_xticks(NOISES, [f"{noise:g}" for noise in NOISES])
        axes.minorticks_off()
    legend_below(drawn, panels[0], ncols=4)
    return Drawing(
        drawn,
        columns(("measure", "method", "noise_px", "median", "low", "high"), rows),
        "Ray errors against noise for four models: the ray table, the radial law "
        "fitted to it, the law with a smooth field fitted to the table, and the "
        "field adjusted together with the grid poses. Bent lens, three grids. "
        "RMS over 999 rays, medians over trials with 95 % intervals. Left: in "
        "the corrected view after the best homography. Right: in the image "
        "after one rotation of all rays.",
    )
