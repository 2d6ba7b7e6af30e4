"""Fig. 5.13: back-projection errors along the loop."""

import numpy as np

from chapters.ch05_flexible_mirror.s3_3_repeatability.results.runs import (
    PANELS,
    SCALE,
    LoopRuns,
)
from repro.page.style import INK, series
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

MARGIN_MM = 10.0
ROUNDING = 1e-9


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
        panel.set_xlabel("Board x (mm)")
    for panel in axes[:, 0]:
        panel.set_ylabel("Board y (mm)")
    return Drawing(
        drawn,
        columns(("panel", "x_mm", "y_mm", "off_x_mm", "off_y_mm"), rows),
        "Back-projection errors on a board at 400 mm in the pose fitted by the "
        f"calibrated camera, scaled by {SCALE}: the first completed run at the second "
        "solved level. Mean lengths above the panels.",
        Check(
            bool(max(gaps) < ROUNDING),
            f"the drawn vectors have the mean lengths of the trial, to {max(gaps):.0e} "
            "mm",
        ),
    )
