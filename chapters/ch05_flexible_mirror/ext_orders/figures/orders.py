"""Residual, its whiteness, kept-out error and rays, order by order."""

from chapters.ch05_flexible_mirror.ext_orders.results.orders import (
    ORDERS,
    WORDS,
    courses,
    published_of,
)
from raxel.calibration.mirror.whiteness import BOUND
from repro.page.style import INK, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figures
from repro.run.outcomes import Drawing

KINDS = {
    "ext_orders_primary": ("primary", "the primary stage, from a monitor's pixels"),
    "ext_orders_stage": ("stage", "one step of 5 mm, from a chessboard's corners"),
}
PANELS = {
    "Residual (mm)": {"residual_mm": "fitted", "kept_mm": "kept out"},
    "Excess of neighbours (1)": {"excess": None},
    "Rays off (deg)": {"angle_deg": None},
}
LINEAR = 5.0  # below it the axis of the excess is linear
TICKS = (-10, 0, 10, 100)
PUBLISHED_SIZE = 21


@figures(
    ("ext_orders_primary", "ext_orders_stage"),
    needs=("ext_orders_runs",),
    evidence="rendered",
)
def orders_figure(results, identifier):
    """Three measures along the orders, for three mirrors, a line for each seed."""
    stage, words = KINDS[identifier]
    drawn, axes = new_figure(3, 3, height_in=6.6, sharex="col", sharey="row")
    rows = []
    for column, (case, title) in zip(axes.T, WORDS.items(), strict=True):
        column[0].set_title(title.replace(", ", ",\n"), fontsize=9)
        found = courses(results, case, stage)
        for panel, (label, names) in zip(column, PANELS.items(), strict=True):
            for number, (name, said) in enumerate(names.items()):
                rows += _draw(panel, found, name, said, number, case)
            panel.set_ylabel(label if case == "smooth" else "")
        column[0].set_yscale("log")
        column[2].set_yscale("log")
        column[1].set_yscale("symlog", linthresh=LINEAR)
        column[1].set_yticks(TICKS, [f"{tick:g}" for tick in TICKS])
        column[1].axhline(BOUND, color=INK, ls=":", marker="", label="bound")
        column[2].set_xlabel("Coefficients (1)")
    _legend(drawn, axes[0, 0], axes[1, 0])
    return Drawing(
        drawn,
        columns(("case", "seed", "measure", "coefficients", "value", "chosen"), rows),
        f"Orders raised step by step: {words}. Above: residual for each degree of "
        "freedom, and that of the fifth of the features that were kept out. Middle: by "
        "how many standard deviations neighbouring residuals agree better than noise's "
        "would after the same fit; white below the dotted line. Below: mean angle to "
        "the true rays. A line for each of "
        f"{results[ORDERS].trials_per_condition} seeds; large markers: the first order "
        "with white residuals, where there is one; crosses: 7 x 3 quadratic functions, "
        "as published.",
    )


def _draw(panel, found, name, said, number, case):
    """Lines of all seeds; their rows of the data."""
    rows, look = [], series(number)
    for seed, one in enumerate(found):
        x, y = one.values("size"), one.values(name)
        panel.plot(
            x, y, label=said if seed == 0 else None, color=look["color"], lw=1.0,
            marker=".", ms=3,
        )  # fmt: skip
        panel.plot(
            x[one.white], y[one.white], ls="", color=look["color"], ms=7,
            marker=look["marker"] if one.white >= 0 else "",
        )  # fmt: skip
        rows += [
            (case, seed, name, *pair, int(step == one.white))
            for step, pair in enumerate(zip(x, y, strict=True))
        ]
    for value in published_of(found, name):
        panel.plot(PUBLISHED_SIZE, value, ls="", marker="x", ms=5, color=look["color"])
        rows.append((f"{case}, published", 0, name, PUBLISHED_SIZE, value, 0))
    return rows


def _legend(drawn, *panels):
    found = {}
    for panel in panels:
        handles, labels = panel.get_legend_handles_labels()
        found |= dict(zip(labels, handles, strict=True))
    drawn.legend(
        found.values(), found.keys(), loc="outside lower center", ncols=len(found)
    )
