"""The residuals of section 3.1.3, corner by corner, and the numbers it quotes."""

from functools import cached_property

import numpy as np

from chapters.ch03_planar_grids.s1_3_localisation.trials import SQUARES_PX
from repro.judge.statistics import bootstrap
from repro.page.reader import value
from repro.page.wording import rounded
from repro.run.experiment import numbers
from repro.run.outcomes import Value

BIN_EDGES_PX = np.arange(10, 171, 20)
# Share of the bins in which windows have to be small.
SHARE_OF_BINS = 0.8
# Most that one blur may cost in a bin, as a factor.
MAX_RATIO = 1.15


class Swept:
    """Residuals of all corners of an experiment, over its settings.

    error: (M, windows) or (M, windows, blurs) px. distance: (M,) px. half: (M,),
    which of two halves a corner belongs to: that of its image. images_of: (corners,
    images), where in M the images of one corner of the board are.
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
        """Which distance bin (M,) a corner is in."""
        return np.digitize(self.distance, BIN_EDGES_PX) - 1

    @cached_property
    def bins(self):
        """The bins that have corners, nearest first."""
        return np.unique(self.bin)

    def by_bin(self, values):
        """The parts of values (M, ...) in each bin, nearest first."""
        return [values[self.bin == k] for k in self.bins]

    @cached_property
    def best(self):
        """Places (M,) of the least residual over flattened settings."""
        return self.flat.argmin(axis=1)

    @property
    def best_window(self):
        """Window (M,) of the least residual, px."""
        return self.windows[self.best // max(len(self.blurs), 1)]

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

    def mid_range_blurs(self, reading):
        """Places of the blurs of which one is the mid-range one, by reading."""
        if reading == "middle of the sweep":
            return [self.middle_blur]
        return list(range(1, len(self.blurs) - 1))

    def chosen_blurs(self, places):
        """The blurs (px), of `places`, that either half of the corners chooses."""
        scores = [np.median(self.flat[self.half == half], axis=0) for half in (0, 1)]
        chosen = {best_blur(of_half, len(self.blurs), places) for of_half in scores}
        return [float(self.blurs[place]) for place in sorted(chosen)]

    def scored(self, choose):
        """Residuals (M,) with settings chosen on the other half.

        choose: (errors (m, settings), bins (m,)) -> place of the setting for every
        bin (bins,), of one half; it is applied to the other.
        """
        out = np.empty(len(self.flat))
        for half in (0, 1):
            chosen, rows = self.half == half, np.flatnonzero(self.half != half)
            places = choose(self.flat[chosen], self.bin[chosen])
            out[rows] = self.flat[rows, places[self.bin[rows]]]
        return out


def per_bin(statistic, allowed=None):
    """A choice of the best setting in every bin, of all or the `allowed` ones.

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
    """A choice of one setting for all bins."""

    def choose(errors, bins):
        place = _best(statistic(errors, axis=0), None)
        return np.full(len(BIN_EDGES_PX) - 1, place)

    return choose


def best_blur(scores, count, places):
    """Place of the blur, of `places`, that has the least of scores (settings,)."""
    of_blur = scores.reshape(-1, count).min(axis=0)
    return min(places, key=of_blur.__getitem__)


def at_one_blur(statistic, count, places):
    """A choice of one blur for all bins, the best of `places`, with each bin's window.

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
    """Share of the mean (or median) residual that a choice per bin saves."""
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
    """The most frequent of values (n,), the least of them in a tie."""
    found, count = np.unique(values, return_counts=True)
    return found[count.argmax()]


def least_range(swept, share):
    """Where a range of windows must end, px, to have `share` of the bins small.

    Small: the modal window is in the lowest third of a range that begins as ours.
    """
    windows = np.sort(modal_windows(swept))
    last = windows[int(np.ceil(share * len(windows))) - 1]
    return swept.windows[0] + 3.0 * (last - swept.windows[0])


def best_setting(swept):
    """(window, blur or nan, median px) of the least median over all corners."""
    medians = np.median(swept.flat, axis=0)
    window, blur = divmod(int(medians.argmin()), max(len(swept.blurs), 1))
    blur_px = swept.blurs[blur] if len(swept.blurs) else np.nan
    return swept.windows[window], blur_px, medians.min()


def best_windows(swept):
    """Window (bins,) px of the least median residual, nearest bin first."""
    errors = swept.by_bin(swept.error)
    return swept.windows[[np.median(one, axis=0).argmin() for one in errors]]


def excess_of_one_setting(swept):
    """Largest ratio over bins of the best single setting to the bin's own."""
    place = int(np.median(swept.flat, axis=0).argmin())
    medians = [np.median(one, axis=0) for one in swept.by_bin(swept.flat)]
    return max(median[place] / median.min() for median in medians)


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
            reason=f"square sizes; {result.trials_per_condition} images of each",
        ),
        "fig3_5_blur": Value(ran["blur_px"], unit="px"),
        "fig3_5_noise": Value(ran["noise_sd"], unit="grey levels"),
        "fig3_5_init": Value(ran["start_sd_px"], unit="px"),
    } | scales


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    results = {
        name: open_results(f"fig_3_5_{name}") for name in ("derivative", "saddle")
    }
    swept = {name: Swept(result) for name, result in results.items()}
    derivative, saddle = swept.values()
    windows = best_windows(derivative)
    quoted = {
        "images": results["saddle"].trials_per_condition,
        **of_method("derivative", derivative),
        **of_method("saddle", saddle),
        "derivative.narrowest": float(windows.min()),
        "derivative.widest": float(windows.max()),
        "derivative.excess": 100 * float(excess_of_one_setting(derivative) - 1),
        "derivative.at_5": np.median(derivative.error[:, 0]),
        "small.range": least_range(derivative, SHARE_OF_BINS),
        "saddle.blur": best_setting(saddle)[1],
        "saddle.modal": float(modal(saddle.best_window)),
        # A corner's own best setting: luck included.
        "saddle.lucky": np.median(saddle.flat.min(1)),
        "blur.middle": saddle.blurs[saddle.middle_blur],
        "most_ratio": MAX_RATIO,
        "interior.most": most_of_one_blur(saddle, "best interior blur"),
        "middle.most": most_of_one_blur(saddle, "middle of the sweep"),
    }
    for name, number in quoted.items():
        value(name, number)


def of_method(name, swept):
    """The best single setting of a method, and what a choice per bin saves."""
    window, _, median = best_setting(swept)
    return {
        f"{name}.window": float(window),
        f"{name}.median": float(median),
        f"{name}.gain_median": 100 * gain_of_bins(swept, np.median).value,
    }


def most_of_one_blur(swept, option):
    """The largest ratio over bins by an option of `mid_range_blur`, in words."""
    ratios = ratio_of_one_blur(swept, swept.mid_range_blurs(option))
    worst = max(ratios, key=lambda ratio: ratio.value)
    return rounded(worst.value, (worst.low, worst.high))
