"""Trials behind Fig. 4.2 and its claims, and the numbers that the page quotes."""

from itertools import pairwise, product

import numpy as np

from chapters.ch04_central_generic.s1_5_simulated.trials import LEVELS, STEPS
from chapters.shared.methods import LINEAR_NAMES, STANDARD_METHODS
from repro.judge.statistics import median_interval, median_ratio, with_worst
from repro.page.reader import value
from repro.page.wording import rounded
from repro.run.readings import Case

STAGES = {
    "linear": "",
    "ba": " + adjustment",
    "ba_true_centre": " + adjustment about the true centre",
    "consistent": " + adjustment of the centre too",
}
# Methods and stages; the last stage follows CGSP only.
RUNS = [
    (method, stage)
    for method, stage in product(LINEAR_NAMES, STAGES)
    if stage != "consistent" or method == "cgsp"
]
STEP_NAMES = LINEAR_NAMES | {
    "normalised": "normalised coordinates",
    "one_scale": "one scale by least squares",
    "well_conditioned": "no vanishing divisors",
    "cgsp_weighted": "CGSP, weighted",
    "consistent": "CGSP, adjusted with the centre",
}
READINGS = {
    "noise": {"px": "px", "mm": "mm"},
    "standard_method": STANDARD_METHODS,
    "translation_error": {
        "difference of lengths": "length_mm",
        "length of the difference": "mm",
    },
    "ray_point": {"true points": "ray_mm", "noisy points": "own_ray_mm"},
    "statistic_of_trials": {"median": "median", "mean": "mean"},
}
QUANTITIES = ("centre", "t2", "t3", "r2", "r3", "ray")
WORDS = {
    "centre": "centre",
    "t2": "translation of grid 2",
    "t3": "translation of grid 3",
    "r2": "rotation of grid 2",
    "r3": "rotation of grid 3",
    "ray": "ray to point",
}


class NoiseCase(Case):
    """One interpretation of 4.1.5; options that are not given are the primary ones."""

    def __init__(self, options=None):
        super().__init__(READINGS, options)

    def name(self, quantity):
        """Return the column of a quantity of Fig. 4.2, or the name itself."""
        return {
            "centre": "centre_mm",
            "t2": f"t2_{self['translation_error']}",
            "t3": f"t3_{self['translation_error']}",
            "r2": "r2_deg",
            "r3": "r3_deg",
            "ray": self["ray_point"],
        }.get(quantity, quantity)

    def trials(self, result, method, stage, quantity, noise):
        """Return the trials (n,) of a quantity; a failed one counts as the worst."""
        if method == "standard":
            method = self["standard_method"]
        name = f"{method}.{stage}.{self.name(quantity)}"
        return with_worst(result.column(name, domain=self["noise"], noise=noise))


PRIMARY = NoiseCase()


def medians(result, case, method, stage, quantity):
    """Return the medians at the noise levels, [Estimate, ...]."""
    return [
        median_interval(case.trials(result, method, stage, quantity, level))
        for level in LEVELS
    ]


def failures(result, method):
    """Return the numbers of failed trials of a method and of all trials."""
    texts = result.select().texts(f"{method}.failed")
    return sum(text is not None for text in texts), len(texts)


def centre_after(result, step):
    """Return the median centre error (mm) after a step, an Estimate.

    Failures count as the worst.
    """
    return median_interval(with_worst(result.column(f"{step}.centre_mm")))


def gain(result, one, other):
    """Return the ratio of the median errors of two steps, an Estimate."""
    errors = (result.column(f"{step}.centre_mm") for step in (one, other))
    return median_ratio(*errors, paired=True)


def in_words(ratio):
    """Return an Estimate with its interval as text."""
    return rounded(ratio.value, (ratio.low, ratio.high))


def name_values(open_results):
    """Name the numbers of the prose, in the primary interpretation at 0.5 px."""
    result, steps = map(open_results, ("fig_4_2_redrawn", "ext_cgsp_steps"))
    for method in ("as_printed", "cgsp"):
        trials = PRIMARY.trials(result, method, "linear", "centre", 0.5)
        value(f"{method}.linear.centre", np.median(trials))
    for before, after in pairwise(STEPS):
        if after in ("one_scale", "cgsp"):
            value(f"gain.{after}", in_words(gain(steps, before, after)))
    for quantity in ("t3", "ray"):
        value(f"adjusted.{quantity}", change_by_adjustment(result, quantity))


def change_by_adjustment(result, quantity):
    """Return the ratio of the median errors after and before adjustment, as text."""
    after, before = (
        PRIMARY.trials(result, "as_printed", stage, quantity, 0.5)
        for stage in ("ba", "linear")
    )
    return in_words(median_ratio(after, before, paired=True))
