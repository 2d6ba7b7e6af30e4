"""Numbers of section 2.5.1 for its prose and its claims."""

import numpy as np

from chapters.shared.methods import METHODS
from repro.judge.statistics import with_worst
from repro.page.reader import value

PRIMARY = {"domain": "px", "extent": "unbounded"}
MEAN = "fresh.corrected.mean_px"


def trials_of(result, method, value, **condition):
    """Return the trials (n,) of one value of a method, failed ones as the worst.

    ``condition`` replaces parts of the primary interpretation. Exact rays have
    fresh noise only; ``over_exact`` is the mean residual on fresh noise as a
    multiple of theirs.
    """
    condition = PRIMARY | condition
    exact = 1.0
    if value == "over_exact":
        value, exact = MEAN, trials_of(result, "exact", MEAN, **condition)
    if method.endswith("exact"):
        value = value.removeprefix("fresh.")
    trials = result.column(f"{method}.{value}", **condition) / exact
    return with_worst(trials, np.nanmax(trials))


def median_of(result, method, value, **condition):
    """Return the median over the trials that `trials_of` returns."""
    return float(np.median(trials_of(result, method, value, **condition)))


def rank_trend(x, medians):
    """Return the rank correlation of medians (n,) with a sweep (n,) without ties."""
    return float(np.corrcoef(np.arange(len(x)), np.argsort(np.argsort(medians)))[0, 1])


def spread_over_sweep(x, medians):
    """Return the largest over the smallest of the medians (n,) of a sweep (n,)."""
    return float(medians.max() / medians.min())


def is_better(fov, method, of, **condition):
    """Return whether a method's median of a value is below the parametric one's."""
    own, other = (median_of(fov, m, of, **condition) for m in (method, "parametric"))
    return own < other


def crossing(fov, method):
    """Return the levels (deg) between which a method becomes the better one.

    In the primary interpretation; the last crossing, where there are several.
    """
    levels = sorted(fov.levels("fov_deg"))
    behind = [at for at in levels if not is_better(fov, method, MEAN, fov_deg=at)]
    after = levels.index(behind[-1]) + 1 if behind else 0
    return levels[max(after - 1, 0)], levels[min(after, len(levels) - 1)]


def name_values(open_results):
    """Name the numbers of the prose, in the primary interpretation."""
    fov = open_results("fig_2_3_fov")
    _, *generic = METHODS
    below, above = crossing(fov, generic[0])
    found = {
        "crossing.below": below,
        "crossing.above": above,
        **{
            f"{generic[0]}.over.{at}": median_of(
                fov, generic[0], "over_exact", fov_deg=at
            )
            for at in (120, 150)
        },
        **{
            f"{method}.ray_deg.90": median_of(fov, method, "ray_deg", fov_deg=90)
            for method in generic
        },
    }
    for name, number in found.items():
        value(name, number)
