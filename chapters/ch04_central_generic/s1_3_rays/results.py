"""What the figure, the table, the claim and the prose of section 4.1.3 read."""

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
    ends = {"few": POSED[0], "many": POSED[-1]}
    best = {name: best_factor(result, "px", n) for name, n in ends.items()}
    found = {
        **{f"posed.{name}": posed for name, posed in ends.items()},
        **{f"factor.{name}": best[name] for name in ends},
        **{
            f"{name}.gain": worse_by(result, f"{best[name]:g}", VARIANCE, n)
            for name, n in ends.items()
        },
        "few.one": worse_by(result, "1", f"{best['few']:g}", ends["few"]),
        "few.two": worse_by(result, "2", f"{best['few']:g}", ends["few"]),
        **{
            f"{name}.{weights}": ray_error(result, weights, "px", posed).value
            for name, posed in ends.items()
            for weights in ("1", "4", VARIANCE, ALONE)
        },
    }
    for name, number in found.items():
        value(name, number)
