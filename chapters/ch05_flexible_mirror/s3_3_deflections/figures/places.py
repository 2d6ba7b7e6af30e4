"""Figs. 5.11 and 5.12: angles over the image, and vectors on the board."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_deflections.results.runs import (
    LAST,
    SCALES,
    STAGES,
    Runs,
)
from chapters.ch05_flexible_mirror.s3_3_deflections.trials.run import COMPARED_PX
from chapters.shared.mirror_scores import lengths
from repro.page.style import INK, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

RUNS_OF_A = ("table_5_1_runs",)
EXACT = 1e-9


@figure("fig_5_11", needs=RUNS_OF_A, evidence="rendered")
def fig_5_11(results):
    """Angles to the true rays over the image, at stages 0 to 3 of one run."""
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
        panel.set_ylabel("Image v (px)")
    for panel in axes[1]:
        panel.set_xlabel("Image u (px)")
    drawn.colorbar(mesh, ax=axes, label="Angle to the true ray (deg)", shrink=0.8)
    means = [float(np.nanmean(off)) for off in of["off_deg"]]
    said = ", ".join(f"{mean:.3f}" for mean in means)
    return Drawing(
        drawn,
        columns(("stage", "u_px", "v_px", "angle_deg"), rows),
        "Angles between calibrated and true rays over the image, at each stage of "
        "deflection: the first completed run, rig A at the second solved level. The "
        f"clamped edge is at the right. Means of this run: {said}°.",
    )


def in_lattice(pixels, values):
    """Columns (n,) and rows (m,) of a lattice, values (m, n), nan off the mirror."""
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
        panel.set_xlabel("Board x (mm)")
        rows += [(name, *p, *e) for p, e in zip(points, errors, strict=True)]
    axes[0].set_ylabel("Board y (mm)")
    return Drawing(
        drawn,
        columns(("calibration", "x_mm", "y_mm", "error_x_mm", "error_y_mm"), rows),
        "Back-projection errors on a board at 400 mm with the mirror at stage 3: (a) "
        "with the calibration of stage 2, vectors scaled by 5; (b) after dynamic "
        "calibration, vectors scaled by 30. Each calibration fits the board's pose. "
        "The run of Fig. 5.11.",
        Check(
            bool(max(gaps) < EXACT),
            f"the vectors have the means that are judged, to {max(gaps):.0e} mm",
        ),
    )
