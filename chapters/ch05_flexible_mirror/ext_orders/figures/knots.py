"""How large a step a number of knots bears, and how near the shape comes."""

import numpy as np

from chapters.ch05_flexible_mirror.ext_orders.results.knots import MOST_DEG, Knots
from chapters.ch05_flexible_mirror.ext_orders.trials.knots import (
    CORNER_PX,
    NOISE_FREE_MM,
    SHAPES,
    STEPS_MM,
)
from chapters.ch05_flexible_mirror.ext_orders.trials.shapes import name_of
from repro.judge.seeds import SHARE_OF_SEEDS
from repro.page.style import INK, legend_below, plot_estimates, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

UM = 1000


@figure("ext_knot_tradeoff", needs=("exp_c5_knot_tradeoff",), evidence="rendered")
def ext_knot_tradeoff(results):
    """Shares of seeds that bear a step, and the shape's error without noise."""
    knots, rows = Knots.of(results), []
    drawn, (left, right) = new_figure(1, 2, height_in=3.8)
    for number, shape in enumerate(SHAPES):
        shares, label = 100 * knots.shares(shape), name_of(shape)
        left.plot(STEPS_MM, shares, label=label, **series(number))
        rows += [(label, mm, share) for mm, share in zip(STEPS_MM, shares, strict=True)]
    left.axhline(
        100 * SHARE_OF_SEEDS, color=INK, ls=":", marker="", label="nine of ten"
    )
    left.set(xscale="log", xlabel="Step (mm)", ylim=(-3, 103))
    left.set_xticks(STEPS_MM, [f"{mm:g}" for mm in STEPS_MM])
    left.minorticks_off()
    left.set_ylabel(f"Seeds below {MOST_DEG:g} degree (%)")
    counts = [np.prod(shape) for shape in SHAPES]
    found = [knots.noise_free(shape).times(UM) for shape in SHAPES]
    plot_estimates(right, counts, found, look=series(0), label=None)
    right.set(yscale="log", xlabel="Functions along u x v (1)")
    right.set_xticks(counts, [name_of(shape) for shape in SHAPES])
    right.set_ylabel("Shape without noise off by (um)")
    rows += [
        (f"{name_of(shape)}, without noise", NOISE_FREE_MM, one.value)
        for shape, one in zip(SHAPES, found, strict=True)
    ]
    legend_below(drawn, left, ncols=5)
    return Drawing(
        drawn,
        columns(("series", "step_mm", "percent_or_um"), rows),
        "More knots come nearer to the mirror, and bear smaller steps. Left: share of "
        f"{len(knots.angles(SHAPES[0]))} seeds whose rays are off by less than "
        f"{MOST_DEG:g} degree on average after one step, with {CORNER_PX:g} px of "
        f"noise; of the others {knots.refused_percent():.0f} % were refused. Right: "
        "mean distance of the shape from the true mirror after a step of "
        f"{NOISE_FREE_MM:g} mm without any noise, medians with 95 % intervals.",
    )
