"""Fig. 3.16, and how the errors behind it depend on the window."""

import numpy as np

from chapters.ch03_planar_grids.s3_4_active_grid_images.results import (
    CORNERS,
    FAR,
    FAR_CASE,
    METHODS,
    OF_CORNERS,
    VECTOR_SCALE,
    Corners,
    over_blurs,
)
from repro.page.method_looks import look_of
from repro.page.style import figure as new_figure
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Check, Drawing

FINER_SCALE = 2000


@figure("fig_3_16", needs=("table_3_8_corners",), evidence="rendered")
def fig_3_16(results):
    """Residual vectors of the four methods, first seed."""
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
        "Residuals of every corner of the board after the homography from the metric "
        f"grid, with the best setting of each method; first seed. Above drawn "
        f"{VECTOR_SCALE} times as long as they are, as in the thesis, below "
        f"{FINER_SCALE} times.",
        Check(
            worst < 1e-9, "mean length of the drawn vectors is the mean of Table 3.8"
        ),
    )


@figure("ext_fig_3_16_windows", needs=OF_CORNERS, evidence="rendered")
def ext_fig_3_16_windows(results):
    """Mean residual over the window, near and at twice the distance."""
    drawn, axes = new_figure(1, 2, height_in=3.2, sharey=True)
    rows = []
    cases = Corners(results[CORNERS]), Corners(results[FAR], case=FAR_CASE)
    for panel, case, letter in zip(axes, cases, "ab", strict=True):
        windows = case.settings("windows").astype(float)
        for method in METHODS:
            curves = [over_blurs(means) for means in case.arrays(method, "means")]
            middle = np.median(curves, axis=0)
            if method == "active grid":
                middle = np.full(len(windows), middle[0])
            shown = np.where(np.isfinite(middle), middle, np.nan)
            panel.plot(windows, shown, label=method, **look_of(method))
            rows += [
                (case.case, method, w, m) for w, m in zip(windows, shown, strict=True)
            ]
        square = np.median(case.trials.column("square_px"))
        panel.set(
            title=f"({letter}) squares of {square:.0f} px",
            xlabel="Window, full width (px)",
        )
    axes[0].set(yscale="log", ylim=(0.003, 0.3), ylabel="Mean residual (px)")
    axes[1].legend()
    return Drawing(
        drawn,
        columns(("pose", "method", "window_px", "mean_px"), rows),
        "Mean residual over the window, medians over the seeds; the saddle point "
        "method with its best blur. A line ends where a window leaves the "
        "picture, or a "
        "corner is lost. The active grid has no window.",
    )
