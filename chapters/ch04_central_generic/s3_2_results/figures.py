"""Fig. 4.6, and the factor of the thesis-matched level."""

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
MIN_SHARE = 0.98  # of the points inside a panel
TICKS = 5


@figure("fig_4_6", needs=("table_4_3_rendered",), evidence="rendered")
def fig_4_6(results):
    """Draw two cameras by two methods, each from the first rendered run."""
    result = results[RENDERED]
    drawn, axes = new_figure(2, 2, height_in=7.2, sharex="row", sharey="row")
    rows = []
    panels = product(CAMERAS.values(), PANELS)
    for panel, (camera, method) in zip(axes.flat, panels, strict=True):
        x, y, apart = crossings(result, camera, method)
        for good, colour, label in (
            (apart < 1, "#e69f00", "close points"),
            (apart > 0, "#0072b2", "separated points"),
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
        "Crossings of the rays with the plane through the estimated centre (red "
        "cross): each ray is the line fitted to its three points, and the plane is the "
        "one most nearly perpendicular to the rays. Linear stage without adjustment, "
        "thesis-matched level. Orange: rays whose three points span less than a tenth "
        "of their distance, near grid crossings, so that the line is nearly "
        "undetermined. Both panels of a camera have one scale and contain at least "
        f"{100 * MIN_SHARE:.0f} % of the points; the share outside is stated. About "
        "3000 rays are drawn.",
    )


def crossings(result, camera, method):
    """Return x, y (N,) mm on the plane, and 1 where a ray's points are separated."""
    return result.select(camera=camera).arrays(f"{BENCH}.{method}.crossing")[0].T


def shown_reach(result, camera):
    """Return half the side of a camera's panels, mm, to hold MIN_SHARE of each."""
    return 1.15 * max(
        np.quantile(np.maximum(abs(x), abs(y)), MIN_SHARE)
        for x, y, _ in (crossings(result, camera, method) for method in PANELS)
    )


SOLVED_FROM = ("t4_3_omni_cgsp_mean_pre",)
NEAR = 0.01
TICKS_MM = (0.02, 0.05, 0.1, 0.2)
WORDS = {"bench": "correlated over 7 x 7 pixels", "white": "white"}


@figure(
    "ext_bench_factor",
    needs=("bench_factor",),
    evidence="rendered",
    published=SOLVED_FROM,
)
def ext_bench_factor(results, published):
    """Draw CGSP's ray-point error against the factor, and the factor solved."""
    result, printed = results["bench_factor"], published[SOLVED_FROM[0]]
    drawn, axes = new_figure(1, 1, height_in=3.2)
    rows, solutions, gaps = [], [], []
    for index, (noise, words) in enumerate(WORDS.items()):
        means = np.array(result.arrays("mean_mm", noise=noise))
        medians = np.median(means, axis=0)
        factor, chosen = solved(result, printed, noise), NOISES[noise].factor
        reached = np.median(result.column("chosen_mm", noise=noise))
        axes.plot(MULTIPLIED, medians, label=words, **series(index))
        axes.plot(chosen, reached, "+", color=INK, ms=13, mew=2)
        rows += [(words, *row) for row in zip(MULTIPLIED, medians, strict=True)]
        gaps.append(abs(reached / printed - 1))
        solution = "no solution" if factor is None else f"{factor:.3g}"
        solutions.append(f"{words}, {solution} ({chosen:g} is used)")
    axes.axhline(printed, color=INK, lw=1.0, ls="--", label="printed")
    axes.set(
        xscale="log", yscale="log",
        xlabel="Factor of the decoding errors (×)", ylabel="Mean ray-point error (mm)",
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
        "Mean ray-point error of CGSP on the mirror camera, before adjustment, against "
        "the factor that multiplies the simulator's decoding errors: median over "
        f"{result.trials_per_condition} runs. The factors that give the printed "
        f"{printed:g} mm (crosses): {'; '.join(solutions)}. They are solved at full "
        "size.",
        check if result.trials_per_condition > 3 else None,
    )
