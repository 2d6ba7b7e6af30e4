"""Results of this page read: values of the prose, figures, tables."""

from chapters.ch04_central_generic.ext_smooth_rays.experiment import CONDITIONS, METHODS
from repro.page import legend_below, look_of, new_figure, plot_estimates, value
from repro.run import Drawing, Measured, Table, columns, figure, median_interval, table

# Names of the methods, and the numbers that the page quotes.


NAMES = {
    "table": "table of rays",
    "formula": "radial law alone",
    "smooth": "smooth table",
    "direct": "adjusted directly",
}
NOISES = (0.25, 0.5, 1.0)


def median(result, method, measure, **condition):
    """Return the median over trials, an Estimate."""
    return median_interval(result.column(method, measure, **condition))


def name_values(open_results):
    """Name the numbers of the prose: bent lens, 0.5 px, three grids or ten (many)."""
    runs = open_results("ext_smooth_rays_runs")
    for name, method, measure, grids in (
        ("usual", "table", "left_px", 3),
        ("usual", "smooth", "left_px", 3),
        ("usual", "smooth", "off_px", 3),
        ("usual", "smooth", "normalised", 3),
        ("usual", "direct", "normalised", 3),
        ("many", "smooth", "off_px", 10),
    ):
        found = median(runs, method, measure, lens="bent", noise=0.5, grids=grids)
        value(f"{name}.{method}.{measure}", found.value)


# Ray errors of tables and fields.


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
            found = [
                median(result, method, measure, lens="bent", noise=noise, grids=3)
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


# All conditions in numbers.


@table(
    "ext_smooth_rays_honest_table",
    needs=("ext_smooth_rays_runs",),
    evidence="synthetic",
)
def smooth_rays_honest_table(results):
    """Errors of all methods, and squared errors relative to the predicted ones."""
    result = results["ext_smooth_rays_runs"]

    def cells(method, measure):
        return [Measured(*median(result, method, measure, **c)[:3]) for c in CONDITIONS]

    return Table(
        {
            "Lens": [c["lens"] for c in CONDITIONS],
            "Noise (px)": [c["noise"] for c in CONDITIONS],
            "Grids": [c["grids"] for c in CONDITIONS],
            **{f"{NAMES[method]} (px)": cells(method, "off_px") for method in METHODS},
            **{
                f"squared error / predicted, {NAMES[method]}": cells(
                    method, "normalised"
                )
                for method in ("smooth", "direct")
            },
        },
        "Distance in the image after one rotation of all rays (RMS over 999 "
        "rays), and squared errors relative to the predicted variances (1 if "
        "the predictions are correct): medians over "
        f"{result.trials_per_condition} trials with 95 % intervals.",
    )
