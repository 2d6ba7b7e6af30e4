"""Motions of section 4.3.2 by method and detector, and what its page quotes."""

import numpy as np

from chapters.ch04_central_generic.s3_4_motion.trials.calibrations import METHODS
from chapters.ch04_central_generic.s3_4_motion.trials.corners import DETECTORS
from chapters.ch04_central_generic.s3_4_motion.trials.stage import STEPS
from chapters.shared.bench_noise import BENCH, OPTIONS
from chapters.shared.methods import LINEAR_NAMES
from repro.judge.statistics import wins, with_worst
from repro.page.reader import value
from repro.run.readings import Case

# What trials call the methods -> words.
NAMES = dict(zip(METHODS, LINEAR_NAMES.values(), strict=True))
MEASURES = {"translation": "deviation_mm", "rotation": "off_deg"}
MIN_GAIN = 1.05  # of the medians, that the rule for wins asks for
SCALE = 4  # of the deviations in the drawing
DRAWN = "CELECT"


READINGS = {
    "decoding_noise": OPTIONS,
    "standard_method": {name: name for name in METHODS[:2]},
    "motion_corners": {name: name for name in DETECTORS},
}


def trials_of(result, motion, measure, method, detector, noise=BENCH):
    """Trials (n,) of one measure of one method, nan where it failed."""
    return result.select().column(f"{noise}.{motion}.{detector}.{method}.{measure}")


def ahead_at(result, options, motion, noise):
    """wins(CGSP < standard) in one motion's measure, a `Comparison`."""
    case = Case(READINGS, options)
    ours, theirs = (
        trials_of(
            result, motion, MEASURES[motion], method, case["motion_corners"], noise
        )
        for method in ("CGSP", case["standard_method"])
    )
    return wins([(ours, theirs)])[0]


def refusals(result, motion, detector):
    """(boards that a detector refused, boards that it was shown)."""
    refused = np.stack(result.arrays(f"refused.{detector}", motion=motion))
    return int(refused.sum()), int(refused.size)


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    seeds, corners, rendered = map(
        open_results, ("fig_4_10_seeds", "fig_4_10_corners", "fig_4_10_rendered")
    )
    shorts = dict(zip(METHODS, ("printed", "well", "cgsp"), strict=True))
    counted = np.array(
        [
            [refusals(corners, motion, detector) for motion in STEPS]
            for detector in DETECTORS
        ]
    ).sum(axis=1)
    found = {
        "lost_percent": 100 * np.mean(seeds.column("without_ray")),
        "seeds_rendered": corners.trials_per_condition,
        "celect_refused": counted[0, 0],
        "clickless_refused": counted[1, 0],
        "boards_shown": counted[0, 1],
    }
    for prefix, noise in (("", BENCH), ("lab_", "laboratory")):
        for method, short in shorts.items():
            centres = seeds.column(f"{noise}.centre_mm.{method}")
            found[f"{prefix}centre_{short}"] = np.median(with_worst(centres))
            for motion, measure in MEASURES.items():
                trials = trials_of(seeds, motion, measure, method, DRAWN, noise)
                found[f"{prefix}{motion}_{short}"] = np.median(with_worst(trials))
                taken = trials_of(rendered, motion, measure, method, DRAWN, noise)
                found[f"{prefix}rendered_{motion}_{short}"] = np.median(taken)
    for name, number in found.items():
        value(name, number)
