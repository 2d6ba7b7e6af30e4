"""The readings of section 2.5.2: what its text leaves open, combined.

Each option of `corner_noise` and `interpolation` but the first is an experiment of its
own. So these two stand with the first options of the questions in NOT_CROSSED.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from chapters.shared.synthetic_readings import METHOD, SCALE, readings_of
from chapters.shared.zoom_rigs import FACADE_ZOOM, ZOOMS
from repro.judge.statistics import wins

QUESTIONS = {
    "standard_method": ("as printed", "well conditioned"),
    "residual_image": ("calibration images", "held-out images"),
    "residual_scale": ("corrected view", "source image"),
    "residual_statistic": ("RMS", "mean"),
    "step_frame": ("grid", "camera"),
    "corner_noise": ("none", "0.06 px", "0.45 px"),
    "interpolation": ("homographic", "smooth"),
}
LABORATORY = ("corner_noise", "interpolation")
NOT_CROSSED = {
    question: {"standard_method", "noise", "scoring", "extent", *LABORATORY}
    - {question}
    for question in LABORATORY
}
NOISE_PX = {"none": 0.0, "0.06 px": 0.06, "0.45 px": 0.45}
OF_SEEDS = ("table_2_2_redrawn", "table_2_2_readings", "fig_2_7_smooth")
REDRAWN, READ, PAIRED = OF_SEEDS
OTHERS = (("none", "smooth"), ("0.06 px", "homographic"), ("0.45 px", "homographic"))


def condition_of(zoom, corner_noise, interpolation):
    """A condition of READ or PAIRED."""
    taken = zip(LABORATORY, (corner_noise, interpolation), strict=True)
    return {"zoom": zoom} | dict(taken)


# What c2_periphery hangs on; a comparison seed by seed needs more of them.
IN_PAIRS = [condition_of(FACADE_ZOOM, "none", "smooth")]
READINGS = [
    condition
    for zoom in ZOOMS
    for other in OTHERS
    if (condition := condition_of(zoom, *other)) not in IN_PAIRS
]
IMAGES = {"calibration images": "calibration", "held-out images": "held_out"}
STATISTIC = {"RMS": "rms_px", "mean": "mean_px"}


class ZoomCase:
    """Seeds of one reading; methods are `parametric` and `generic`.

    results: experiment -> Result, of those in OF_SEEDS that the options ask for.
    """

    def __init__(self, results, options=None):
        self.results = results
        self.options = options or {}

    def option(self, question):
        """The option taken: the first one of a question not asked."""
        return self.options.get(question, QUESTIONS[question][0])

    def method(self, name):
        """The trial's name of a method."""
        if name == "parametric":
            return name
        return METHOD[self.option("standard_method")]

    @property
    def scale(self):
        """The trial's name of the scale."""
        return SCALE[self.option("residual_scale")]

    @property
    def images(self):
        """The trial's name of the pictures that are scored."""
        return IMAGES[self.option("residual_image")]

    def column(self, place, zoom):
        """Values (seeds,) by their full name, NaN where there is none."""
        other = tuple(self.option(question) for question in LABORATORY)
        if other not in OTHERS:
            return self.results[REDRAWN].column(place, zoom=zoom)
        condition = condition_of(zoom, *other)
        made = self.results[PAIRED if condition in IN_PAIRS else READ]
        return made.column(place, **condition)

    def residual(self, name, zoom, statistic=None):
        """Residual (px) of every seed, NaN where the method failed."""
        statistic = statistic or STATISTIC[self.option("residual_statistic")]
        place = f"{self.method(name)}.{self.images}.{self.scale}"
        return self.column(f"{place}.{statistic}", zoom)

    def residuals(self, name):
        """Residuals of the seeds at the three zoom settings."""
        return [self.residual(name, zoom) for zoom in ZOOMS]

    def of(self, name, quantity, zoom):
        """Any other value of a method."""
        return self.column(f"{self.method(name)}.{quantity}", zoom)


def combinations(questions):
    """Options by question: all combinations but those of NOT_CROSSED.

    questions: question -> options, the primary one first.
    """
    for options in product(*questions.values()):
        taken = dict(zip(questions, options, strict=True))
        away = {q for q in taken if taken[q] != questions[q][0]}
        if not any(NOT_CROSSED.get(q, set()) & away for q in away):
            yield taken


def judged(results, questions, judge):
    """Readings of a claim about the three sets."""
    asked = {question: QUESTIONS[question] for question in questions}
    cases = (ZoomCase(results, taken) for taken in combinations(asked))
    return readings_of(cases, judge)


def generic_wins(generic, parametric, quantity):
    """What a judge says of wins(generic < parametric), paired by seed.

    generic, parametric: (seeds,), NaN where the method gave nothing, which
    counts as the worst.
    """
    won = wins([(generic, parametric)])[0]
    failed = [int(np.isnan(t).sum()) for t in (parametric, generic)]
    return (
        won.decision,
        won.ratio.value,
        (won.ratio.low, won.ratio.high),
        f"parametric over generic {quantity}; Wilcoxon p {won.p:.1g}; of "
        f"{len(generic)} seeds {failed[0]} failed with the parametric method "
        f"and {failed[1]} with the generic one",
    )
