"""Fig. 4.6, and the factor of the bench's noise."""

from itertools import product

import numpy as np
from matplotlib.ticker import MaxNLocator

from chapters.ch04_central_generic.s3_2_results.results import CAMERAS, RENDERED
from chapters.ch04_central_generic.s3_2_results.trials import MULTIPLIED, solved
from chapters.shared.bench_noise import BENCH, NOISES
from chapters.shared.methods import LINEAR_NAMES
from repro.page.style import INK, legend_below, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

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
        "stages come out, before any adjustment, at the bench's noise. Orange: rays "
        "whose three points lie within a tenth of their distance, where grids cross; "
        "their lines hardly have a direction. Both panels of a camera have one scale, "
        f"and hold at least {100 * SHOWN:.0f} % of the points; the share outside is "
        "written in each. About 3000 rays are drawn.",
    )


def crossings(result, camera, method):
    """x, y (N,) mm on the plane through the centre, and 1 where points are apart."""
    return result.select(camera=camera).arrays(f"{BENCH}.{method}.crossing")[0].T


def shown_reach(result, camera):
    """Half the side of a camera's panels, mm: SHOWN of its widest scatter and more."""
    return 1.15 * max(
        np.quantile(np.maximum(abs(x), abs(y)), SHOWN)
        for x, y, _ in (crossings(result, camera, method) for method in PANELS)
    )


SOLVED_FROM = ("t4_3_omni_cgsp_mean_pre",)
NEAR = 0.01
TICKS_MM = (0.02, 0.05, 0.1, 0.2)
WORDS = {"bench": "alike over 7 x 7 pixels", "white": "white"}


@figure(
    "ext_bench_factor",
    needs=("bench_factor",),
    evidence="rendered",
    published=SOLVED_FROM,
)
def ext_bench_factor(results, published):
    """CGSP's ray-point error against the factor, and where it is the printed one."""
    result, printed = results["bench_factor"], published[SOLVED_FROM[0]]
    drawn, axes = new_figure(1, 1, height_in=3.2)
    rows, said, gaps = [], [], []
    for index, (noise, words) in enumerate(WORDS.items()):
        means = np.array(result.arrays("mean_mm", noise=noise))
        medians = np.median(means, axis=0)
        factor, chosen = solved(result, printed, noise), NOISES[noise].factor
        reached = np.median(result.column("chosen_mm", noise=noise))
        axes.plot(MULTIPLIED, medians, label=words, **series(index))
        axes.plot(chosen, reached, "+", color=INK, ms=13, mew=2)
        rows += [(words, *row) for row in zip(MULTIPLIED, medians, strict=True)]
        gaps.append(abs(reached / printed - 1))
        where = "nowhere" if factor is None else f"at {factor:.3g}"
        said.append(f"{words} {where}, {chosen:g} is taken")
    axes.axhline(printed, color=INK, lw=1.0, ls="--", label="printed")
    axes.set(
        xscale="log", yscale="log",
        xlabel="Factor of the decoding errors (1)", ylabel="Mean ray-point error (mm)",
    )  # fmt: skip
    axes.set_xticks(MULTIPLIED, [f"{m:g}" for m in MULTIPLIED])
    axes.set_yticks(TICKS_MM, [f"{mm:g}" for mm in TICKS_MM])
    axes.minorticks_off()
    axes.legend()
    check = Check(
        max(gaps) <= NEAR,
        f"at the factors the median is within {100 * max(gaps):.1f} % of the printed "
        "number",
    )
    return Drawing(
        drawn,
        columns(("errors", "factor", "mean_mm"), rows),
        "The mean distance of points from their rays that CGSP leaves on the mirror, "
        "before adjustment, when the laboratory's decoding errors are multiplied: "
        f"median over {result.trials_per_condition} seeds. It is the printed "
        f"{printed:g} mm at a factor: {'; '.join(said)} (crosses). The factor was "
        "solved at full size.",
        check if result.trials_per_condition > 3 else None,
    )
