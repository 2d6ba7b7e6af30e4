"""Motions of section 4.3.2 by method and detector, and what its page quotes."""

import numpy as np

from chapters.ch04_central_generic.s3_4_motion.trials.calibrations import METHODS
from chapters.ch04_central_generic.s3_4_motion.trials.corners import DETECTORS
from chapters.ch04_central_generic.s3_4_motion.trials.stage import BOARDS, STEPS
from chapters.shared.methods import LINEAR_NAMES
from repro.judge.statistics import median_interval
from repro.page.reader import value

# What trials call the methods -> words.
NAMES = dict(zip(METHODS, LINEAR_NAMES.values(), strict=True))
MEASURES = {"translation": "deviation_mm", "rotation": "off_deg"}
SCALE = 4  # of the deviations in the drawing
DRAWN = "CELECT"


def trials_of(result, motion, measure, method, detector):
    """Trials (n,) of one measure of one method, nan where it failed."""
    return result.select().column(f"{motion}.{detector}.{method}.{measure}")


def refusals(result, motion, detector):
    """(boards that a detector refused, boards that it was shown)."""
    refused = np.stack(result.arrays(f"refused.{detector}", motion=motion))
    return int(refused.sum()), int(refused.size)


def corner_error(result, motion, detector):
    """RMS error (px) of the corners that a detector found itself."""
    found = []
    refused = result.arrays(f"refused.{detector}", motion=motion)
    for k in range(len(BOARDS)):
        errors = result.arrays(f"errors.{detector}.{k}", motion=motion)
        for lost, off in zip(refused, errors, strict=True):
            found.append(off[~lost[:, k]].reshape(-1, 2))
    return float(np.sqrt(np.sum(np.concatenate(found) ** 2, axis=1).mean()))


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    seeds = open_results("fig_4_10_seeds")
    for method, short in zip(METHODS, ("printed", "well", "cgsp"), strict=True):
        for motion, measure in MEASURES.items():
            trials = trials_of(seeds, motion, measure, method, DRAWN)
            value(f"{motion}_{short}", median_interval(trials).value)
        value(f"centre_{short}", float(np.median(seeds.column(f"centre_mm.{method}"))))
    value("lost_percent", 100 * float(np.mean(seeds.column("without_ray"))))
    corners = open_results("fig_4_10_corners")
    value("seeds_rendered", corners.trials_per_condition)
    for detector, short in zip(DETECTORS, ("celect", "clickless"), strict=True):
        counted = [refusals(corners, motion, detector) for motion in STEPS]
        value(f"{short}_refused", sum(c[0] for c in counted))
    value("boards_shown", sum(c[1] for c in counted))
