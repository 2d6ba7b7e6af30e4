"""Estimates for the figure and the prose of section 4.1.3."""

import numpy as np

from chapters.ch04_central_generic.s1_3_rays.trials import FACTORS, POSED
from repro.judge.statistics import median_interval, median_ratio
from repro.page.reader import value
from repro.page.wording import rounded

VARIANCE, ALONE = "variance", "linear grids alone"


def ray_error(result, weights, domain, posed):
    """Estimate of the median error of the rays (mm) with some weights."""
    return median_interval(result.column(f"ray_mm.{posed}.{weights}", domain=domain))


def best_factor(result, domain, posed):
    """The factor of FACTORS with the least median error."""
    found = [
        ray_error(result, f"{factor:g}", domain, posed).value for factor in FACTORS
    ]
    return FACTORS[int(np.argmin(found))]


def worse_by(result, weights, other, posed):
    """Median error with some weights over that with others, in words.

    The trials are the same ones, with noise in the image.
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
        "few.one": worse_by(result, "1", f"{best['few']:g}", few),
        "many.gain": worse_by(result, f"{best['many']:g}", VARIANCE, many),
        **{
            f"many.{weights}": ray_error(result, weights, "px", many).value
            for weights in (VARIANCE, ALONE)
        },
    }
    for name, number in found.items():
        value(name, number)
