"""Results of this page read: values of the prose, figures, tables, judgements."""

from functools import cached_property

import numpy as np

from chapters.ch03_planar_grids.s1_3_localisation.experiment import SQUARES_PX
from repro.page import new_figure, rounded, value
from repro.run import (
    FAILS,
    HOLDS,
    RESAMPLES,
    Check,
    Drawing,
    Estimate,
    Reading,
    Value,
    all_of,
    bootstrap,
    claim,
    columns,
    figure,
    numbers,
)

# Residuals of section 3.1.3 for each corner, and the quoted numbers.


METHODS = ("derivative", "saddle")
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
        ends = np.cumsum([sum(map(len, distances)) for _, distances in squares])
        places = np.split(np.arange(ends[-1]), ends[:-1])
        self.images_of = [
            place.reshape(len(distances), -1).T
            for place, (_, distances) in zip(places, squares, strict=True)
        ]
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
        return self.windows[0] + np.ptp(self.windows) / 3

    def mid_range_blurs(self, option):
        """Indices of the blurs that count as mid-range in an interpretation."""
        if option == "middle of the sweep":
            return [len(self.blurs) // 2]
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
        settings = np.arange(errors.shape[1]) if allowed is None else allowed
        inside = [errors[bins == k] for k in range(len(BIN_EDGES_PX) - 1)]
        scores = [statistic(one if len(one) else errors, axis=0) for one in inside]
        return settings[np.array(scores)[:, settings].argmin(axis=1)]

    return choose


def single(statistic):
    """Return a choice of one setting for all bins."""
    return lambda errors, bins: np.full(
        len(BIN_EDGES_PX) - 1, statistic(errors, axis=0).argmin()
    )


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
    swept = {name: Swept(open_results(f"fig_3_5_{name}")) for name in METHODS}
    quoted = {}
    for name, one in swept.items():
        best = np.median(one.flat, axis=0).argmin() // max(len(one.blurs), 1)
        quoted[f"{name}.window"] = float(one.windows[best])
        quoted[f"{name}.gain_median"] = 100 * gain_of_bins(one, np.median).value
    for name, option in (
        ("interior", "best interior blur"),
        ("middle", "middle of the sweep"),
    ):
        places = swept["saddle"].mid_range_blurs(option)
        ratios = ratio_of_one_blur(swept["saddle"], places)
        worst = max(ratios, key=lambda ratio: ratio.value)
        quoted[f"{name}.most"] = rounded(worst.value, (worst.low, worst.high))
    for name, number in quoted.items():
        value(name, number)


# Fig. 3.5: best settings of two localisers over the inter-corner distance.


def frequencies(swept, best, levels):
    """Share (levels, bins) of the corners of a bin for which a level is best."""
    shares = np.full((len(levels), len(BIN_EDGES_PX) - 1), np.nan)
    for k, inside in zip(swept.bins, swept.by_bin(best), strict=True):
        shares[:, k] = np.mean(inside[:, None] == levels, axis=0)
    return shares


def medians_of(swept):
    """Median residual (windows[, blurs], bins) px."""
    shape = swept.error.shape[1:]
    out = np.full((*shape, len(BIN_EDGES_PX) - 1), np.nan)
    for k in swept.bins:
        out[..., k] = np.median(swept.error[swept.bin == k], axis=0)
    return out


@figure("fig_3_5", needs=("fig_3_5_derivative", "fig_3_5_saddle"), evidence="rendered")
def fig_3_5(results):
    """Histograms of the best setting, next to the median residual."""
    from matplotlib.colors import LogNorm

    derivative, saddle = (Swept(results[f"fig_3_5_{name}"]) for name in METHODS)
    over = medians_of(saddle)
    rows = (
        (
            "(a) Derivative: window",
            "Window (px)",
            derivative.windows,
            frequencies(derivative, derivative.best_window, derivative.windows),
            medians_of(derivative),
        ),
        (
            "(b) Saddle point: window",
            "Window (px)",
            saddle.windows,
            frequencies(saddle, saddle.best_window, saddle.windows),
            over.min(axis=1),
        ),
        (
            "(b) Saddle point: blur",
            "Blur SD (px)",
            saddle.blurs,
            frequencies(saddle, saddle.best_blur, saddle.blurs),
            over.min(axis=0),
        ),
    )
    drawn, axes = new_figure(3, 2, height_in=9.0, sharex=True, sharey="row")
    cells = []
    all_medians = np.concatenate([row[4].ravel() for row in rows])
    norm = LogNorm(np.nanmin(all_medians), min(1.5, np.nanmax(all_medians)))
    sums = []
    for panels, (title, label, levels, share, median) in zip(axes, rows, strict=True):
        _slices(drawn, panels[0], levels, 100 * share, "Share of corners (%)")
        mesh = _slices(
            drawn, panels[1], levels, median, "Median residual (px)", norm=norm
        )
        mesh.set_cmap("viridis_r")
        middles = (BIN_EDGES_PX[1:] + BIN_EDGES_PX[:-1]) / 2
        filled = np.isfinite(median[0])
        lowest = np.nanargmin(median[:, filled], axis=0)
        panels[1].plot(middles[filled], levels[lowest], "wo", ms=5, mec="black", ls="")
        panels[0].set(title=title, ylabel=label)
        panels[1].set(title="Median residual")
        sums.append(np.nansum(share[:, filled], axis=0))
        cells += [
            (title, BIN_EDGES_PX[k], levels[i], part, median[i, k])
            for (i, k), part in np.ndenumerate(share)
        ]
    for panel in axes[-1]:
        panel.set_xlabel("Inter-corner distance (px)")
    off = float(np.abs(np.concatenate(sums) - 1).max())
    return Drawing(
        drawn,
        columns(("panel", "distance_from", "level", "share", "median_px"), cells),
        "Left: share of corners for which a setting has the smallest residual, "
        "normalised per bin of inter-corner distance, as in the thesis. Right: "
        "median residual of the same corners at every setting. For the saddle "
        "point method the other parameter has its best value. Dots mark the "
        "smallest median of a bin. (a) Window of the derivative method. "
        "(b) Window and blur of the saddle point method, which the thesis draws "
        "in one volume.",
        check=Check(off < 1e-9, "every slice of the histograms adds up to one"),
    )


def _slices(drawn, panel, levels, values, label, norm=None):
    """Draw one panel: levels over distance bins, with its colour bar."""
    steps = np.diff(levels) / 2
    edges = np.concatenate(
        [[levels[0] - steps[0]], levels[:-1] + steps, [levels[-1] + steps[-1]]]
    )
    mesh = panel.pcolormesh(BIN_EDGES_PX, edges, values, norm=norm, rasterized=True)
    panel.grid(False)
    panel.set_xticks(BIN_EDGES_PX[::2])
    drawn.colorbar(mesh, ax=panel, label=label, pad=0.02)
    return mesh


# The claims of section 3.1.3, from the residuals of every corner.
#
# Bins, halves and the fixed blur of the tests were written into settings.yaml
# (`syn_localisation`) before the first trial.


MAX_GAIN = 0.10
MAX_TIE, WEAK_TIE = 0.2, (0.05, 0.4)


@claim(
    "c3_loc_no_relation",
    needs=("fig_3_5_derivative", "fig_3_5_saddle"),
    evidence="rendered",
)
def judge_no_relation(results):
    """A choice per bin saves less than 10 % for both methods."""
    swept = {name: Swept(results[f"fig_3_5_{name}"]) for name in METHODS}
    gains = {name: gain_of_bins(one) for name, one in swept.items()}
    medians = [gain_of_bins(s, np.median).value for s in swept.values()]
    larger = max(gains.values(), key=lambda gain: gain.value)
    of_mean = "; ".join(
        f"{name} {100 * g.value:.1f} % ({100 * g.low:.1f} to {100 * g.high:.1f})"
        for name, g in gains.items()
    )
    return Reading.of(
        all_of([gain.below(MAX_GAIN) for gain in gains.values()]),
        larger,
        reason=f"share of the mean residual saved: {of_mean}; of the "
        f"median residual: {100 * medians[0]:.1f} and {100 * medians[1]:.1f} %",
    )


def _shares(values, levels):
    return np.mean(values[:, None] == levels, axis=0)


@claim("c3_loc_deriv_small", needs=("fig_3_5_derivative",), evidence="rendered")
def judge_derivative_small(results):
    """Modal best window in the lowest third in at least 80 % of bins."""
    swept = Swept(results["fig_3_5_derivative"])
    small = swept.windows <= swept.lowest_third
    rng = np.random.default_rng(0)
    drawn = np.zeros(RESAMPLES)
    for best in swept.by_bin(swept.best_window):
        counts = rng.multinomial(len(best), _shares(best, swept.windows), RESAMPLES)
        drawn += small[counts.argmax(axis=1)] / len(swept.bins)
    windows = modal_windows(swept)
    share = _estimate(np.mean(windows <= swept.lowest_third), drawn)
    return Reading.of(
        share.above(SHARE_OF_BINS - 1e-9),
        share,
        reason="share of the bins; modal windows, from the nearest "
        f"bin to the farthest, {_listed(windows)} px; the lowest third is "
        f"that of our range, up to {swept.lowest_third:.0f} px",
    )


def _estimate(value, drawn):
    low, high = np.quantile(drawn, [0.025, 0.975])
    return Estimate(float(value), float(low), float(high))


def _listed(values):
    return ", ".join(f"{v:g}" for v in values)


def entropies(swept, rng, draws):
    """Entropy (draws, bins), bits, of best windows at equal counts.

    A histogram of few corners has less entropy than one of many from the same
    distribution. So every bin draws as many corners as the smallest one has.
    """
    groups = swept.by_bin(swept.best_window)
    count = min(len(group) for group in groups)
    out = []
    for group in groups:
        share = rng.multinomial(count, _shares(group, swept.windows), draws) / count
        logs = np.log2(np.where(share > 0, share, 1))
        out.append(-(share * logs).sum(axis=1))
    return np.stack(out, axis=1)


@claim("c3_loc_deriv_dense", needs=("fig_3_5_derivative",), evidence="rendered")
def judge_derivative_dense(results):
    """Entropy in the nearest bin above the median over bins."""
    swept = Swept(results["fig_3_5_derivative"])
    drawn = entropies(swept, np.random.default_rng(0), RESAMPLES)
    excess = drawn[:, 0] - np.median(drawn, axis=1)
    found = _estimate(np.median(excess), excess)
    return Reading.of(
        found.above(0.0),
        found,
        "bit",
        "entropy of the nearest bin less the median over bins, "
        "at equal counts of corners; entropies "
        + ", ".join(f"{h:.2f}" for h in np.median(drawn, axis=0)),
    )


def rank_tie(swept, values):
    """Spearman's correlation of values (M,) with the distance, with its interval.

    Images of one board have the same corners, so corners are drawn again, each
    with all its images, and as many of every size of square as there are.
    """
    from scipy.stats import rankdata

    def correlation(*picked):
        index = [
            images[pick.astype(int)].reshape(*pick.shape[:-1], -1)
            for images, pick in zip(swept.images_of, picked, strict=True)
        ]
        index = np.concatenate(index, axis=-1)
        ranks = (rankdata(x[index], axis=-1) for x in (values, swept.distance))
        a, b = (rank - rank.mean(axis=-1, keepdims=True) for rank in ranks)
        scale = np.sqrt((a**2).sum(axis=-1) * (b**2).sum(axis=-1))
        return (a * b).sum(axis=-1) / scale

    corners = [np.arange(len(images)) for images in swept.images_of]
    return bootstrap(correlation, *corners)


@claim("c3_loc_saddle_win", needs=("fig_3_5_saddle",), evidence="rendered")
def judge_saddle_window(results):
    """|Spearman| < 0.2, and the modal window in the lowest third."""
    swept = Swept(results["fig_3_5_saddle"])
    tie = rank_tie(swept, swept.best_window)
    window = modal(swept.best_window)
    small = HOLDS if window <= swept.lowest_third else FAILS
    return Reading.of(
        all_of([tie.within(-MAX_TIE, MAX_TIE), small]),
        tie,
        reason=f"Spearman; modal window {window:g} px, by bin "
        f"{_listed(modal_windows(swept))} px; the lowest third is that "
        f"of our range, up to {swept.lowest_third:.0f} px",
    )


@claim(
    "c3_loc_saddle_blur",
    needs=("fig_3_5_saddle",),
    evidence="rendered",
    readings=("mid_range_blur",),
)
def judge_saddle_blur(results, options):
    """One blur from inside the range costs at most 15 % in every bin."""
    swept = Swept(results["fig_3_5_saddle"])
    places = swept.mid_range_blurs(options["mid_range_blur"])
    ratios = ratio_of_one_blur(swept, places)
    by_bin = (f"{r.value:.2f} ({r.low:.2f} to {r.high:.2f})" for r in ratios)
    return Reading.of(
        all_of([r.below(np.nextafter(MAX_RATIO, 2)) for r in ratios]),
        max(ratios, key=lambda ratio: ratio.value),
        "1",
        "largest ratio over the bins at one blur of "
        f"{_listed(swept.chosen_blurs(places))} px; by bin {', '.join(by_bin)}",
    )


@claim("c3_loc_saddle_weak", needs=("fig_3_5_saddle",), evidence="rendered")
def judge_saddle_weak(results):
    """0.05 < |Spearman(best blur, distance)| < 0.4."""
    swept = Swept(results["fig_3_5_saddle"])
    tie = rank_tie(swept, swept.best_blur)
    size = tie if tie.value >= 0 else Estimate(-tie.value, -tie.high, -tie.low)
    reason = "Spearman of the best blur with the distance"
    return Reading.of(size.within(*WEAK_TIE), tie, reason=reason)
