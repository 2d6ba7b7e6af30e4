"""Fig. 3.11: CELECT along five sweeps, and the localiser's basin."""

import numpy as np

from chapters.ch03_planar_grids.s3_1_robustness.results import (
    PRIMARY,
    SWEEPS,
    Under,
    experiment_of,
    levels_of,
    successes,
)
from chapters.ch03_planar_grids.s3_1_robustness.trials import SMOOTHINGS
from chapters.shared.localiser_basin import HALF_WINDOWS, largest_by_start, starts_of
from chapters.shared.synthetic_board import SIZE_PX
from repro.judge.statistics import proportion
from repro.page.method_looks import look_of
from repro.page.style import figure as new_figure
from repro.page.style import plot_interval, series
from repro.run.columns import columns
from repro.run.experiment import figure
from repro.run.outcomes import Drawing
from repro.run.results import summary

LABELS = {
    "noise": "Noise SD (grey levels)",
    "blur": "Blur SD (px)",
    "square": "Square, undistorted (px)",
    "fov": "Field of view (deg)",
    "yaw": "Yaw (deg)",
}
TITLES = {
    "noise": "(a) Noise",
    "blur": "(b) Blur",
    "square": "(c) Size of squares",
    "fov": "(d) Fisheye",
    "yaw": "(e) Perspective",
}
PRINTED_LIMIT = {
    "noise": "s3_3_1_noise_fail",
    "blur": "s3_3_1_blur_fail",
    "square": "s3_3_1_pitch_ok",
    "yaw": "s3_3_1_yaw_fail",
}
OPENCV_WINDOWS = {
    "full window": "OpenCV, 9 × 9 px",
    "half window": "OpenCV, half window of 9",
}
PRINTED = {"color": "#4a4a4a", "linewidth": 1.2, "linestyle": (0, (1, 2))}
COLUMNS = (
    "panel",
    "reading",
    "x",
    "largest",
    "mean",
    "mean low",
    "mean high",
    "successful",
    "successful low",
    "successful high",
    "trials",
    "lost",
)


@figure(
    "fig_3_11",
    needs=(
        "fig_3_11_noise",
        "fig_3_11_blur",
        "fig_3_11_square",
        "fig_3_11_fov",
        "fig_3_11_yaw",
        "fig_3_11_localised",
    ),
    evidence="rendered",
    published=(
        "s3_3_1_noise_fail",
        "s3_3_1_blur_fail",
        "s3_3_1_pitch_ok",
        "s3_3_1_yaw_fail",
        "s3_3_1_maxerr",
        "s3_3_1_loc_max",
        "s3_3_1_loc_init",
    ),
)
def fig_3_11(results, published):
    """Errors and successes along five sweeps, and the localiser's basin."""
    drawn, panels = new_figure(4, 3, height_in=8.6, height_ratios=(1.5, 1, 1.5, 1))
    rows = []
    places = [(0, 0), (0, 1), (0, 2), (2, 0), (2, 1)]
    for (row, column), sweep in zip(places, SWEEPS, strict=True):
        pair = panels[row, column], panels[row + 1, column]
        rows += _draw_sweep(pair, results[experiment_of(sweep)], sweep)
        _draw_printed(pair, sweep, published)
    rows += _draw_basin(panels[2, 2], results["fig_3_11_localised"], published)
    panels[3, 2].set_axis_off()
    handles = panels[0, 0].get_legend_handles_labels()
    window = panels[2, 2].get_legend_handles_labels()
    panels[3, 2].legend(
        *(a + b for a, b in zip(handles, window, strict=True)),
        loc="center",
        fontsize=8,
        borderaxespad=0,
    )
    return Drawing(
        drawn,
        columns(COLUMNS, rows),
        "Errors and success of CELECT on the synthetic board, before localisation, "
        "over (a) noise, (b) blur, (c) size of the squares, (d) field of view and "
        "(e) yaw, with two smoothings of its gradients. Above: largest error of "
        "the successful trials and, for the first smoothing, the median of their "
        "mean error with its 95 % interval. Below: share of successful trials with "
        "its exact 95 % interval. (f) Largest error after localisation over the "
        "error of the start. Dotted: limits printed in the thesis.",
    )


def _draw_sweep(pair, result, sweep):
    errors, shares = pair
    rows = []
    for index, smoothing in enumerate(SMOOTHINGS):
        one = Under(result, smoothing)
        levels = levels_of(one, SWEEPS[sweep], levels="full range")
        x = SIZE_PX / levels if sweep == "square" else levels.astype(float)
        found = np.array(
            [_row(one, {SWEEPS[sweep]: v, "levels": "full range"}) for v in levels]
        )
        largest, mean, low, high, *right, _, _ = found.T
        label = f"largest error, {smoothing}"
        look = series(1 + index)
        errors.plot(x, largest, label=label, **look)
        if smoothing == PRIMARY:
            mean_look = {"look": series(0), "label": "mean error"}
            plot_interval(errors, x, mean, low, high, **mean_look)
        share, least, most = 100 * np.array(right)
        plot_interval(shares, x, share, least, most, look=look, label=smoothing)
        rows += [(sweep, smoothing, *cells) for cells in zip(x, *found.T, strict=True)]
    errors.set(title=TITLES[sweep], ylim=(0, 8.4), ylabel="Error (px)")
    errors.sharex(shares)
    errors.tick_params(labelbottom=False)
    shares.set(ylim=(-4, 104), xlabel=LABELS[sweep], ylabel="Successful (%)")
    return rows


def _row(result, condition):
    """Values of one level: COLUMNS from `largest` on."""
    right = successes(result, **condition)
    share = proportion(right)
    counts = len(right), int((1 - right).sum())
    means = result.column("mean_px", **condition)
    if np.isnan(means).all():
        return (*[np.nan] * 4, *share[:3], *counts)
    middle = summary(means[np.isfinite(means)].tolist())
    largest = np.nanmax(result.column("max_px", **condition))
    interval = middle["median_interval"]
    return (largest, middle["median"], *interval, *share[:3], *counts)


def _draw_printed(pair, sweep, published):
    """Draw the printed limit of a sweep and the printed largest error."""
    if sweep in PRINTED_LIMIT:
        for panel in pair:
            panel.axvline(published[PRINTED_LIMIT[sweep]], **PRINTED)
    if sweep != "blur":
        pair[0].axhline(published["s3_3_1_maxerr"], **PRINTED)


def _draw_basin(panel, result, published):
    """Largest error over corners and trials after OpenCV's localisation."""
    starts = starts_of(result)
    rows = []
    for window, half in HALF_WINDOWS.items():
        worst = largest_by_start(result, window)
        side = 2 * half + 1
        panel.plot(
            starts,
            worst,
            label=f"(f) window of {side} × {side} px",
            **look_of(OPENCV_WINDOWS[window]),
        )
        rows += [
            ("localised", window, start, error, *[None] * 8)
            for start, error in zip(starts, worst, strict=True)
        ]
    panel.axhline(published["s3_3_1_loc_max"], **PRINTED)
    panel.axvline(published["s3_3_1_loc_init"], label="printed limit", **PRINTED)
    panel.set(
        yscale="log",
        ylim=(0.02, 200),
        title="(f) After localisation",
        xlabel="Error of the start (px)",
        ylabel="Error (px)",
    )
    return rows
