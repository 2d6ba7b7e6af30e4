"""The claims of section 3.1.3, from the residuals of every corner.

Bins, halves and the fixed blur of the tests were written into settings.yaml
(`syn_localisation`) before the first trial.
"""

import numpy as np

from chapters.ch03_planar_grids.s1_3_localisation.results import (
    MAX_RATIO,
    SHARE_OF_BINS,
    Swept,
    gain_of_bins,
    modal,
    modal_windows,
    ratio_of_one_blur,
)
from repro.judge.statistics import FAILS, HOLDS, RESAMPLES, Estimate, all_of, bootstrap
from repro.run.experiment import claim
from repro.run.outcomes import Reading

MAX_GAIN = 0.10
MAX_TIE, WEAK_TIE = 0.2, (0.05, 0.4)


@claim(
    "c3_loc_no_relation",
    needs=("fig_3_5_derivative", "fig_3_5_saddle"),
    evidence="rendered",
)
def judge_no_relation(results):
    """A choice per bin saves less than 10 % for both methods."""
    swept = {
        name: Swept(results[f"fig_3_5_{name}"]) for name in ("derivative", "saddle")
    }
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
