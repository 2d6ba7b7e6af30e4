"""The readings of section 2.5.2: what its text leaves open, combined."""

from __future__ import annotations

from itertools import product

import numpy as np

from chapters.shared.synthetic_readings import (
    METHOD,
    SCALE,
    readings_of,
)
from chapters.shared.zoom_rigs import ZOOMS
from repro.judge.statistics import wins

QUESTIONS = {
    "standard_method": ("as printed", "well conditioned"),
    "residual_image": ("calibration images", "held-out images"),
    "residual_scale": ("corrected view", "source image"),
    "residual_statistic": ("RMS", "mean"),
    "step_frame": ("grid", "camera"),
}
IMAGES = {
    "calibration images": "calibration",
    "held-out images": "held_out",
}
STATISTIC = {"RMS": "rms_px", "mean": "mean_px"}


class ZoomCase:
    """Seeds of one reading; methods are `parametric` and `generic`."""

    def __init__(self, result, options=None):
        self.result = result
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

    def residual(self, name, zoom, statistic=None):
        """Residual (px) of every seed, NaN where the method failed."""
        statistic = (
            statistic or STATISTIC[self.option("residual_statistic")]
        )
        place = f"{self.method(name)}.{self.images}.{self.scale}"
        return self.result.column(f"{place}.{statistic}", zoom=zoom)

    def residuals(self, name):
        """Residuals of the seeds at the three zoom settings."""
        return [self.residual(name, zoom) for zoom in ZOOMS]

    def of(self, name, quantity, zoom):
        """Any other value of a method."""
        return self.result.column(
            f"{self.method(name)}.{quantity}", zoom=zoom
        )


def judged(result, questions, judge):
    """Readings of a claim about the three sets."""
    options = product(*(QUESTIONS[q] for q in questions))
    cases = (
        ZoomCase(result, dict(zip(questions, taken, strict=True)))
        for taken in options
    )
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
