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
    few, *_, many = counts_of(sweep, 0.5)
    rest = starts.column("line_fitting.at_rest")
    spread = starts.column("line_fitting.spread_over_starts")
    medians = {
        **{
            f"{method}.{name}": schemes.column(f"{method}.{name}")
            for method in NAMES
            for name in ("centre_mm", "ray_mm", "own_ray_mm", "rounds")
        },
        **{
            f"starts.{scheme}.{name}": starts.column(f"{scheme}.{name}")
            for scheme in ("line_fitting", "ray_point", "consistent")
            for name in ("spread_over_starts", "spread_over_draws", "above_best")
        },
    }
    found = {
        **{
            f"fall.{noise}.{method}": fall(sweep, method, noise)
            for method in CURVES[2.0]
            for noise in CURVES
        },
        "fall.expected": np.sqrt(few / many),
        "rays.few": few,
        "rays.many": many,
        **{name: np.median(with_worst(trials)) for name, trials in medians.items()},
        **{
            name: mean_interval(targets.column(name, case="three grids"))[0]
            for name in ("nees", "passes")
        },
        "refused": refusals(sweep, noise=2.0),
        "refused.of": sweep.trials_per_condition * len(counts_of(sweep, 2.0)),
        **{
            f"{case}.{name}{end}": bound
            for case in ("three grids", "ten grids")
            for name in ("linear_mm", "consistent_mm")
            for end, bound in zip(
                ("", ".low", ".high"),
                median_interval(targets.column(name, case=case))[:3],
                strict=True,
            )
        },
        "scenes": starts.trials_per_condition,
        "scenes.one_place": np.sum((rest == 1) & (spread < ONE_PLACE)),
        "scenes.no_rest": np.sum(rest < 1),
    }
    for name, number in found.items():
        value(name, number)
