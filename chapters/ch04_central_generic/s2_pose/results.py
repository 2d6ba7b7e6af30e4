"""Errors, ratios and counts of section 4.2, and the numbers of the text."""

from functools import partial
from itertools import product

import numpy as np

from chapters.ch04_central_generic.s2_pose.trials.estimators import STANDARD
from chapters.ch04_central_generic.s2_pose.trials.kodak import ADDED_OUTLIERS
from chapters.ch04_central_generic.s2_pose.trials.simulated import DRAWS, RAYS
from chapters.shared.bench_noise import BENCH, OPTIONS
from repro.judge.statistics import median_ratio
from repro.page.reader import value
from repro.run.readings import Case

# Bounds of the claims about Table 4.1.
MIN_RANSAC_GAIN, MIN_ORDER_RATIO, MAX_STANDARD_RATIO = 1.5, 1.0, 2.0
PRIMARY = {"domain": "px", "rays": RAYS[0], "unit": "length"}
MEASURES = ("rotation_deg", "translation_percent")
TABLE_MEASURES = ("rotation_deg", "translation_mm")
IN_WORDS = {
    "rotation_deg": "rotation",
    "translation_percent": "translation",
    "translation_mm": "translation",
}
QUOTED_NOISE_PX = 0.5
ANY_TRIPLES = "any three points"  # of `APART`


def trials_of(result, estimator, measure, noise, **condition):
    """Return errors (n,) of an estimator at one noise level, nan where it failed."""
    condition = PRIMARY | condition
    return result.column(f"{estimator}.{measure}", noise=noise, **condition)


def table_trials(result, estimator, measure, outliers=ADDED_OUTLIERS, noise=BENCH):
    """Return errors (n,) of the scenes or runs of Table 4.1, nan where it failed."""
    return result.select().column(f"errors.{noise}.{outliers}.{estimator}.{measure}")


class Scenes(Case):
    """Redrawn scenes of Table 4.1 in one interpretation, at one noise level."""

    def __init__(self, results, options=None, noise=BENCH):
        super().__init__(
            {"decoding_noise": OPTIONS, "standard_pose": STANDARD}, options
        )
        self.result, self.noise = results["table_4_1_redrawn"], noise

    def ratio(self, over, under, measure):
        """Return the ratio of median errors of two estimators, Estimate."""
        errors = [
            table_trials(self.result, name, measure, noise=self.noise)
            for name in (over, under)
        ]
        return median_ratio(*errors, paired=True)


def gains_of_ransac(scenes):
    """Return {measure: CGSP without over with RANSAC}, Estimates."""
    return {m: scenes.ratio("cgsp", "cgsp_ransac", m) for m in TABLE_MEASURES}


def ratios_of_neighbours(scenes):
    """Return {(measure, step): worse estimator over better}, Estimates."""
    standard = scenes["standard_pose"]
    steps = {
        "standard over CGSP + RANSAC": (standard, "cgsp_ransac"),
        "CGSP over standard": ("cgsp", standard),
    }
    return {
        (measure, step): scenes.ratio(*steps[step], measure)
        for measure, step in product(TABLE_MEASURES, steps)
    }


def standard_over_cgsp(scenes):
    """Return {translation: standard over CGSP, both with RANSAC}, an Estimate."""
    measure = "translation_mm"
    return {measure: scenes.ratio(scenes["standard_pose"], "cgsp_ransac", measure)}


def without_solution(result, kind):
    """Return (triples without a pose, all triples) of one kind."""
    lost = result.column(f"{kind}.without")
    return int(lost.sum()), DRAWS * len(lost)


def finite_of_four(result, plane):
    """Return (samples of four points with a finite pose, all samples)."""
    finite = result.column(f"finite.{plane}")
    return int(finite.sum()), DRAWS * len(finite)


def name_values(open_results):
    """Name the numbers that the text quotes: medians over trials."""
    rotations = partial(
        trials_of,
        open_results("fig_4_4_noise"),
        measure="rotation_deg",
        noise=QUOTED_NOISE_PX,
    )
    for name in ("three_points", "cgsp_ransac", "angular"):
        value(f"{name}_deg", np.median(rotations(name)))
    refining = median_ratio(rotations("three_points"), rotations("standard"))
    value("refining", refining.value)
    counts = open_results("exp_c4_3pt_no_solution")
    value("lost_any", 100 * np.divide(*without_solution(counts, ANY_TRIPLES)))
