"""Fig. 4.6: where best-fit rays cross the plane through the estimated centre."""

from itertools import product

import numpy as np

from chapters.ch04_central_generic.s3_2_results.results import CAMERAS, RENDERED
from chapters.shared.methods import LINEAR_NAMES
from repro.page.style import figure as new_figure
from repro.page.style import legend_below
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

PANELS = ("as_printed", "cgsp")
SHOWN = 0.98  # share of the points inside a panel


@figure("fig_4_6", needs=("table_4_3_rendered",), evidence="rendered")
def fig_4_6(results):
    """Two cameras by two methods, of the first rendered set each."""
    result = results[RENDERED]
    drawn, axes = new_figure(2, 2, height_in=7.0)
    rows = []
    panels = product(CAMERAS.values(), PANELS)
    for panel, (camera, method) in zip(axes.flat, panels, strict=True):
        x, y, apart = result.select(camera=camera).arrays(f"{method}.crossing")[0].T
        for good, colour, label in (
            (apart < 1, "#e69f00", "points close together"),
            (apart > 0, "#0072b2", "points apart"),
        ):
            panel.plot(
                x[good], y[good], ".", color=colour, ms=2, alpha=0.5, label=label
            )
        panel.plot(0, 0, "+", color="#d00000", ms=14, mew=2, label="centre")
        reach = 1.15 * np.quantile(np.maximum(abs(x), abs(y)), SHOWN)
        panel.set(
            xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal",
            title=f"{camera}: {LINEAR_NAMES[method]}",
            xlabel="x (mm)", ylabel="y (mm)",
        )  # fmt: skip
        panel.title.set_fontsize(9)
        points = zip(x.tolist(), y.tolist(), apart.tolist(), strict=True)
        rows += [(camera, LINEAR_NAMES[method], *point) for point in points]
    legend_below(drawn, axes[0, 0], ncols=3)
    return Drawing(
        drawn,
        columns(("camera", "method", "x_mm", "y_mm", "apart"), rows),
        "Where the lines that fit best to the three points of each ray cross the "
        "plane across them through the estimated centre (red cross), as the linear "
        "stages come out, before any adjustment. Orange: rays whose three points lie "
        "within a tenth of their distance, where grids cross; their lines hardly "
        "have a direction. Each panel has its own scale and holds 98 % of the "
        "points; about 3000 rays are drawn.",
    )
