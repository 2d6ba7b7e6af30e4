"""Estimates for the figure and the prose of section 4.1.3."""

import numpy as np

from chapters.ch04_central_generic.s1_3_rays.trials import FACTORS, POSED
from repro.judge.statistics import median_interval, median_ratio
from repro.page.reader import value
from repro.page.wording import rounded

VARIANCE, ALONE = "variance", "linear grids alone"


def ray_error(result, weights, domain, posed):
    """Return the median error of the rays (mm) with some weights, an Estimate."""
    return median_interval(result.column(f"ray_mm.{posed}.{weights}", domain=domain))


def best_factor(result, domain, posed):
    """Return the factor of FACTORS with the smallest median error."""
    found = [
        ray_error(result, f"{factor:g}", domain, posed).value for factor in FACTORS
    ]
    return FACTORS[int(np.argmin(found))]


def error_ratio(result, weights, other, posed):
    """Return the ratio of the median errors with two weights, as text.

    Both come from the same trials, with image noise.
    """
    errors = (
        result.column(f"ray_mm.{posed}.{name}", domain="px")
        for name in (weights, other)
    )
    ratio = median_ratio(*errors, paired=True)
    return rounded(ratio.value, (ratio.low, ratio.high))


def name_values(open_results):
    """Name the numbers that the prose quotes."""
    result = open_results("ext_ray_weights_trials")
    few, many = POSED[0], POSED[-1]
    best = {
        "few": best_factor(result, "px", few),
        "many": best_factor(result, "px", many),
    }
    found = {
        **{f"factor.{name}": factor for name, factor in best.items()},
        "few.one": error_ratio(result, "1", f"{best['few']:g}", few),
        "many.gain": error_ratio(result, f"{best['many']:g}", VARIANCE, many),
        **{
            f"many.{weights}": ray_error(result, weights, "px", many).value
            for weights in (VARIANCE, ALONE)
        },
    }
    for name, number in found.items():
        value(name, number)
