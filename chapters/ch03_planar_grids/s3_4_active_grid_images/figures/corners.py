"""Fig. 3.16: residual vectors of the four methods."""

import numpy as np

from chapters.ch03_planar_grids.s3_4_active_grid_images.results import (
    CORNERS,
    METHODS,
    VECTOR_SCALE,
    Corners,
)
from repro.page.method_looks import look_of
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

FINER_SCALE = 2000


@figure("fig_3_16", needs=("table_3_8_corners",), evidence="rendered")
def fig_3_16(results):
    """Draw residual vectors of the four methods, first simulated run."""
    case = Corners(results[CORNERS])
    drawn, axes = new_figure(2, 4, height_in=4.6, sharex=True, sharey=True)
    rows, worst = [], 0.0
    for k, method in enumerate(METHODS):
        corners, vectors = (case.arrays(method, n)[0] for n in ("corners", "vectors"))
        for panel, scale in zip(axes[:, k], (VECTOR_SCALE, FINER_SCALE), strict=True):
            panel.plot(*corners.T, ".", ms=1.5, color="0.6")
            panel.quiver(
                *corners.T,
                *(scale * vectors).T,
                angles="xy",
                scale_units="xy",
                scale=1,
                width=0.006,
                color=look_of(method)["color"],
            )
            panel.set(
                aspect="equal",
                title=f"({'abcd'[k]}) {method}" if panel in axes[0] else "",
            )
        mean = np.nanmean(np.linalg.norm(vectors, axis=1))
        worst = max(worst, abs(mean - case.statistic(method, "mean")[0]))
        rows += [(method, *at, *off) for at, off in zip(corners, vectors, strict=True)]
    axes[0, 0].invert_yaxis()
    for panel in axes[1]:
        panel.set_xlabel("u (px)")
    for panel, scale in zip(axes[:, 0], (VECTOR_SCALE, FINER_SCALE), strict=True):
        panel.set_ylabel(f"{scale} ×: v (px)")
    return Drawing(
        drawn,
        columns(("method", "u_px", "v_px", "du_px", "dv_px"), rows),
        "Residual vectors of all corners of the chessboard after a homography from the "
        "metric grid, with the best setting of each method; first simulated run. "
        f"Above: magnified {VECTOR_SCALE} times, as in the thesis. Below: "
        f"{FINER_SCALE} times.",
        Check(
            worst < 1e-9, "mean length of the drawn vectors is the mean of Table 3.8"
        ),
    )
