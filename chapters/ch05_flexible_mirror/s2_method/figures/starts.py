"""Where the refinement starts, and where it ends."""

import numpy as np
from matplotlib.ticker import FixedFormatter

from chapters.ch05_flexible_mirror.s2_method.results import BOTH, SAME, Starts
from chapters.shared.mirror_bench import CONTRASTED, LEVEL, SAID
from chapters.shared.mirror_rigs import STAGES_MM
from repro.page.style import INK, legend_below, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

NAMES = {
    "before": "mirror\nas it was",
    "linear": "linear\nestimate",
    "true": "true\nsurface",
}
LOOKS = {"before": "mirror as it was", "linear": "linear estimate"}
MIN_SHOWN = 1e-8
SPREAD = 0.28


@figure("ext_linear_start", needs=BOTH, evidence="rendered")
def ext_linear_start(results):
    """Deflection at each start and where it leads; how equal the ends are."""
    drawn, (left, right) = new_figure(1, 2, height_in=3.8)
    on_bench = Starts.on(results, LEVEL)
    rows = _draw_ways(left, on_bench)
    for bench, line in zip(reversed(CONTRASTED), ("--", "-"), strict=True):
        of_bench = Starts.on(results, bench)
        for start, name in LOOKS.items():
            off = np.sort(of_bench.off(start, "cost_mm2"))
            share = np.arange(1, len(off) + 1) / len(off)
            right.plot(
                100 * np.maximum(off, MIN_SHOWN), share, linestyle=line, marker="",
                color=series(list(NAMES).index(start))["color"],
                label=f"{name}, {SAID[bench]}",
            )  # fmt: skip
    right.axvline(100 * SAME, color=INK, linestyle=":", marker="", label="1 %")
    right.set(xscale="log", xlabel="Difference of the final costs (%)")
    right.set_ylabel("Share of the runs")
    legend_below(drawn, right, ncols=2)
    return Drawing(
        drawn,
        columns(("seed", "start", "start_mm", "end_mm", "cost_mm2", "steps"), rows),
        "Refinement from three starts: the linear estimate, the true surface, and the "
        "mirror before the deflection. Left: deflection at the start (hollow) and "
        "after the refinement (filled), one line for each run, at the second solved "
        "level; dotted: the true 5 mm. Right: cumulative share of the runs over the "
        "relative difference of the final cost from that of the start at the true "
        "surface.",
    )


def _draw_ways(axes, starts):
    """Rows of the data: (seed, start, start_mm, end_mm, cost_mm2, steps)."""
    rows = []
    for place, start in enumerate(NAMES):
        from_mm, to_mm, cost, steps = (
            starts.of(start, name)
            for name in ("start_mm", "deflection_mm", "cost_mm2", "steps")
        )
        at = place + SPREAD * np.linspace(-1, 1, len(from_mm))
        colour = series(place)["color"]
        axes.vlines(at, from_mm, to_mm, color=colour, linewidth=0.4)
        look = {"color": colour, "linestyle": "", "marker": "o", "markersize": 2.5}
        axes.plot(at, from_mm, **look, markerfacecolor="none")
        axes.plot(at, to_mm, **look)
        rows += [
            (seed, start, *values)
            for seed, values in enumerate(zip(from_mm, to_mm, cost, steps, strict=True))
        ]
    axes.axhline(STAGES_MM[1], color=INK, linestyle=":", marker="")
    axes.set_xticks(range(len(NAMES)))
    axes.xaxis.set_major_formatter(FixedFormatter(list(NAMES.values())))
    axes.set_ylabel("Deflection at the load (mm)")
    return rows
