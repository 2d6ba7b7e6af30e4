"""Figs. 5.11 and 5.12, and what explains them: place, and the linear estimate."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_deflections.results.geometry import (
    by_formula,
    camera_mm,
)
from chapters.ch05_flexible_mirror.s3_3_deflections.results.predicates import (
    angles_by_place,
    linear_ratios,
)
from chapters.ch05_flexible_mirror.s3_3_deflections.results.runs import (
    DEFLECTED,
    LAST,
    SCALES,
    STAGES,
    STEP_MM,
    Runs,
)
from chapters.ch05_flexible_mirror.s3_3_deflections.trials.run import COMPARED_PX
from chapters.shared.mirror_bench import BENCH, BENCHES
from chapters.shared.mirror_rigs import DYNAMIC_MM
from chapters.shared.mirror_scores import lengths
from repro.judge.statistics import median_interval
from repro.page.style import INK, legend_below, plot_estimates, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

RUNS_OF_A = ("table_5_1_runs",)
BOTH_GEOMETRIES = ("table_5_1_runs", "table_5_1_other")
PRINTED_LINEAR = ("t5_1_s1_linear", "t5_1_s2_linear", "t5_1_s3_linear")
PLACES = ("along the clamped edge", "whole mirror", "along the free edges")
EXACT = 1e-9


@figure("fig_5_11", needs=RUNS_OF_A, evidence="rendered")
def fig_5_11(results):
    """Angles to the true rays over the picture, at stages 0 to 3 of one seed."""
    runs = Runs(results)
    drawn, axes = new_figure(2, 2, height_in=4.8, sharex=True, sharey=True)
    of = {
        name: [runs.drawn(stage, name) for stage in STAGES]
        for name in ("pixels", "off_deg")
    }
    most = max(np.nanmax(off) for off in of["off_deg"])
    rows = []
    for panel, stage, pixels, off in zip(
        axes.flat, STAGES, of["pixels"], of["off_deg"], strict=True
    ):
        mesh = panel.pcolormesh(
            *in_lattice(pixels, off), cmap="viridis", vmin=0, vmax=most
        )
        panel.set(
            title=f"({'abcd'[stage]}) stage {stage}", xlim=(0, 3072), ylim=(2304, 0)
        )
        panel.set_aspect("equal")
        rows += [(stage, *p, a) for p, a in zip(pixels, off, strict=True)]
    for panel in axes[:, 0]:
        panel.set_ylabel("v (px)")
    for panel in axes[1]:
        panel.set_xlabel("u (px)")
    drawn.colorbar(mesh, ax=axes, label="Angle (deg)", shrink=0.8)
    means = [float(np.nanmean(off)) for off in of["off_deg"]]
    said = ", ".join(f"{mean:.3f}" for mean in means)
    return Drawing(
        drawn,
        columns(("stage", "u_px", "v_px", "angle_deg"), rows),
        "Angles between calibrated and true rays over the picture, at each stage of "
        "deflection: the first seed that came through all of them, geometry A at the "
        "bench's noise. The clamped edge is at the right. Means of this seed: "
        f"{said}°.",
    )


def in_lattice(pixels, values):
    """Columns (n,) and rows (m,) of a lattice, values (m, n), nan beside the mirror."""
    u, v = (np.unique(pixels[:, k]) for k in (0, 1))
    u, v = (np.arange(at[0], at[-1] + 1, COMPARED_PX) for at in (u, v))
    found = np.full((len(v), len(u)), np.nan)
    at = ((pixels - [u[0], v[0]]) / COMPARED_PX).round().astype(int)
    found[at[:, 1], at[:, 0]] = values
    return u, v, found


@figure("fig_5_12", needs=RUNS_OF_A, evidence="rendered")
def fig_5_12(results):
    """Back-projection errors of stage 3 on the board, before and after calibration."""
    runs = Runs(results)
    points = runs.drawn(LAST, "board_mm")
    drawn, axes = new_figure(1, 2, height_in=3.9, sharex=True, sharey=True)
    rows, gaps = [], []
    seed = np.flatnonzero(np.isfinite(runs.of(LAST, "angle_deg")))[0]
    for panel, letter, name, of, scale in zip(
        axes, "ab", ("stale", "own"), ("stale_mm", "back_mm"), SCALES, strict=True
    ):
        errors = runs.drawn(LAST, name)
        ends = points + scale * errors
        panel.plot(
            *np.stack([points, ends], axis=-1).transpose(1, 2, 0),
            color=series(0)["color"], lw=0.9, ls="-", marker="",
        )  # fmt: skip
        seen = np.isfinite(errors[:, 0])
        panel.plot(*points[seen].T, ls="", marker=".", color=INK, ms=2)
        mean = lengths(errors).mean()
        gaps.append(abs(mean - runs.of(LAST, of)[seed]))
        panel.set_title(f"({letter}) × {scale}, mean {mean:.2f} mm")
        panel.set_aspect("equal")
        panel.set_xlabel("x on the board (mm)")
        rows += [(name, *p, *e) for p, e in zip(points, errors, strict=True)]
    axes[0].set_ylabel("y on the board (mm)")
    return Drawing(
        drawn,
        columns(("calibration", "x_mm", "y_mm", "error_x_mm", "error_y_mm"), rows),
        "Back-projection errors on a board at 400 mm with the mirror at stage 3: (a) "
        "by the calibration of stage 2, vectors drawn five times as long; (b) after "
        "dynamic calibration, thirty times. The board's pose is found by each "
        "calibration itself. The seed of Fig. 5.11.",
        Check(
            bool(max(gaps) < EXACT),
            f"the vectors have the means that are judged, to {max(gaps):.0e} mm",
        ),
    )


@figure("ext_angles_by_place", needs=RUNS_OF_A, evidence="rendered")
def ext_angles_by_place(results):
    """Mean angles near the clamp, everywhere, and near the free edges, all seeds."""
    drawn, axes = new_figure(1, 2, height_in=3.3)
    rows = []
    for panel, bench in zip(axes, (BENCH, "laboratory"), strict=True):
        every = angles_by_place(Runs(results, bench=bench))
        for k, (place, trials) in enumerate(zip(PLACES, every, strict=True)):
            look = {"look": series(k), "label": place}
            rows += plot_estimates(
                panel, *reached(STAGES, trials), (bench, place), **look
            )
        panel.set(title=bench, xlabel="Stage (1)", xticks=STAGES, ylim=(0, None))
        panel.set_ylabel("Angle to the true rays (deg)")
    legend_below(drawn, axes[0], 3)
    return Drawing(
        drawn,
        columns(("bench", "place", "stage", "angle_deg", "low", "high"), rows),
        "Mean angle between calibrated and true rays by the place on the mirror: in a "
        "strip of a fifth of its length along the clamp, everywhere, and in strips of "
        "a fifth along the three free edges. Medians over the seeds that came so far, "
        "with 95 % intervals.",
    )


def reached(places, stages):
    """Places and medians of those of stages (n, seeds) that any seed came to."""
    came = {
        at: median_interval(trials[np.isfinite(trials)])
        for at, trials in zip(places, stages, strict=True)
        if np.isfinite(trials).any()
    }
    return list(came), list(came.values())


@figure(
    "ext_linear_ratio",
    needs=BOTH_GEOMETRIES,
    evidence="rendered",
    published=PRINTED_LINEAR,
)
def ext_linear_ratio(results, published):
    """Linear over actual deflection, against depth over camera distance."""
    drawn, axes = new_figure(height_in=3.6)
    x = np.linspace(0.3, 2.2, 100)
    axes.plot(x, x / (1 + x), color=INK, lw=1.2, ls="-", marker="", label="Z/(Z+D)")
    of_printed = sorted(value / STEP_MM for value in published.values())
    axes.axhspan(
        of_printed[0], of_printed[-1], color=series(6)["color"], alpha=0.18, lw=0,
        label="printed in Table 5.1",
    )  # fmt: skip
    rows = []
    for k, geometry in enumerate("AB"):
        at = DYNAMIC_MM / camera_mm(geometry)
        for j, bench in enumerate(reversed(BENCHES)):
            trials = linear_ratios(Runs(results, bench=bench, geometry=geometry))
            places = [at + 0.03 * (stage - 2) + 0.012 * j for stage in DEFLECTED]
            whose = (geometry, bench)
            look = series(2 * k + j) | {"linestyle": "none"}
            label = f"geometry {geometry}, {bench}"
            found = reached(places, trials)
            rows += plot_estimates(axes, *found, whose, look=look, label=label)
    axes.set(xlabel="Z/D (1)", ylabel="Linear over actual (1)")
    axes.set(xlim=(x[0], x[-1]), ylim=(0, 1))
    axes.legend(loc="upper left", ncols=2, fontsize=8)
    formulas = {geometry: by_formula(geometry) for geometry in "AB"}
    return Drawing(
        drawn,
        columns(("geometry", "bench", "z_over_d", "ratio", "low", "high"), rows),
        "The linear estimate of a deflection over the actual one, stages 1 to 3 from "
        "left to right, beside the depth Z of the board over the camera's distance D "
        "from the middle of the mirror. Medians with 95 % intervals. The formula has "
        f"{formulas['A']:.2f} for A and {formulas['B']:.2f} for B, which was chosen "
        "for it.",
    )
