"""Names of the steps, and the numbers that the page quotes."""

from itertools import pairwise

from chapters.ch04_central_generic.ext_what_cgsp_buys.trials import (
    GRIDS,
    OUTLIERS,
    STEPS,
)
from chapters.shared.methods import LINEAR_NAMES
from repro.judge.statistics import median_interval, median_ratio, with_worst
from repro.page.reader import value
from repro.page.wording import rounded

NAMES = LINEAR_NAMES | {
    "normalised": "normalised coordinates",
    "one_scale": "one scale by least squares",
    "well_conditioned": "no vanishing divisors",
    "cgsp_weighted": "CGSP, weighted",
    "consistent": "CGSP, adjusted with the centre",
    "cgsp_robust": "CGSP with RANSAC",
    "well_conditioned_robust": "standard on the same inliers",
}


def centre(result, method, **condition):
    """Median error (mm) of the centre, an Estimate; failures as the worst."""
    return median_interval(
        with_worst(result.column(f"{method}.centre_mm", **condition))
    )


def failed(result, method, **condition):
    """Trials of a condition in which a method gave nothing."""
    texts = result.texts(f"{method}.failed", **condition)
    return sum(text is not None for text in texts)


def gain(result, one, other):
    """Ratio of the median errors of two methods in the same trials, an Estimate."""
    errors = (result.column(f"{method}.centre_mm") for method in (one, other))
    return median_ratio(*errors, paired=True)


def in_words(ratio):
    """An Estimate with its interval, for a sentence."""
    return rounded(ratio.value, (ratio.low, ratio.high))


def name_values(open_results):
    """Name the numbers of the prose."""
    steps = open_results("ext_cgsp_steps")
    grids = open_results("ext_cgsp_grids")
    outliers = open_results("ext_cgsp_outliers")
    found = {
        **{f"gain.{b}": in_words(gain(steps, a, b)) for a, b in pairwise(STEPS)},
        **{
            f"grids.{method}.{count}": centre(grids, method, grids=count).value
            for method in ("cgsp", "consistent")
            for count in (GRIDS[0], GRIDS[-1])
        },
        **{
            f"outliers.{method}": centre(outliers, method, outliers=OUTLIERS[-1]).value
            for method in ("cgsp_robust", "well_conditioned_robust")
        },
    }
    for name, number in found.items():
        value(name, number)
