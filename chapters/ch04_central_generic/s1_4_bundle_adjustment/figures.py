"""The figures of section 4.1.4: consistency, and where a freed centre ends."""

import numpy as np
from matplotlib.ticker import NullFormatter

from chapters.ch04_central_generic.s1_4_bundle_adjustment.results import (
    CURVES,
    NAMES,
    centre_medians,
)
from repro.page.method_looks import look_of
from repro.page.style import INK, legend_below, plot_estimates
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

TITLES = {
    "line_fitting": "line fitting",
    "ray_point": "ray-point distances",
    "consistent": "consistent",
}


@figure(
    "ext_consistent_adjustment", needs=("ext_consistency_sweep",), evidence="synthetic"
)
def consistency(results):
    """Centre error against the number of rays, at two sizes of noise."""
    result = results["ext_consistency_sweep"]
    drawn, axes = new_figure(1, 2, height_in=4.0)
    rows = []
    for panel, (noise, methods) in zip(axes, CURVES.items(), strict=True):
        for method in methods:
            rays, found = centre_medians(result, method, noise)
            look = {"look": look_of(NAMES[method]), "label": NAMES[method]}
            rows += plot_estimates(panel, rays, found, (noise, method), **look)
        few, many = rays[0], rays[-1]
        panel.plot(
            [few, many], found[0].value * np.sqrt(few / np.array([few, many])),
            color=INK, lw=1, ls=":", marker="", label="falls as $1/\\sqrt{N}$",
        )  # fmt: skip
        panel.set(xscale="log", yscale="log", xlabel="Rays (1)")
        panel.xaxis.set_minor_formatter(NullFormatter())
        panel.set(title=f"noise of {noise:g} px", ylabel="Error of the centre (mm)")
    legend_below(drawn, axes[0], ncols=2)
    return Drawing(
        drawn,
        columns(("noise_px", "method", "rays", "median_mm", "low_mm", "high_mm"), rows),
        "Error of the camera's centre against the number of rays that three "
        "grids share: medians over trials with 95 % intervals. The dotted "
        "line is what the error of the consistent adjustment with fewest rays "
        "would become if noise alone made it. Schemes that lower distances "
        "from rays leave that line.",
    )


@figure(
    "ext_free_centre_starts", needs=("exp_c4_centre_ba_unstable",), evidence="synthetic"
)
def free_centre_starts(results):
    """Error of the centre at the end against that at the start."""
    result = results["exp_c4_centre_ba_unstable"]
    drawn, axes = new_figure(1, 3, height_in=3.4, sharex=True, sharey=True)
    rows, ends = [], []
    for panel, scheme in zip(axes, TITLES, strict=True):
        starts = result.arrays(f"{scheme}.starts_mm")
        found = result.arrays(f"{scheme}.ends_mm")
        look = look_of(TITLES[scheme]) | {"linestyle": "", "ms": 3, "alpha": 0.6}
        for scene, (x, y) in enumerate(zip(starts, found, strict=True)):
            panel.plot(x, y, **look)
            rows += [(scheme, scene, *run) for run in zip(x, y, strict=True)]
        ends += [*starts, *found]
        panel.set(xscale="log", yscale="log", title=TITLES[scheme])
        panel.set_xlabel("Error at the start (mm)")
    axes[0].set_ylabel("Error at the end (mm)")
    limits = np.array([np.min(ends), np.max(ends)])
    for panel in axes:
        panel.plot(limits, limits, color=INK, lw=1, ls=":", marker="")
    return Drawing(
        drawn,
        columns(("scheme", "scene", "start_mm", "end_mm"), rows),
        "Where an adjustment that frees the centre ends, against where it "
        "starts: one dot per start, the starts of a scene on the same data. "
        "Above the dotted line the centre is worse than before. The starts "
        "lie within the error of the linear stage. A scheme that forgets its "
        "start draws a level row for each scene.",
    )
