"""Results of this page read: values of the prose, figures, tables."""

import numpy as np

from chapters.ch03_planar_grids.s3_1_robustness.experiment import (
    SHOWN_YAW_DEG,
    SMOOTHINGS,
)
from chapters.shared.grids import (
    HALF_WINDOWS,
    LOCALISED_PX,
    SIZE_PX,
    SyntheticBoard,
    farthest_start,
    largest_by_start,
    starts_of,
    worst_within,
)
from repro.page import look_of, new_figure, plot_interval, series, value
from repro.run import Check, Drawing, Value, columns, figure, numbers, proportion
from repro.run.results import summary

# Results of the sweeps of 3.3.1, and the quoted numbers.


RESULTS_OF_3_11 = (
    "fig_3_11_noise",
    "fig_3_11_blur",
    "fig_3_11_square",
    "fig_3_11_fov",
    "fig_3_11_yaw",
    "fig_3_11_localised",
)
# Sweep -> name of the swept property.
SWEEPS = {
    "noise": "noise_sd",
    "blur": "blur_px",
    "square": "squares_across",
    "fov": "fov_deg",
    "yaw": "yaw_deg",
}
# The four sweeps for which the text gives the largest error.
WITHOUT_BLUR = ("noise", "square", "fov", "yaw")
FULL = {"levels": "full range"}
TEXT_SQUARES = 20  # across the board: those of 50 px

PRIMARY, *OTHERS = SMOOTHINGS


def path_of(smoothing):
    """Keys in front of a value with one smoothing, see `by_smoothing`."""
    return () if smoothing == PRIMARY else (smoothing,)


class Under:
    """Result of a sweep with one smoothing."""

    def __init__(self, result, smoothing):
        self.result, self.path = result, path_of(smoothing)
        self.conditions, self.levels = result.conditions, result.levels

    def column(self, name, **condition):
        """Trials (n,) of a value."""
        return self.result.column(*self.path, name, **condition)


def sweeps_under(results, smoothing, sweeps=tuple(SWEEPS)):
    """Sweep -> its result with one smoothing."""
    return {s: Under(results[f"fig_3_11_{s}"], smoothing) for s in sweeps}


def full_range_levels(sweeps):
    """(result, condition) of every level at full contrast, each condition once.

    The five sweeps meet at the default condition.
    """
    listed = []
    for result in sweeps.values():
        for condition in result.conditions:
            if condition["levels"] == "full range" and condition not in listed:
                listed.append(condition)
                yield result, condition


def largest_errors(sweeps):
    """Largest error (px) of the successful trials, for levels that have any."""
    errors = [
        result.column("max_px", **condition)
        for result, condition in full_range_levels(sweeps)
    ]
    return np.array([np.nanmax(e) for e in errors if np.isfinite(e).any()])


def limit(result, name, **other):
    """(last level without a failure, first level with one): the bracket.

    Infinite if no level of the sweep has a failure.
    """
    before = -np.inf
    for level in map(float, result.levels(name, **other)):
        if result.column("success", **{name: level}, **other).min() < 1:
            return before, level
        before = level
    return before, np.inf


def first_limit(results, sweep, unit, **other):
    """Value of the first level with a failed trial, in its bracket."""
    name = SWEEPS[sweep]
    before, first = limit(results[PRIMARY][sweep], name, **other)
    others = in_others(
        lambda smoothing: limit(results[smoothing][sweep], name, **other)[1]
    )
    return bracketed(
        before,
        first,
        unit,
        f"{sweep}: first level with a lost trial; the interval begins at the "
        f"level before it; {others}",
    )


def in_others(level):
    """Text with level(smoothing) for the smoothings that do not decide."""
    return "; ".join(
        f"with a smoothing of {name} {level_text(level(name))}" for name in OTHERS
    )


def level_text(number):
    """Text of a level: "none" if it is infinite."""
    return f"{number:.0f}" if np.isfinite(number) else "none"


def bracketed(before, first, unit, reason):
    """Value of a level in its bracket; the last level if it is not reached."""
    if np.isinf(first):
        reason = "not reached: this is the last level of the sweep"
        first = before
    return Value(first, interval=(max(before, 0.0), first), unit=unit, reason=reason)


def smallest_square(result):
    """(square px, least spacing px) of the smallest square without failure."""
    across = result.levels("squares_across")
    kept = [n for n in across if result.column("success", squares_across=n).min() == 1]
    if not kept:
        return np.nan, np.nan
    spacing = result.result.column("least_px", squares_across=max(kept))
    return float(SIZE_PX / max(kept)), float(spacing[0])


def degrading_blur(result):
    """(level before, first blur SD in px whose outcome is worse than 1 px's).

    Worse: a fifth fewer successes, or a mean error 1.25 times as large.
    """
    levels = [b for b in result.levels("blur_px") if b >= 1]
    right = [result.column("success", blur_px=b).mean() for b in levels]
    means = [
        np.nanmedian(result.column("mean_px", blur_px=b)) if right[k] else np.inf
        for k, b in enumerate(levels)
    ]
    for k in range(1, len(levels)):
        if right[k] <= right[0] - 0.2 or means[k] >= 1.25 * means[0]:
            return float(levels[k - 1]), float(levels[k])
    return float(levels[-1]), np.inf


@numbers("fig_3_11", needs=RESULTS_OF_3_11, evidence="rendered")
def numbers_fig_3_11(results):
    """Settings of the sweeps as run, and their limits."""
    swept = {name: sweeps_under(results, name) for name in SMOOTHINGS}
    noise = results["fig_3_11_noise"]
    ran, default = noise.settings, noise.settings["defaults"]
    square, spacing = smallest_square(swept[PRIMARY]["square"])
    (of_text, *_) = results["fig_3_11_square"].column(
        "least_px", squares_across=TEXT_SQUARES
    )
    before, blurred = degrading_blur(swept[PRIMARY]["blur"])
    largest = {
        name: float(largest_errors(sweeps_under(results, name, WITHOUT_BLUR)).max())
        for name in SMOOTHINGS
    }
    return numbers_of_basin(results) | {
        "s3_3_1_img": Value(ran["image_px"], unit="px"),
        "s3_3_1_fov": Value(default["fov_deg"], unit="deg"),
        "s3_3_1_blur0": Value(default["blur_px"], unit="px"),
        "s3_3_1_user_sd": Value(ran["clicks"]["sd_px"], unit="px"),
        "s3_3_1_user_cap": Value(ran["clicks"]["cap_px"], unit="px"),
        "s3_3_1_trials": Value(noise.trials_per_condition, unit="count"),
        "s3_3_1_fail": Value(ran["lost_px"], unit="px"),
        "s3_3_1_maxerr": Value(
            largest[PRIMARY],
            interval=(largest[PRIMARY],) * 2,
            unit="px",
            reason="largest over all trials of four sweeps; "
            + "; ".join(
                f"with a smoothing of {name} {largest[name]:.2f} px" for name in OTHERS
            ),
        ),
        "s3_3_1_noise_fail": first_limit(swept, "noise", "grey levels", **FULL),
        "s3_3_1_yaw_fail": first_limit(swept, "yaw", "deg"),
        "s3_3_1_pitch_ok": Value(
            square,
            interval=(square, square),
            unit="px",
            reason="smallest square of the sweep in which no trial is lost; "
            + in_others(lambda name: smallest_square(swept[name]["square"])[0]),
        ),
        "s3_3_1_intercorner": Value(
            spacing,
            interval=(spacing, spacing),
            unit="px",
            reason=f"least distance of corners with squares of {square:.1f} "
            "px, the smallest in which no trial is lost; with "
            f"{SIZE_PX / TEXT_SQUARES:.0f} px it is {of_text:.1f} px",
        ),
        "s3_3_1_blur_fail": bracketed(
            before,
            blurred,
            "px",
            "first blur worse than 1 px by a fifth of the trials or a "
            "quarter of the mean error; the interval begins at the level "
            "before it; "
            + in_others(lambda name: degrading_blur(swept[name]["blur"])[1]),
        ),
    }


def numbers_of_basin(results):
    """Numbers of Fig. 3.11(f), for the producer of that figure's numbers."""
    result = results["fig_3_11_localised"]
    window, other = HALF_WINDOWS
    worst = worst_within(result, window)
    start = farthest_start(result, window)
    return {
        "s3_3_1_loc_win": Value(
            result.settings["half_windows"][window],
            unit="px",
            reason="as OpenCV's half window: 19 x 19 px (E-3.16)",
        ),
        "s3_3_1_loc_max": Value(
            worst,
            interval=(worst, worst),
            unit="px",
            reason="9 as OpenCV's half window; with a window of 9 x 9 px the "
            f"largest error is {worst_within(result, other):.1f} px",
        ),
        "s3_3_1_loc_init": Value(
            start,
            interval=(start, start),
            unit="px",
            reason="largest start error of the sweep from which all corners "
            f"come within {LOCALISED_PX} px; 9 as OpenCV's half window; with "
            f"a window of 9 x 9 px it is {farthest_start(result, other):g} px",
        ),
    }


@numbers("sec_3_3_1", needs=("fig_3_11_noise",), evidence="rendered")
def numbers_sec_3_3_1(results):
    """Numbers of the clicks, simulated here."""
    result = results["fig_3_11_noise"]
    offsets = np.concatenate(
        [result.column("click_px", **c) for c in result.conditions]
    )
    boards = 45 * 7 * 5 + 7 * 9 * 7 + 8 * 12 * 9  # images of 3.3.2 (E-3.14)
    return {
        "s3_3_1_manual_n": Value(boards, unit="count"),
        "s3_3_1_click_mean": Value(
            float(offsets.mean()),
            unit="px",
            reason="simulated clicks, with the SD and the cap that 3.3.1 "
            "gives: their mean error is nearly three times the author's",
        ),
        "s3_3_1_click_sd": Value(
            float(2 * offsets.std()),
            unit="px",
            reason="of the same simulated clicks, twice the SD of means of four; "
            "0.16, as printed, is the variance (px²) of its law (E-3.13)",
        ),
    }


def name_values(open_results):
    """Name the numbers that the page quotes."""
    noise, yaw, square, localised = (
        open_results(f"fig_3_11_{s}") for s in ("noise", "yaw", "square", "localised")
    )
    weak = OTHERS[0]
    right, weak_right = (
        Under(square, smoothing).column("success", squares_across=TEXT_SQUARES)
        for smoothing in (PRIMARY, weak)
    )
    quoted = {
        "weak.noise.lost": level_text(limit(Under(noise, weak), "noise_sd", **FULL)[1]),
        "weak.yaw.lost": level_text(limit(Under(yaw, weak), "yaw_deg")[1]),
        "share.square_50": 100 * float(right.mean()),
        "weak.square_50": 100 * float(weak_right.mean()),
        "full_window.reach": farthest_start(localised, "full window"),
    }
    for name, number in quoted.items():
        value(name, number)


# Why a rotated board fails: candidates on side 1 and the distance t8.


CROP_PX = 28
SHOWN_CORNERS = 3


@figure("ext_celect_merging", needs=("ext_celect_merging",), evidence="rendered")
def ext_celect_merging(results):
    """Last corners of side 1, and the gap between their candidates over yaw."""
    result = results["ext_celect_merging"]
    drawn, (image, panel) = new_figure(1, 2, height_in=3.7, width_ratios=(1, 1.25))
    _draw_corners(image, result)
    rows = _draw_gaps(panel, result)
    return Drawing(
        drawn,
        columns(("smoothing", "yaw_deg", "step_px", "gap_px", "t8_px"), rows),
        "Candidates of CELECT on side 1 of a rotated board. Left: the far end of "
        f"the side at a yaw of {SHOWN_YAW_DEG}°, with true corners and Harris's "
        "candidates. Right: smallest step between neighbouring corners, smallest "
        "gap between candidates of neighbouring corners, and the merging distance "
        "$t_8$, over yaw. Blur 1 px, no noise, exact clicks.",
    )


def _draw_corners(panel, result):
    shown = {"yaw_deg": SHOWN_YAW_DEG}
    (image,) = result.arrays("picture", **shown)
    (truth,) = result.arrays("truth", **shown)
    last = truth[-SHOWN_CORNERS:]
    panel.imshow(image, cmap="gray", vmin=-120, vmax=375)
    panel.plot(*last.T, "x", color="black", ms=9, mew=2, label="true corner")
    for index, smoothing in enumerate(SMOOTHINGS):
        (found,) = result.arrays(*path_of(smoothing), "candidates", **shown)
        look = series(1 + index) | {"linestyle": "none"}
        panel.plot(*found.T, ms=6, label=smoothing, **look)
    middle = (last.min(axis=0) + last.max(axis=0)) / 2
    reach = np.ptp(last, axis=0).max() / 2 + CROP_PX
    panel.set(
        xlim=(middle[0] - reach, middle[0] + reach),
        ylim=(middle[1] + reach, middle[1] - reach),
        title=f"Side 1, yaw {SHOWN_YAW_DEG}°",
        xlabel="u (px)",
        ylabel="v (px)",
    )
    panel.grid(visible=False)
    panel.legend(loc="lower left", fontsize=8, handlelength=1.2)


def _draw_gaps(panel, result):
    rows, yaws, trials = [], result.levels("yaw_deg"), result.select()
    steps = trials.column("step_px")
    panel.plot(yaws, steps, label="step between corners", **series(0))
    for index, smoothing in enumerate(SMOOTHINGS):
        gap, merge = trials.column(*path_of(smoothing), ("gap_px", "t8_px"))
        panel.plot(yaws, gap, label=f"gap, {smoothing}", **series(1 + index))
        if smoothing == PRIMARY:
            panel.plot(yaws, merge, label="$t_8$", **series(6))
        rows += [
            (smoothing, *cells) for cells in zip(yaws, steps, gap, merge, strict=True)
        ]
    panel.set(ylim=(0, 50), xlabel="Yaw (deg)", ylabel="Distance (px)")
    panel.legend(loc="lower left", fontsize=8)
    return rows


# Fig. 3.10: the synthetic board.


@figure("fig_3_10", needs=("fig_3_10_pictures",), evidence="rendered")
def fig_3_10(results):
    """The board before and after distortion, with its corners."""
    result = results["fig_3_10_pictures"]
    drawn, panels = new_figure(1, 2, height_in=3.9)
    rows = []
    for panel, shape, title in zip(
        panels, ("flat", "bent"), ("(a) Undistorted", "(b) FOV 134°"), strict=True
    ):
        (image,) = result.arrays("picture", shape=shape)
        (corners,) = result.arrays("corners", shape=shape)
        panel.imshow(image, cmap="gray", vmin=0, vmax=255)
        panel.plot(*corners.T, "o", color="#d55e00", ms=2.5)
        panel.grid(visible=False)
        panel.set(title=title, xlabel="u (px)", ylabel="v (px)")
        rows += [(shape, index, *corner) for index, corner in enumerate(corners)]
    board = SyntheticBoard()
    flat, bent = (result.arrays("corners", shape=s)[0] for s in ("flat", "bent"))
    middle = (SIZE_PX - 1) / 2
    before, after = (np.linalg.norm(c - middle, axis=1) for c in (flat, bent))
    law = 2 * board.focal_px * np.sin(np.arctan(before / board.focal_px) / 2)
    worst = float(np.abs(after - law).max())
    return Drawing(
        drawn,
        columns(("panel", "corner", "u_px", "v_px"), rows),
        "Synthetic chessboard (a) without distortion and (b) in an equisolid "
        "fisheye image with a diagonal field of view of 134°. Dots: the corners "
        "to be detected.",
        check=Check(
            worst < 1e-6,
            f"radii of all corners follow r = 2 f sin(atan(R/f)/2) to {worst:.0e} px",
        ),
    )


# Fig. 3.11: CELECT along five sweeps, and the localiser's basin.


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
    needs=RESULTS_OF_3_11,
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
        rows += _draw_sweep(pair, results[f"fig_3_11_{sweep}"], sweep)
        if sweep in PRINTED_LIMIT:
            for panel in pair:
                panel.axvline(published[PRINTED_LIMIT[sweep]], **PRINTED)
        if sweep != "blur":
            pair[0].axhline(published["s3_3_1_maxerr"], **PRINTED)
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
        "with two smoothings of its gradients. Swept: (a) noise, (b) blur, (c) size "
        "of the squares, (d) field of view, (e) yaw. Above: largest error of "
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
        levels = np.array(one.levels(SWEEPS[sweep], levels="full range"), float)
        x = SIZE_PX / levels if sweep == "square" else levels
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
        plot_interval(shares, x, *100 * np.array(right), look=look, label=smoothing)
        rows += [(sweep, smoothing, *cells) for cells in zip(x, *found.T, strict=True)]
    errors.set(title=TITLES[sweep], ylim=(0, 8.4), ylabel="Error (px)")
    errors.sharex(shares)
    errors.tick_params(labelbottom=False)
    shares.set(ylim=(-4, 104), xlabel=LABELS[sweep], ylabel="Successful (%)")
    return rows


def _row(result, condition):
    """Values of one level: COLUMNS from `largest` on."""
    right = result.column("success", **condition)
    share = proportion(right)
    counts = len(right), int((1 - right).sum())
    means = result.column("mean_px", **condition)
    if np.isnan(means).all():
        return (*[np.nan] * 4, *share[:3], *counts)
    middle = summary(means[np.isfinite(means)].tolist())
    largest = np.nanmax(result.column("max_px", **condition))
    interval = middle["median_interval"]
    return (largest, middle["median"], *interval, *share[:3], *counts)


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
