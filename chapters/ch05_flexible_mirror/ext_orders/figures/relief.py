"""Relief at stage 0 with few functions and with many."""

import numpy as np

from chapters.ch05_flexible_mirror.ext_orders.results.relief import ReliefRuns
from chapters.ch05_flexible_mirror.ext_orders.trials.relief import RELIEFS_UM, SHAPES
from chapters.ch05_flexible_mirror.ext_orders.trials.shapes import name_of
from repro.page.style import figure as new_figure
from repro.page.style import legend_below, plot_estimates, series
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

MEASURES = {
    "back_mm": "Back-projection, own pose (mm)",
    "residual_mm": "Residual of the primary stage (mm)",
    "angle_deg": "Rays off the true ones (deg)",
}


@figure("ext_high_order", needs=("exp_c5_high_order",), evidence="rendered")
def ext_high_order(results):
    """Three measures of the primary stage, smooth and with relief."""
    relief, rows = ReliefRuns.of(results), []
    drawn, axes = new_figure(1, 3, height_in=3.4)
    counts = [np.prod(shape) for shape in SHAPES]
    for panel, (name, label) in zip(axes, MEASURES.items(), strict=True):
        for number, (mirror, height_um) in enumerate(RELIEFS_UM.items()):
            found = [relief.estimate(mirror, shape, name) for shape in SHAPES]
            said = f"relief of {height_um:g} um" if height_um else "smooth mirror"
            rows += plot_estimates(
                panel, counts, found, (label, said), look=series(number), label=said
            )
        panel.set(ylabel=label, ylim=(0, None), xlabel="Functions along u x v (1)")
        panel.set_xticks(counts, [name_of(shape) for shape in SHAPES])
    legend_below(drawn, axes[0], ncols=2)
    return Drawing(
        drawn,
        columns(("measure", "mirror", "functions", "median", "low", "high"), rows),
        "What relief leaves at stage 0, and what of it more functions follow: the "
        "error on a board in the pose that the camera itself finds, as in Fig. "
        "5.13(a), the refinement's own distances, and the rays beside the true ones. "
        "The laboratory's errors; medians with 95 % intervals.",
    )
