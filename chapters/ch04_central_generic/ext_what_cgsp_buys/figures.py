"""What each change brings, and what the centre's error depends on."""

import numpy as np
from matplotlib.ticker import FixedFormatter

from chapters.ch04_central_generic.ext_what_cgsp_buys.results import NAMES, centre
from chapters.ch04_central_generic.ext_what_cgsp_buys.trials import (
    GRIDS,
    OF_MANY_GRIDS,
    STEPS,
    SWEEPS,
)
from chapters.shared.methods import LINEAR_NAMES
from repro.page.method_looks import look_of
from repro.page.style import figure as new_figure
from repro.page.style import legend_below, plot_estimates, series
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

LABELS = {
    "tilt": ("tilt of the grids", "Euler angles up to (deg)"),
    "extent": ("size of the grids", "Half the side (mm)"),
    "rays": ("number of rays", "Rays (1)"),
}


@figure("ext_what_cgsp_buys_figure", needs=("ext_cgsp_steps",), evidence="synthetic")
def what_cgsp_buys(results):
    """The error of the centre after every change, from top to bottom."""
    result = results["ext_cgsp_steps"]
    drawn, axes = new_figure(height_in=3.4)
    found = [centre(result, method) for method in STEPS]
    rows = np.arange(len(found))[::-1]
    middle, low, high = np.array([e[:3] for e in found]).T
    look = series(0) | {"linestyle": ""}
    axes.errorbar(middle, rows, xerr=[middle - low, high - middle], capsize=3, **look)
    axes.set_yticks(rows)
    axes.yaxis.set_major_formatter(FixedFormatter([NAMES[method] for method in STEPS]))
    axes.set(xscale="log", xlabel="Median error of the centre (mm)")
    return Drawing(
        drawn,
        columns(
            ("method", "median_mm", "low_mm", "high_mm"),
            zip(STEPS, middle, low, high, strict=True),
        ),
        "Error of the camera's centre at 0.5 px of noise, from the standard "
        "linear stage as printed (top) to CGSP and beyond, with one change "
        "from line to line. Medians over trials with 95 % intervals; the "
        "axis is logarithmic.",
    )


@figure(
    "ext_cgsp_sensitivity_figure",
    needs=("ext_cgsp_grids", "ext_cgsp_sensitivity"),
    evidence="synthetic",
)
def cgsp_sensitivity(results):
    """Error of the centre against tilt, size, rays and grids."""
    drawn, axes = new_figure(2, 2, height_in=5.6)
    rows = []
    panels = [
        (results["ext_cgsp_sensitivity"], sweep, name, levels, LABELS[sweep])
        for sweep, (name, levels) in SWEEPS.items()
    ]
    panels.append(
        (
            results["ext_cgsp_grids"],
            None,
            "grids",
            GRIDS,
            ("number of grids", "Grids (1)"),
        )
    )
    for panel, (result, sweep, name, levels, words) in zip(
        axes.flat, panels, strict=True
    ):
        fixed = {"sweep": sweep} if sweep else {}
        for method in OF_MANY_GRIDS:
            found = [
                centre(result, method, **fixed, **{name: level}) for level in levels
            ]
            label = LINEAR_NAMES.get(method, NAMES[method])
            look = {"look": look_of(label), "label": label}
            rows += plot_estimates(
                panel, levels, found, (sweep or "grids", method), **look
            )
        panel.set(xscale="log", yscale="log", title=words[0], xlabel=words[1])
        panel.set_ylabel("Error of the centre (mm)")
        panel.set_xticks(levels, [f"{level:g}" for level in levels])
        panel.minorticks_off()
    legend_below(drawn, axes[0, 0], ncols=2)
    again = int(results["ext_cgsp_sensitivity"].select().column("drawn_again").sum())
    return Drawing(
        drawn,
        columns(("sweep", "method", "x", "median", "low", "high"), rows),
        "Error of the camera's centre at 0.5 px as one thing of the scene "
        "changes: how much the grids are tilted, how large they are, how "
        "many rays and how many grids there are. Medians over trials with "
        "95 % intervals; all axes are logarithmic. Small grids that no ray "
        f"meets together were drawn again, {again} times in all.",
    )
