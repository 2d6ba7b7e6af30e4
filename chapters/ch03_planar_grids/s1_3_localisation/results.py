"""The numbers that the page of section 3.1.3 quotes."""

from __future__ import annotations

import numpy as np

from chapters.ch03_planar_grids.s1_3_localisation.claims import (
    Swept,
    gain_of_bins,
    ratio_of_middle_blur,
)
from chapters.ch03_planar_grids.s3_1_robustness.claims.localisation import (
    farthest_start,
    worst_within,
)
from chapters.ch03_planar_grids.s3_1_robustness.trials.localisation import (
    HALF_WINDOWS,
    OTHERS,
    SQUARES_PX,
)
from repro.page.reader import value


def best_setting(swept):
    """(window, blur or nan, median px) of the least median over all corners."""
    flat = np.median(swept.error.reshape(len(swept.error), -1), axis=0)
    place = int(flat.argmin())
    if not len(swept.blurs):
        return swept.windows[place], np.nan, flat[place]
    window, blur = divmod(place, len(swept.blurs))
    return swept.windows[window], swept.blurs[blur], flat[place]


def excess_of_one_setting(swept):
    """Largest ratio over bins of the best single setting to the bin's own."""
    flat = swept.error.reshape(len(swept.error), -1)
    place = int(np.median(flat, axis=0).argmin())
    ratios = []
    for k in swept.bins:
        median = np.median(flat[swept.bin == k], axis=0)
        ratios.append(median[place] / median.min())
    return max(ratios)


def winners_at(swept, window):
    """Share (%) of corners for which a window is the best."""
    return 100 * float(np.mean(swept.best_window == window))


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    results = {
        name: open_results(f"fig_3_5_{name}")
        for name in ("derivative", "saddle")
    }
    swept = {name: Swept(result) for name, result in results.items()}
    value("images", results["saddle"].trials_per_condition)
    value("corners", len(swept["saddle"].error))
    for name, one in swept.items():
        window, _, median = best_setting(one)
        value(f"{name}.window", float(window))
        value(f"{name}.median", float(median))
        value(f"{name}.excess", 100 * (excess_of_one_setting(one) - 1))
        value(f"{name}.gain", 100 * gain_of_bins(one).value)
        value(
            f"{name}.gain_median", 100 * gain_of_bins(one, np.median).value
        )
    blur = float(best_setting(swept["saddle"])[1])
    value("saddle.blur", blur)
    value("saddle.twice_blur", 2 * blur)
    found, count = np.unique(
        swept["saddle"].best_window, return_counts=True
    )
    modal = found[count.argmax()]
    value("saddle.modal", float(modal))
    value("saddle.at_modal", winners_at(swept["saddle"], modal))
    value("saddle.lucky", _median_of_winners(swept["saddle"]))
    value("derivative.at_5", _median_at(swept["derivative"], 0))
    ratios = [r.value for r in ratio_of_middle_blur(swept["saddle"])]
    middle = swept["saddle"].middle_blur
    value("blur.middle", float(swept["saddle"].blurs[middle]))
    value("blur.least", min(ratios))
    value("blur.most", max(ratios))
    _name_spreads(open_results("ext_localiser_spread"))
    _name_basin(open_results("fig_3_11_localised"))


def _median_at(swept, place):
    return float(np.median(swept.error[:, place]))


def _median_of_winners(swept):
    """Median residual (px) of a corner's own best setting: luck included."""
    return float(
        np.median(swept.error.reshape(len(swept.error), -1).min(1))
    )


def _name_spreads(result):
    """Of the smallest squares the bias by itself; the rest without them."""
    nearest = SQUARES_PX[0]
    for name in ("saddle point", "derivative", "OpenCV"):
        near = result.column(f"{name}.bias_px", square_px=nearest)
        value(f"{name}.near_bias_px", float(near.mean()))
        for what in ("rms_px", "sd_px", "bias_px", "score_sd"):
            found = [
                result.column(f"{name}.{what}", square_px=square).mean()
                for square in SQUARES_PX[1:]
            ]
            value(f"{name}.{what}", float(np.mean(found)))


def _name_basin(result):
    for name in (*HALF_WINDOWS, *OTHERS):
        value(f"{name}.start", farthest_start(result, name))
        value(f"{name}.worst", worst_within(result, name))
