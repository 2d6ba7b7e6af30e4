"""What the figures, tables, claims and prose of section 4.1.4 read."""

import numpy as np

from repro.judge.statistics import median_interval, with_worst
from repro.page.reader import value

NAMES = {
    "linear": "CGSP's linear stage",
    "fixed_centre": "scheme 1: rays and poses",
    "relaxed": "scheme 2: poses alone, rays follow",
    "line_fitting": "scheme 3: line fitting",
    "ray_point": "scheme 1, centre set free",
    "consistent": "consistent adjustment",
}
ONE_PLACE = 0.01  # of the starts' spread: ends as close as this are one
# Curves of the figure of consistency, by the noise (px) of its two panels.
CURVES = {
    0.5: ("linear", "line_fitting", "ray_point", "consistent"),
    2.0: ("linear", "ray_point", "consistent"),
}


def counts_of(result, noise):
    """Numbers of rays that were run at a noise, rising."""
    return sorted(result.levels("rays", noise=noise))


def centre_medians(result, method, noise):
    """Numbers of rays, and Estimates of the median centre error for each."""
    found, rays = [], []
    for count in counts_of(result, noise):
        trials = result.column(f"{method}.centre_mm", noise=noise, rays=count)
        if not np.isnan(trials).all():
            rays.append(count)
            found.append(median_interval(trials))
    return rays, found


def fall(result, method, noise):
    """Median error with most rays over that with fewest."""
    _, found = centre_medians(result, method, noise)
    return found[-1].value / found[0].value


def refusals(result, **condition):
    """Trials that the linear stage refused, under what ``condition`` says."""
    return sum(text is not None for text in result.select(**condition).texts("refused"))


def mean_interval(trials):
    """Mean of trials (n,), and its 95 % interval of two standard errors.

    Refused trials have no value and are left out.
    """
    trials = np.asarray(trials, float)
    trials = trials[~np.isnan(trials)]
    middle = float(trials.mean())
    reach = 1.96 * float(trials.std(ddof=1)) / np.sqrt(len(trials))
    return middle, middle - reach, middle + reach


def name_values(open_results):
    """Name the numbers that the prose quotes."""
    sweep, schemes, targets, starts = map(
        open_results,
        (
            "ext_consistency_sweep",
            "ext_schemes_trials",
            "ext_adjustment_targets_trials",
            "exp_c4_centre_ba_unstable",
        ),
    )
    for method in CURVES[2.0]:
        for noise in CURVES:
            value(f"fall.{noise}.{method}", fall(sweep, method, noise))
    few, *_, many = counts_of(sweep, 0.5)
    value("fall.expected", float(np.sqrt(few / many)))
    value("rays.few", few)
    value("rays.many", many)
    for method in NAMES:
        for name in ("centre_mm", "ray_mm", "own_ray_mm", "rounds"):
            found = schemes.column(f"{method}.{name}")
            value(f"{method}.{name}", float(np.median(with_worst(found))))
    for case in ("three grids", "ten grids"):
        for name in ("linear_mm", "consistent_mm"):
            found = targets.column(name, case=case)
            value(f"{case}.{name}", float(np.median(with_worst(found))))
    for name in ("nees", "passes"):
        found = targets.column(name, case="three grids")
        value(name, mean_interval(found)[0])
    value("refused", refusals(sweep, noise=2.0))
    value("refused.of", sweep.trials_per_condition * len(counts_of(sweep, 2.0)))
    for scheme in ("line_fitting", "ray_point", "consistent"):
        for name in ("spread_over_starts", "spread_over_draws", "above_best"):
            found = starts.column(f"{scheme}.{name}")
            value(f"starts.{scheme}.{name}", float(np.median(found)))
    rest = starts.column("line_fitting.at_rest")
    spread = starts.column("line_fitting.spread_over_starts")
    value("scenes", starts.trials_per_condition)
    value("scenes.one_place", int(np.sum((rest == 1) & (spread < ONE_PLACE))))
    value("scenes.no_rest", int(np.sum(rest < 1)))
