"""Motions of section 4.3.2 by method and detector, and the numbers of the text."""

import numpy as np

from chapters.ch04_central_generic.s3_4_motion.trials.calibrations import METHODS
from chapters.ch04_central_generic.s3_4_motion.trials.corners import DETECTORS
from chapters.ch04_central_generic.s3_4_motion.trials.stage import STEPS
from chapters.shared.bench_noise import BENCH, OPTIONS
from chapters.shared.methods import LINEAR_NAMES
from repro.judge.statistics import wins, with_worst
from repro.page.reader import value
from repro.run.readings import Case

# Methods of the trials -> words.
NAMES = dict(zip(METHODS, LINEAR_NAMES.values(), strict=True))
MEASURES = {"translation": "deviation_mm", "rotation": "off_deg"}
MIN_GAIN = 1.05  # of the medians, required by the rule for wins
SCALE = 4  # of the deviations in the drawing
QUOTED_DETECTOR = "CELECT"


READINGS = {
    "decoding_noise": OPTIONS,
    "standard_method": {name: name for name in METHODS[:2]},
    "motion_corners": {name: name for name in DETECTORS},
}


def trials_of(result, motion, measure, method, detector, noise=BENCH):
    """Return one measure of one method, (trials,), nan where it failed."""
    return result.select().column(f"{noise}.{motion}.{detector}.{method}.{measure}")


def ahead_at(result, options, motion, noise):
    """Return wins(CGSP < standard) in one motion's measure, a `Comparison`."""
    case = Case(READINGS, options)
    ours, theirs = (
        trials_of(
            result, motion, MEASURES[motion], method, case["motion_corners"], noise
        )
        for method in ("CGSP", case["standard_method"])
    )
    return wins([(ours, theirs)])[0]


def name_values(open_results):
    """Name the numbers that the text quotes: medians over the redrawn runs."""
    runs = open_results("fig_4_10_seeds")

    def median(motion, method, noise=BENCH):
        trials = trials_of(
            runs, motion, MEASURES[motion], method, QUOTED_DETECTOR, noise
        )
        return np.median(with_worst(trials))

    for method, short in (("as printed", "printed"), ("CGSP", "cgsp")):
        for motion in STEPS:
            value(f"{motion}_{short}", median(motion, method))
        lab = median("translation", method, "laboratory")
        value(f"lab_translation_{short}", lab)
