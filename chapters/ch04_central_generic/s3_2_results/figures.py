"""Fig. 4.6: where best-fit rays cross the plane through the estimated centre."""

from itertools import product

import numpy as np
from matplotlib.ticker import MaxNLocator

from chapters.ch04_central_generic.s3_2_results.results import CAMERAS, RENDERED
from chapters.shared.methods import LINEAR_NAMES
from repro.page.style import figure as new_figure
from repro.page.style import legend_below
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

PANELS = ("as_printed", "cgsp")
SHOWN = 0.98  # least share of the points inside a panel
TICKS = 5


@figure("fig_4_6", needs=("table_4_3_rendered",), evidence="rendered")
def fig_4_6(results):
    """Two cameras by two methods, of the first rendered set each."""
    result = results[RENDERED]
    drawn, axes = new_figure(2, 2, height_in=7.2, sharex="row", sharey="row")
    rows = []
    panels = product(CAMERAS.values(), PANELS)
    for panel, (camera, method) in zip(axes.flat, panels, strict=True):
        x, y, apart = crossings(result, camera, method)
        for good, colour, label in (
            (apart < 1, "#e69f00", "points close together"),
            (apart > 0, "#0072b2", "points apart"),
        ):
            panel.plot(
                x[good], y[good], ".", color=colour, ms=2, alpha=0.5, label=label
            )
        panel.plot(0, 0, "+", color="#d00000", ms=14, mew=2, label="centre")
        reach = shown_reach(result, camera)
        outside = np.mean(np.maximum(abs(x), abs(y)) > reach)
        panel.set(
            xlim=(-reach, reach), ylim=(-reach, reach), aspect="equal",
            title=f"{camera}:\n{LINEAR_NAMES[method]}",
            xlabel="x (mm)", ylabel="y (mm)",
        )  # fmt: skip
        for axis in (panel.xaxis, panel.yaxis):
            axis.set_major_locator(MaxNLocator(TICKS, prune="both"))
        panel.text(
            0.98, 0.02, f"outside: {100 * outside:.1f} %", ha="right", va="bottom",
            fontsize=8.5, transform=panel.transAxes,
        )  # fmt: skip
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
        "have a direction. Both panels of a camera have one scale, and hold at "
        f"least {100 * SHOWN:.0f} % of the points; the share outside is written in "
        "each. About 3000 rays are drawn.",
    )


def crossings(result, camera, method):
    """x, y (N,) mm on the plane through the centre, and 1 where points are apart."""
    return result.select(camera=camera).arrays(f"{method}.crossing")[0].T


def shown_reach(result, camera):
    """Half the side of a camera's panels, mm: SHOWN of its widest scatter and more."""
    return 1.15 * max(
        np.quantile(np.maximum(abs(x), abs(y)), SHOWN)
        for x, y, _ in (crossings(result, camera, method) for method in PANELS)
    )
