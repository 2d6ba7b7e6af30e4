"""The residuals of section 3.1.3, corner by corner, and the numbers it quotes."""

from __future__ import annotations

from functools import cached_property

import numpy as np

from chapters.ch03_planar_grids.s1_3_localisation.trials import SQUARES_PX
from chapters.shared.localiser_basin import (
    HALF_WINDOWS,
    OTHERS,
    farthest_start,
    worst_within,
)
from repro.judge.statistics import bootstrap
from repro.page.reader import value
from repro.run.experiment import numbers
from repro.run.outcomes import Value

BIN_EDGES_PX = np.arange(10, 171, 20)


class Swept:
    """Residuals of all corners of an experiment, over its settings.

    error: (M, windows) or (M, windows, blurs) px. distance: (M,) px. half: (M,),
    which of two halves a corner belongs to: that of its image. images_of: (corners,
    images), where in M the images of one corner of the board are.
    """

    def __init__(self, result):
        errors, distances, halves, images_of = [], [], [], []
        before = 0
        for condition in result.conditions:
            square = {"square_px": condition["square_px"]}
            error = result.arrays("error", **square)
            distance = result.arrays("distance", **square)
            place = before + np.arange(sum(map(len, distance)))
            images_of.append(place.reshape(len(distance), -1).T)
            before += len(place)
            for trial, (one, apart) in enumerate(
                zip(error, distance, strict=True)
            ):
                errors.append(one)
                distances.append(apart)
                # A single image is halved corner by corner.
                alone = len(error) == 1
                halves.append(
                    np.arange(len(one)) % 2
                    if alone
                    else np.full(len(one), trial % 2)
                )
        first = result.conditions[0]
        self.error = np.concatenate(errors).astype(float)
        self.distance = np.concatenate(distances)
        self.half = np.concatenate(halves)
        self.images_of = images_of
        self.windows = np.array(first["windows"])
        self.blurs = np.array(first.get("blurs", []))

    @cached_property
    def bin(self):
        """Which distance bin (M,) a corner is in."""
        return np.digitize(self.distance, BIN_EDGES_PX) - 1

    @cached_property
    def bins(self):
        """The bins that have corners, nearest first."""
        return np.unique(self.bin)

    @cached_property
    def best(self):
        """Places (M,) of the least residual over flattened settings."""
        return self.error.reshape(len(self.error), -1).argmin(axis=1)

    @property
    def best_window(self):
        """Window (M,) of the least residual, px."""
        if not len(self.blurs):
            return self.windows[self.best]
        return self.windows[self.best // len(self.blurs)]

    @property
    def best_blur(self):
        """Blur (M,) of the least residual, px."""
        return self.blurs[self.best % len(self.blurs)]

    @property
    def lowest_third(self):
        """Largest window of the lowest third of the sweep, px."""
        low, high = self.windows[0], self.windows[-1]
        return low + (high - low) / 3

    @property
    def middle_blur(self):
        """Place of the blur in the middle of the sweep."""
        return len(self.blurs) // 2

    def scored(self, choose):
        """Residuals (M,) with settings chosen on the other half.

        choose: (errors (m, settings), bins (m,)) -> place of the setting for every
        bin (bins,), of one half; it is applied to the other.
        """
        flat = self.error.reshape(len(self.error), -1)
        out = np.empty(len(flat))
        for half in (0, 1):
            chosen, scored = self.half == half, self.half != half
            places = choose(flat[chosen], self.bin[chosen])
            rows = np.flatnonzero(scored)
            out[rows] = flat[rows, places[self.bin[rows]]]
        return out


def per_bin(statistic, allowed=None):
    """A choice of the best setting in every bin, of all or the `allowed` ones.

    A bin without corners in this half takes the best of all.
    """

    def choose(errors, bins):
        places = np.empty(len(BIN_EDGES_PX) - 1, dtype=int)
        whole = _best(statistic(errors, axis=0), allowed)
        for k in range(len(places)):
            inside = errors[bins == k]
            places[k] = (
                _best(statistic(inside, axis=0), allowed)
                if len(inside)
                else whole
            )
        return places

    return choose


def single(statistic):
    """A choice of one setting for all bins."""

    def choose(errors, bins):
        place = _best(statistic(errors, axis=0), None)
        return np.full(len(BIN_EDGES_PX) - 1, place)

    return choose


def _best(scores, allowed):
    if allowed is None:
        return int(scores.argmin())
    return int(allowed[scores[allowed].argmin()])


def gain_of_bins(swept, statistic=np.mean):
    """Share of the mean (or median) residual that a choice per bin saves."""
    chosen = swept.scored(per_bin(statistic))
    alike = swept.scored(single(statistic))
    return bootstrap(
        lambda a, b: 1 - statistic(a, axis=-1) / statistic(b, axis=-1),
        chosen,
        alike,
        paired=True,
    )


def ratio_of_middle_blur(swept):
    """Median residual at the middle blur over that at the bin's best setting.

    The window is that of the bin in both. One Estimate for every bin.
    """
    settings = np.arange(swept.error[0].size)
    middle = settings[settings % len(swept.blurs) == swept.middle_blur]
    fixed = swept.scored(per_bin(np.median, middle))
    best = swept.scored(per_bin(np.median))
    return [
        bootstrap(
            lambda a, b: np.median(a, axis=-1) / np.median(b, axis=-1),
            fixed[swept.bin == k],
            best[swept.bin == k],
            paired=True,
        )
        for k in swept.bins
    ]


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


@numbers("fig_3_5", needs=("fig_3_5_derivative",), evidence="rendered")
def numbers_fig_3_5(results):
    """The settings of the study, as they were run."""
    result = results["fig_3_5_derivative"]
    ran = result.settings
    scales = {
        f"fig3_5_sq{square}": Value(c["square_px"], unit="px")
        for square, c in zip(SQUARES_PX, result.conditions, strict=True)
    }
    return {
        "fig3_5_img": Value(ran["image_px"], unit="px"),
        "fig3_5_n": Value(
            len(result.conditions),
            unit="count",
            reason="square sizes; "
            f"{result.trials_per_condition} images of each",
        ),
        "fig3_5_blur": Value(ran["blur_px"], unit="px"),
        "fig3_5_noise": Value(ran["noise_sd"], unit="grey levels"),
        "fig3_5_init": Value(ran["start_sd_px"], unit="px"),
    } | scales


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
