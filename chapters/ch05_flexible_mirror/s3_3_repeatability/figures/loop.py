"""Fig. 5.13, and how far off the mirror is from step to step."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_repeatability.results import predicates
from chapters.ch05_flexible_mirror.s3_3_repeatability.results.runs import (
    PANELS,
    PLACED,
    SCALE,
    STARTED,
    STEPS,
    LoopRuns,
)
from chapters.ch05_flexible_mirror.s3_3_repeatability.trials.run import LOOP
from chapters.ch05_flexible_mirror.s3_3_repeatability.trials.starts import STEPS_MM
from chapters.shared.mirror_bench import BENCH
from repro.judge.statistics import median_interval
from repro.page.style import INK, legend_below, plot_estimates, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

MARGIN_MM = 10.0
ROUNDING = 1e-9
BENCH_LOOKS = {"bench": series(0), "laboratory": series(1)}


@figure("fig_5_13", needs=("table_5_5_runs",), evidence="rendered")
def fig_5_13(results):
    """Vectors from the corners of a board to where their rays meet it, times ten."""
    runs = LoopRuns(results)
    drawn, axes = new_figure(2, 2, height_in=4.4, sharex=True, sharey=True)
    rows, gaps, ends = [], [], []
    for panel, (place, title) in zip(axes.flat, PANELS.items(), strict=True):
        board, errors, seed = runs.drawn(place)
        known = np.isfinite(errors).all(axis=1)
        corners, off = board[known], errors[known]
        panel.plot(*corners.T, ls="", marker=".", ms=2.5, color=INK)
        panel.quiver(
            *corners.T, *(SCALE * off).T, angles="xy", scale_units="xy", scale=1,
            color=series(0)["color"], width=0.004,
        )  # fmt: skip
        mean = np.linalg.norm(off, axis=1).mean()
        panel.set_title(f"{title}: {mean:.2f} mm", fontsize=9.5)
        panel.set_aspect("equal")
        ends += [*corners, *(corners + SCALE * off)]
        gaps.append(abs(mean - runs.of(place, "back_mm")[seed]))
        rows += [(place, *four) for four in np.column_stack([corners, off])]
    low, high = np.min(ends, axis=0) - MARGIN_MM, np.max(ends, axis=0) + MARGIN_MM
    axes[0, 0].set(xlim=(low[0], high[0]), ylim=(high[1], low[1]))
    for panel in axes[-1]:
        panel.set_xlabel("Board, x (mm)")
    for panel in axes[:, 0]:
        panel.set_ylabel("Board, y (mm)")
    return Drawing(
        drawn,
        columns(("panel", "x_mm", "y_mm", "off_x_mm", "off_y_mm"), rows),
        "Back-projection errors on a board at 400 mm, in the pose that the calibrated "
        f"camera itself finds, times {SCALE}, of one seed on the bench: the first that "
        "was refused nowhere. Mean lengths above the panels.",
        Check(
            bool(max(gaps) < ROUNDING),
            f"the drawn vectors have the mean lengths of the trial, to {max(gaps):.0e} "
            "mm",
        ),
    )


@figure("ext_repeat_steps", needs=("table_5_5_runs",), evidence="rendered")
def ext_repeat_steps(results):
    """Errors along the loop: back-projection both ways, rays, and the height."""
    drawn, axes = new_figure(2, 2, height_in=5.8, sharex=True)
    measures = (
        ("back_mm", "Back-projection, own pose (mm)"),
        ("back_true_mm", "Back-projection, true pose (mm)"),
        ("angle_deg", "Rays off the true ones (deg)"),
    )
    rows = []
    for bench, look in BENCH_LOOKS.items():
        runs = LoopRuns(results, bench=bench)
        along = {
            label: [runs.of("start", name), *runs.at(name)] for name, label in measures
        }
        heights = [np.zeros(runs.seeds), *np.abs(predicates.height_errors(runs))]
        along["Height at the load off (mm)"] = heights
        for panel, (label, trials) in zip(axes.flat, along.items(), strict=True):
            found = [median_interval(one) for one in trials]
            rows += plot_estimates(
                panel, range(len(LOOP)), found, (label, bench), look=look, label=bench
            )
            panel.set(ylabel=label, ylim=(0, None))
    for panel in axes[-1]:
        panel.set_xticks(range(len(LOOP)), [f"{k}\n{stage}" for k, stage in _stages()])
        panel.set_xlabel("Step, and the stage that it ends at (1)")
    legend_below(drawn, axes[0, 0], ncols=2)
    return Drawing(
        drawn,
        columns(("measure", "bench", "step", "median", "low", "high"), rows),
        "Errors after each of six steps, out and back, medians over seeds with 95 % "
        "intervals, on the bench and in the laboratory. Only the first measure can be "
        "had without the truth. The height is that of stage 0 as found, with all steps "
        "added.",
    )


def _stages():
    return [(0, LOOP[0]), *((step, LOOP[step]) for step in STEPS)]


@figure(
    "ext_placement_starts",
    needs=("exp_c5_dense_grid", "exp_c5_not_sensitive_init"),
    evidence="rendered",
)
def ext_placement_starts(results):
    """Deflections found from several places of the board, and from several starts."""
    placed, started = results[PLACED], results[STARTED]
    drawn, (left, right) = new_figure(1, 2, height_in=3.6)
    rows = []
    for number, (pitch, label) in enumerate(
        {"coarse": "pitch 18 mm", "dense": "pitch 9 mm"}.items()
    ):
        found = predicates.in_places(placed, BENCH, pitch)
        shift = 0.3 * number - 0.15
        x = np.arange(len(found))[:, None] + shift + np.zeros(found.shape)
        look = series(number) | {"linestyle": "", "markersize": 3.5}
        left.plot(x.ravel(), found.ravel(), label=label, **look)
        rows += [
            (label, seed, float(mm)) for seed, row in enumerate(found) for mm in row
        ]
    left.set(xlabel="Seed (1)", ylabel="First step, as found (mm)")
    left.set_xticks(range(0, placed.trials_per_condition, 2))
    left.axhline(5, color=INK, lw=0.8, ls="--")
    for number, (step, mm) in enumerate(STEPS_MM.items()):
        starts, ends = (
            100 * np.array(started.arrays(f"{BENCH}.{step}.{name}")) / mm
            for name in ("starts_mm", "ends_mm")
        )
        label = f"step of {step} mm"
        look = series(number) | {"linestyle": "", "markersize": 3.5}
        right.plot(starts.ravel(), ends.ravel(), label=label, **look)
        rows += [
            (label, *pair) for pair in zip(starts.ravel(), ends.ravel(), strict=True)
        ]
    right.axhline(100, color=INK, lw=0.8, ls="--")
    right.set(
        xlabel="Start, of the deflection (%)", ylabel="Found, of the deflection (%)"
    )
    for panel in (left, right):
        panel.legend(loc="best", fontsize=8)
    return Drawing(
        drawn,
        columns(("series", "seed_or_start", "found"), rows),
        "On the bench. Left: a step of 5 mm as found from five places of the board, "
        "with the same mirror, primary calibration and errors of the corners in every "
        "seed. Right: what refinement ends at, against the deflection that it starts "
        "from; the markers of one seed lie in a row. Dashed: the true deflection.",
    )
