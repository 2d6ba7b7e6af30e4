"""Which trials Fig. 4.2 and its claims read, and the numbers that the page quotes."""

from __future__ import annotations

from itertools import product
from typing import NamedTuple

import numpy as np

from chapters.ch04_central_generic.s1_5_simulated.trials import LEVELS
from repro.judge.statistics import median_interval, with_worst
from repro.page.reader import value

NAMES = {
    "as_printed": "standard, as printed",
    "well_conditioned": "standard, well conditioned",
    "cgsp": "CGSP",
}
STAGES = {
    "linear": "",
    "ba": " + adjustment",
    "ba_true_centre": " + adjustment about the true centre",
    "consistent": " + adjustment of the centre too",
}
# What was run: the last stage follows CGSP only.
RUNS = [
    (method, stage)
    for method, stage in product(NAMES, STAGES)
    if stage != "consistent" or method == "cgsp"
]
# Questions of the ledger -> what their options name in a result.
NOISE = {"px": "px", "mm": "mm"}
STANDARD = {"as printed": "as_printed", "well conditioned": "well_conditioned"}
TRANSLATION = {"difference of lengths": "length_mm", "length of the difference": "mm"}
RAY_POINT = {"true points": "ray_mm", "noisy points": "own_ray_mm"}
QUESTIONS = {
    "noise": tuple(NOISE),
    "standard_method": tuple(STANDARD),
    "translation_error": tuple(TRANSLATION),
    "ray_point": tuple(RAY_POINT),
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
# What the prose quotes: method, stage, quantity.
QUOTED = (
    "cgsp.linear.centre",
    "well_conditioned.linear.centre",
    "as_printed.linear.centre",
    "as_printed.linear.t3",
    "as_printed.ba.t3",
    "as_printed.linear.ray",
    "as_printed.ba.ray",
    "as_printed.linear.own_ray_mm",
    "as_printed.ba.own_ray_mm",
    "as_printed.ba.point_mm",
    "as_printed.ba_true_centre.point_mm",
)


class NoiseCase(NamedTuple):
    """One reading of 4.1.5: an option for every question that is asked."""

    options: dict

    def standard(self):
        """The linear stage that stands for the standard method."""
        return STANDARD[self.options.get("standard_method", "as printed")]

    def name(self, quantity):
        """The column of a quantity of Fig. 4.2."""
        translation = self.options.get("translation_error")
        ray = self.options.get("ray_point", "true points")
        return {
            "centre": "centre_mm",
            "r2": "r2_deg",
            "r3": "r3_deg",
            "ray": RAY_POINT[ray],
        }.get(
            quantity,
            f"{quantity}_{TRANSLATION[translation or 'difference of lengths']}",
        )

    def trials(self, result, method, stage, quantity, noise):
        """Trials (n,) of a quantity; a failed one counts as the worst."""
        if method == "standard":
            method = self.standard()
        name = self.name(quantity) if quantity in WORDS else quantity
        return with_worst(
            result.column(
                f"{method}.{stage}.{name}",
                domain=self.options.get("noise", "px"),
                noise=noise,
            )
        )


def cases(*questions):
    """A case for every combination of options of the questions."""
    return [
        NoiseCase(dict(zip(questions, chosen, strict=True)))
        for chosen in product(*(QUESTIONS[q] for q in questions))
    ]


PRIMARY = NoiseCase({question: options[0] for question, options in QUESTIONS.items()})


def medians(result, case, method, stage, quantity):
    """Estimates of the median along the levels of noise, [Estimate, ...]."""
    return [
        median_interval(case.trials(result, method, stage, quantity, level))
        for level in LEVELS
    ]


def failures(result, method):
    """Trials in which a method gave nothing, and all trials."""
    texts = [
        text
        for condition in result.conditions
        for text in result.texts(f"{method}.failed", **condition)
    ]
    return sum(text is not None for text in texts), len(texts)


def name_values(open_results):
    """Name the numbers of the prose, in the primary reading at 0.5 px."""
    result = open_results("fig_4_2_redrawn")
    for name in QUOTED:
        found = PRIMARY.trials(result, *name.split("."), 0.5)
        value(name, float(np.median(found)))
    for method in ("as_printed", "cgsp"):
        centre = PRIMARY.trials(result, method, "linear", "centre", 0.5)
        off = np.abs(centre - np.median(centre))
        value(f"{method}.spread", float(np.median(off)))
    failed, total = failures(result, "as_printed")
    value("as_printed.failed", failed)
    value("total", total)
