"""What the sweeps of 3.3.1 found, and the numbers that are quoted."""

from __future__ import annotations

import numpy as np

from chapters.ch03_planar_grids.s3_1_robustness.trials import BLUR_PX
from chapters.shared.localiser_basin import (
    HALF_WINDOWS,
    LOCALISED_PX,
    farthest_start,
    worst_within,
)
from chapters.shared.synthetic_board import SIZE_PX
from raxel.features.celect import TOO_FEW
from repro.page.reader import value
from repro.run.experiment import numbers
from repro.run.outcomes import Value

DEFAULT_FOV = 134
# Sweep -> the name of what is swept.
SWEEPS = {
    "noise": "noise_sd",
    "blur": "blur_px",
    "square": "squares_across",
    "fov": "fov_deg",
    "yaw": "yaw_deg",
}
# The four of which the text gives the largest error.
WITHOUT_BLUR = ("noise", "square", "fov", "yaw")
FULL = {"levels": "full range"}


def experiment_of(sweep):
    """Name of the experiment of a sweep."""
    return f"fig_3_11_{sweep}"


def levels_of(result, name, **other):
    """Levels (n,) along a sweep, as they were run, in order."""
    found = [
        c[name]
        for c in result.conditions
        if all(c[key] == value for key, value in other.items())
    ]
    return np.array(found)


def successes(result, **condition):
    """Trials (n,) of one level: 1 where every corner was right."""
    return result.column("success", **condition)


def first_lost(result, name, **other):
    """Index of the first level with a lost trial; None if none is lost."""
    for index, level in enumerate(levels_of(result, name, **other)):
        if successes(result, **{name: level}, **other).min() < 1:
            return index
    return None


def largest_errors(results, sweeps):
    """Largest error (px) over the successful trials of every level."""
    found = []
    for sweep in sweeps:
        result = results[experiment_of(sweep)]
        for condition in result.conditions:
            if condition["levels"] != "full range":
                continue
            errors = result.column("max_px", **condition)
            if np.isfinite(errors).any():
                found.append(np.nanmax(errors))
    return np.array(found)


def limit(result, name, **other):
    """(last level without a loss, first level with one): the bracket.

    Infinite where no level of the sweep has a loss.
    """
    levels = levels_of(result, name, **other)
    index = first_lost(result, name, **other)
    if index is None:
        return float(levels[-1]), np.inf
    before = float(levels[index - 1]) if index else -np.inf
    return before, float(levels[index])


def first_limit(result, name, what, unit, **other):
    """Value of the first level with a lost trial, in its bracket."""
    before, first = limit(result, name, **other)
    return bracketed(
        before,
        first,
        unit,
        f"{what}: first level with a lost trial; the interval begins at the "
        "level before it",
    )


def bracketed(before, first, unit, reason):
    """Value of a level between two; the last one where nothing happens."""
    if np.isinf(first):
        reason = "not reached: this is the last level of the sweep"
        first = before
    return Value(
        first,
        interval=(max(before, 0.0), first),
        unit=unit,
        reason=reason,
    )


def smallest_square(result):
    """(square px, least spacing px) of the smallest never lost."""
    across = levels_of(result, "squares_across")
    kept = [
        n for n in across if successes(result, squares_across=n).min() == 1
    ]
    if not kept:
        return np.nan, np.nan
    spacing = result.column("least_px", squares_across=max(kept))[0]
    return SIZE_PX / max(kept), float(spacing)


def blur_that_hurts(result):
    """(level before, first blur SD in px whose outcome is worse than 1 px's).

    Worse: a fifth fewer successes, or a mean error 1.25 times as large.
    """
    levels = [b for b in levels_of(result, "blur_px") if b >= 1]
    right = [successes(result, blur_px=b).mean() for b in levels]
    means = [
        np.nanmedian(result.column("mean_px", blur_px=b))
        if right[k]
        else np.inf
        for k, b in enumerate(levels)
    ]
    for k in range(1, len(levels)):
        if right[k] <= right[0] - 0.2 or means[k] >= 1.25 * means[0]:
            return float(levels[k - 1]), float(levels[k])
    return float(levels[-1]), np.inf


@numbers(
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
)
def numbers_fig_3_11(results):
    """The settings of the sweeps as they were run, and their limits."""
    noise = results["fig_3_11_noise"]
    ran, default = noise.settings, noise.settings["defaults"]
    square, spacing = smallest_square(results["fig_3_11_square"])
    before, blurred = blur_that_hurts(results["fig_3_11_blur"])
    largest = float(largest_errors(results, WITHOUT_BLUR).max())
    return numbers_of_basin(results) | {
        "s3_3_1_img": Value(ran["image_px"], unit="px"),
        "s3_3_1_fov": Value(default["fov_deg"], unit="deg"),
        "s3_3_1_blur0": Value(default["blur_px"], unit="px"),
        "s3_3_1_user_sd": Value(ran["clicks"]["sd_px"], unit="px"),
        "s3_3_1_user_cap": Value(ran["clicks"]["cap_px"], unit="px"),
        "s3_3_1_trials": Value(noise.trials_per_condition, unit="count"),
        "s3_3_1_fail": Value(ran["lost_px"], unit="px"),
        "s3_3_1_maxerr": Value(
            largest,
            interval=(largest, largest),
            unit="px",
            reason="largest over all trials of four sweeps",
        ),
        "s3_3_1_noise_fail": first_limit(
            noise, "noise_sd", "noise", "grey levels", **FULL
        ),
        "s3_3_1_yaw_fail": first_limit(
            results["fig_3_11_yaw"], "yaw_deg", "yaw", "deg"
        ),
        "s3_3_1_pitch_ok": Value(
            square,
            interval=(square, square),
            unit="px",
            reason="smallest square of the sweep in which no trial is lost",
        ),
        "s3_3_1_intercorner": Value(
            spacing,
            interval=(spacing, spacing),
            unit="px",
            reason="least distance of corners with that square",
        ),
        "s3_3_1_blur_fail": bracketed(
            before,
            blurred,
            "px",
            "first blur worse than 1 px by a fifth of the trials or a "
            "quarter of the mean error; the interval begins at the level "
            "before it",
        ),
    }


def numbers_of_basin(results):
    """Numbers of Fig. 3.11(f), for the producer of that figure's numbers."""
    result = results["fig_3_11_localised"]
    window = "full window"
    worst = worst_within(result, window)
    start = farthest_start(result, window)
    wide = worst_within(result, "half window")
    reason = (
        "9 x 9 pixels as printed; with OpenCV's half window of 9 the "
        "largest error is "
    )
    return {
        "s3_3_1_loc_win": Value(
            2 * result.settings["half_windows"][window] + 1, unit="px"
        ),
        "s3_3_1_loc_max": Value(
            worst,
            interval=(worst, worst),
            unit="px",
            reason=f"{reason}{wide:.2f} px",
        ),
        "s3_3_1_loc_init": Value(
            start,
            interval=(start, start),
            unit="px",
            reason=f"largest start error of the sweep with all corners "
            f"within {LOCALISED_PX} px; 9 x 9 pixels as printed; with a half "
            f"window of 9 it is {farthest_start(result, 'half window'):g}",
        ),
    }


@numbers("sec_3_3_1", needs=("fig_3_11_noise",), evidence="rendered")
def numbers_sec_3_3_1(results):
    """The clicks, simulated here."""
    result = results["fig_3_11_noise"]
    offsets = np.concatenate(
        [result.column("click_px", **c) for c in result.conditions]
    )
    return {
        "s3_3_1_click_mean": Value(
            float(offsets.mean()),
            unit="px",
            reason="simulated clicks, with the SD and the cap that 3.3.1 "
            "gives: nearly three times as far off as the author's own",
        ),
        "s3_3_1_click_sd": Value(
            float(2 * offsets.std()),
            unit="px",
            reason="of the same simulated clicks, twice the SD of the means of "
            "four; the printed 0.16 is the "
            "variance, in px², of a Rayleigh law with the printed mean "
            "(E-3.13)",
        ),
    }


def told(number, digits=0):
    """A level in words: "none" where a sweep has none."""
    return f"{number:.{digits}f}" if np.isfinite(number) else "none"


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    results = {
        experiment_of(s): open_results(experiment_of(s)) for s in SWEEPS
    }
    noise = results["fig_3_11_noise"]
    value("trials", noise.trials_per_condition)
    for option, name in (("full range", "noise"), ("half range", "half")):
        before, first = limit(noise, "noise_sd", levels=option)
        value(f"{name}.kept", told(before))
        value(f"{name}.lost", told(first))
    for sweep in ("fov", "yaw"):
        before, first = limit(results[experiment_of(sweep)], SWEEPS[sweep])
        value(f"{sweep}.kept", told(before))
        value(f"{sweep}.lost", told(first))
    square, spacing = smallest_square(results["fig_3_11_square"])
    value("square", told(square))
    value("spacing", told(spacing, 1))
    before, blurred = blur_that_hurts(results["fig_3_11_blur"])
    value("blur.kept", told(before))
    value("blur.lost", told(blurred))
    value("largest", float(largest_errors(results, WITHOUT_BLUR).max()))
    value("largest.any", float(largest_errors(results, SWEEPS).max()))
    default = {"noise_sd": 0, **FULL}
    value("mean", float(np.nanmedian(noise.column("mean_px", **default))))
    lost = {"square": {}, "fov": {}, "noise": {}, "blur": {}}
    for sweep, stages in lost.items():
        result = results[experiment_of(sweep)]
        for condition in result.conditions:
            for stage in result.texts("stage", **condition):
                stages[stage] = stages.get(stage, 0) + 1
        stages.pop("done", None)
        most = max(stages, key=stages.get, default="none")
        value(f"{sweep}.stage", most)
        value(f"{sweep}.stage.count", stages.get(most, 0))
        value(f"{sweep}.losses", sum(stages.values()))
    yaw = results[experiment_of("yaw")]
    ends = [e for c in yaw.conditions for e in yaw.texts("stage", **c)]
    value("yaw.few", ends.count(TOO_FEW))
    # A trial whose corners are not all in the picture has no contour.
    lost = [e for c in yaw.conditions for e in yaw.texts("contour", **c)]
    value("yaw.losses", len(lost) - lost.count(None))
    value("blur.largest", max(BLUR_PX))
    value("fov.default", DEFAULT_FOV)
    basin = open_results("fig_3_11_localised")
    for window in HALF_WINDOWS:
        name = window.replace(" ", "_")
        value(f"{name}.worst", worst_within(basin, window))
        value(f"{name}.reach", farthest_start(basin, window))
