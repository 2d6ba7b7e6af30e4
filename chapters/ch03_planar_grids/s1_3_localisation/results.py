"""Residuals of section 3.1.3 for each corner, and the quoted numbers."""

from functools import cached_property

import numpy as np

from chapters.ch03_planar_grids.s1_3_localisation.trials import SQUARES_PX
from repro.judge.statistics import bootstrap
from repro.page.reader import value
from repro.page.wording import rounded
from repro.run.experiment import numbers
from repro.run.outcomes import Value

BIN_EDGES_PX = np.arange(10, 171, 20)
# Minimum share of the bins with small windows.
SHARE_OF_BINS = 0.8
# Largest accepted cost of one blur in a bin, as a factor.
MAX_RATIO = 1.15


class Swept:
    """Residuals of all corners of an experiment, over its settings.

    error: (M, windows) or (M, windows, blurs) px. distance: (M,) px. half: (M,)
    half of the images, 0 or 1. images_of: (corners, images), indices into M of the
    images of one corner of the board.
    """

    def __init__(self, result):
        squares = [
            (of.arrays("error"), of.arrays("distance"))
            for of in result.by("square_px").values()
        ]
        self.error = np.concatenate([e for es, _ in squares for e in es]).astype(float)
        self.distance = np.concatenate([d for _, ds in squares for d in ds])
        # A single image is halved corner by corner.
        self.half = np.concatenate(
            [
                np.full(len(one), trial % 2) if len(es) > 1 else np.arange(len(one)) % 2
                for es, _ in squares
                for trial, one in enumerate(es)
            ]
        )
        self.images_of, before = [], 0
        for _, distances in squares:
            place = before + np.arange(sum(map(len, distances)))
            self.images_of.append(place.reshape(len(distances), -1).T)
            before += len(place)
        first = result.conditions[0]
        self.windows = np.array(first["windows"])
        self.blurs = np.array(first.get("blurs", []))

    @cached_property
    def flat(self):
        """Residuals (M, settings) over flattened settings."""
        return self.error.reshape(len(self.error), -1)

    @cached_property
    def bin(self):
        """Index (M,) of the distance bin of each corner."""
        return np.digitize(self.distance, BIN_EDGES_PX) - 1

    @cached_property
    def bins(self):
        """Bins with corners, nearest first."""
        return np.unique(self.bin)

    def by_bin(self, values):
        """Split values (M, ...) by bin, nearest first."""
        return [values[self.bin == k] for k in self.bins]

    @cached_property
    def best(self):
        """Index (M,) of the smallest residual over flattened settings."""
        return self.flat.argmin(axis=1)

    @property
    def best_window(self):
        """Window (M,) of the smallest residual, px."""
        return self.windows[self.best // max(len(self.blurs), 1)]

    @property
    def best_blur(self):
        """Blur (M,) of the smallest residual, px."""
        return self.blurs[self.best % len(self.blurs)]

    @property
    def lowest_third(self):
        """Largest window of the lowest third of the sweep, px."""
        low, high = self.windows[0], self.windows[-1]
        return low + (high - low) / 3

    @property
    def middle_blur(self):
        """Index of the blur in the middle of the sweep."""
        return len(self.blurs) // 2

    def mid_range_blurs(self, reading):
        """Indices of the blurs that count as mid-range in an interpretation."""
        if reading == "middle of the sweep":
            return [self.middle_blur]
        return list(range(1, len(self.blurs) - 1))

    def chosen_blurs(self, places):
        """Blurs (px), of `places`, that the two halves of the corners choose."""
        scores = [np.median(self.flat[self.half == half], axis=0) for half in (0, 1)]
        chosen = {best_blur(of_half, len(self.blurs), places) for of_half in scores}
        return [float(self.blurs[place]) for place in sorted(chosen)]

    def scored(self, choose):
        """Residuals (M,) with settings chosen on the other half.

        choose: (errors (m, settings), bins (m,)) of one half -> index (bins,) of the
        setting for every bin of the other half.
        """
        out = np.empty(len(self.flat))
        for half in (0, 1):
            chosen, rows = self.half == half, np.flatnonzero(self.half != half)
            places = choose(self.flat[chosen], self.bin[chosen])
            out[rows] = self.flat[rows, places[self.bin[rows]]]
        return out


def per_bin(statistic, allowed=None):
    """Return a choice of the best setting per bin, of all or the `allowed` ones.

    A bin without corners in this half takes the best of all.
    """

    def choose(errors, bins):
        inside = [errors[bins == k] for k in range(len(BIN_EDGES_PX) - 1)]
        return np.array(
            [
                _best(statistic(one if len(one) else errors, axis=0), allowed)
                for one in inside
            ]
        )

    return choose


def single(statistic):
    """Return a choice of one setting for all bins."""

    def choose(errors, bins):
        place = _best(statistic(errors, axis=0), None)
        return np.full(len(BIN_EDGES_PX) - 1, place)

    return choose


def best_blur(scores, count, places):
    """Index of the blur, of `places`, with the smallest of scores (settings,)."""
    of_blur = scores.reshape(-1, count).min(axis=0)
    return min(places, key=of_blur.__getitem__)


def at_one_blur(statistic, count, places):
    """Return a choice of one blur for all bins, of `places`, with each bin's window.

    count: blurs of the sweep; the settings are windows by blurs, flattened.
    """

    def choose(errors, bins):
        blur = best_blur(statistic(errors, axis=0), count, places)
        settings = np.arange(errors.shape[1])
        return per_bin(statistic, settings[settings % count == blur])(errors, bins)

    return choose


def _best(scores, allowed):
    if allowed is None:
        return int(scores.argmin())
    return int(allowed[scores[allowed].argmin()])


def gain_of_bins(swept, statistic=np.mean):
    """Share of the mean (or median) residual saved by a choice per bin."""
    return bootstrap(
        lambda a, b: 1 - statistic(a, axis=-1) / statistic(b, axis=-1),
        swept.scored(per_bin(statistic)),
        swept.scored(single(statistic)),
        paired=True,
    )


def ratio_of_one_blur(swept, places):
    """Median residual at the best blur of `places` over that at the bin's own setting.

    The blur is one for all bins, chosen like the settings on the other half; the
    window is that of the bin in both. One Estimate for every bin.
    """
    fixed = swept.scored(at_one_blur(np.median, len(swept.blurs), places))
    best = swept.scored(per_bin(np.median))
    return [
        bootstrap(
            lambda a, b: np.median(a, axis=-1) / np.median(b, axis=-1),
            *of_bin,
            paired=True,
        )
        for of_bin in zip(swept.by_bin(fixed), swept.by_bin(best), strict=True)
    ]


def modal_windows(swept):
    """Most frequent best window (bins,) px, nearest bin first."""
    return np.array([modal(best) for best in swept.by_bin(swept.best_window)])


def modal(values):
    """Most frequent of values (n,), the smallest one in a tie."""
    found, count = np.unique(values, return_counts=True)
    return found[count.argmax()]


def best_setting(swept):
    """(window, blur or nan, median px) of the smallest median over all corners."""
    medians = np.median(swept.flat, axis=0)
    window, blur = divmod(int(medians.argmin()), max(len(swept.blurs), 1))
    blur_px = swept.blurs[blur] if len(swept.blurs) else np.nan
    return swept.windows[window], blur_px, medians.min()


def excess_of_one_setting(swept):
    """Largest ratio over bins of the best single setting to the bin's own."""
    place = int(np.median(swept.flat, axis=0).argmin())
    medians = [np.median(one, axis=0) for one in swept.by_bin(swept.flat)]
    return max(median[place] / median.min() for median in medians)


@numbers("fig_3_5", needs=("fig_3_5_derivative",), evidence="rendered")
def numbers_fig_3_5(results):
    """Settings of the study as run."""
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
            reason=f"square sizes; {result.trials_per_condition} images of each",
        ),
        "fig3_5_blur": Value(ran["blur_px"], unit="px"),
        "fig3_5_noise": Value(ran["noise_sd"], unit="grey levels"),
        "fig3_5_init": Value(ran["start_sd_px"], unit="px"),
    } | scales


def name_values(open_results):
    """Name the numbers that the page quotes."""
    swept = {
        name: Swept(open_results(f"fig_3_5_{name}"))
        for name in ("derivative", "saddle")
    }
    quoted = {
        **of_method("derivative", swept["derivative"]),
        **of_method("saddle", swept["saddle"]),
        "interior.most": cost_of_one_blur(swept["saddle"], "best interior blur"),
        "middle.most": cost_of_one_blur(swept["saddle"], "middle of the sweep"),
    }
    for name, number in quoted.items():
        value(name, number)


def of_method(name, swept):
    """Best single window of a method, and gain of a choice per bin."""
    return {
        f"{name}.window": float(best_setting(swept)[0]),
        f"{name}.gain_median": 100 * gain_of_bins(swept, np.median).value,
    }


def cost_of_one_blur(swept, option):
    """Largest ratio over bins, as text, for an option of `mid_range_blur`."""
    ratios = ratio_of_one_blur(swept, swept.mid_range_blurs(option))
    worst = max(ratios, key=lambda ratio: ratio.value)
    return rounded(worst.value, (worst.low, worst.high))
