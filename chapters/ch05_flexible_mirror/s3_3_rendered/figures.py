"""The board in the bent mirror with the corners found, and rays over the stages."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_rendered.results.runs import (
    LABORATORY,
    RENDERED,
    STAGES,
    drawn_value,
    runs_of,
)
from chapters.shared.mirror_bench import BENCH
from chapters.shared.mirror_rigs import STAGES_MM
from repro.judge.statistics import median_interval
from repro.page.style import figure as new_figure
from repro.page.style import legend_below, plot_estimates, series
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing

FOUND = {"marker": "o", "ms": 3.2, "mfc": "none", "ls": "", "color": "#d62728"}
WHEN = ("before", "after")
DRAWN = {"published": series(0), "aimed": series(1)}
TICKS_DEG = (0.01, 0.02, 0.05, 0.1, 0.2, 0.5, 1.0, 2.0, 5.0)
WORDS = {"published": "as published", "aimed": "as aimed at"}


@figure("ext_mirror_rendered_board", needs=("table_5_1_rendered",), evidence="rendered")
def board_figure(results):
    """What the detector found before and after the first step and the last."""
    result = results[RENDERED]
    trials, last = result.select(geometry="A", bench=BENCH), result.settings["steps"]
    steps = sorted({1, last})
    drawn, axes = new_figure(len(steps), 2, height_in=2.75 * len(steps), squeeze=False)
    rows = []
    for row, k in zip(axes, steps, strict=True):
        for panel, when, stage in zip(row, WHEN, (k - 1, k), strict=True):
            picture = trials.arrays(f"step{k}.{when}.picture")
            corners = trials.arrays(f"step{k}.{when}.corners")
            panel.set(xticks=[], yticks=[])
            panel.set_title(f"step {k}, {when}: {STAGES_MM[stage]:g} mm")
            if picture:
                panel.imshow(picture[0], cmap="gray", vmin=0, vmax=255)
                panel.plot(*corners[0].T, **FOUND)
                rows.append((k, when, len(corners[0])))
    return Drawing(
        drawn,
        columns(("step", "when", "corners_found"), rows),
        "The chessboard in the uneven mirror of geometry A on the bench, as rendered, "
        "and the corners that the detector found in it. Clamped at the right, pushed "
        "at the left. The board reaches beyond the mirror, and after a deflection "
        "other squares are at its edges: which corner is which is told by the clamp, "
        "where the picture stays. The window that the mirror fills, made smaller.",
    )


@figure(
    "ext_mirror_rendered_rays",
    needs=(
        "table_5_1_rendered",
        "table_5_1_runs",
        "table_5_1_other",
        "ext_mirror_trust_runs",
    ),
    evidence="rendered",
)
def rays_figure(results):
    """Mean ray angles of every rendered run beside those of many seeds."""
    result, rows = results[RENDERED], []
    drawn, axes = new_figure(2, 2, height_in=5.8, sharex=True, sharey="row")
    for row, bench in zip(axes, (BENCH, LABORATORY), strict=True):
        for panel, geometry in zip(row, "AB", strict=True):
            panel.set_title(f"{geometry}, {bench}")
            for way, look in DRAWN.items():
                rows += _of_many(panel, results, way, geometry, bench, look)
                rows += _of_runs(panel, result, way, geometry, bench, look)
        row[0].set_yscale("log")
        row[0].set_ylabel("Mean ray angle (degrees)")
        ends = row[0].get_ylim()
        row[0].set_yticks(TICKS_DEG, [f"{tick:g}" for tick in TICKS_DEG])
        row[0].minorticks_off()
        row[0].set_ylim(ends)
    for panel in axes[1]:
        panel.set_xticks(list(STAGES))
        panel.set_xlabel("Stage, 5 mm each (1)")
    # The laboratory has both ways, drawn and rendered.
    legend_below(drawn, axes[1, 0], ncols=2)
    return Drawing(
        drawn,
        columns(("geometry", "bench", "series", "stage", "deg", "low", "high"), rows),
        "Mean angle between calibrated and true rays over the whole mirror. Points: "
        "runs from rendered pictures, end to end. Bands: the median of the runs with "
        "drawn errors, with its 95 % interval; as published on both benches, as aimed "
        "at in the laboratory with 0.2 px at every corner. The vertical axes are "
        "logarithmic.",
    )


def _of_many(panel, results, way, geometry, bench, look):
    values = [
        drawn_value(results, way, geometry, bench, k, "angle_deg") for k in STAGES
    ]
    if values[0] is None:
        return []
    found = [median_interval(one) for one in values]
    label = f"{WORDS[way]}, drawn errors"
    return plot_estimates(
        panel, STAGES, found, (geometry, bench, label), label=label,
        look=look | {"marker": ""},
    )  # fmt: skip


def _of_runs(panel, result, way, geometry, bench, look):
    trials = runs_of(result, geometry, bench)
    if trials is None:
        return []
    label = f"{WORDS[way]}, from pictures"
    angles = np.array([trials.column(f"{way}.stage{k}.angle_deg") for k in STAGES])
    shift = 0.05 if way == "aimed" else -0.05
    for number, run in enumerate(angles.T):
        panel.plot(
            np.add(STAGES, shift), run, **look | {"linestyle": ""},
            label=label if number == 0 else None,
        )  # fmt: skip
    return [
        (geometry, bench, label, k, float(angle), np.nan, np.nan)
        for k, runs in zip(STAGES, angles, strict=True)
        for angle in runs
        if np.isfinite(angle)
    ]
