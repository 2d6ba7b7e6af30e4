"""Motions of section 4.3.2 by method and detector, and what its page quotes."""

import numpy as np

from chapters.ch04_central_generic.s3_4_motion.trials.calibrations import METHODS
from chapters.ch04_central_generic.s3_4_motion.trials.corners import DETECTORS
from chapters.ch04_central_generic.s3_4_motion.trials.stage import BOARDS, STEPS
from chapters.shared.methods import LINEAR_NAMES
from repro.judge.statistics import with_worst
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
    refused = result.arrays(f"refused.{detector}", motion=motion)
    found = [
        off[~lost[:, k]].reshape(-1, 2)
        for k in range(len(BOARDS))
        for lost, off in zip(
            refused, result.arrays(f"errors.{detector}.{k}", motion=motion), strict=True
        )
    ]
    squares = np.sum(np.concatenate(found) ** 2, axis=1)
    return float(np.sqrt(squares.mean()))


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    seeds, corners = map(open_results, ("fig_4_10_seeds", "fig_4_10_corners"))
    shorts = dict(zip(METHODS, ("printed", "well", "cgsp"), strict=True))
    counted = np.array(
        [
            [refusals(corners, motion, detector) for motion in STEPS]
            for detector in DETECTORS
        ]
    ).sum(axis=1)
    found = {
        **{
            f"{motion}_{short}": np.median(
                with_worst(trials_of(seeds, motion, measure, method, DRAWN))
            )
            for method, short in shorts.items()
            for motion, measure in MEASURES.items()
        },
        **{
            f"centre_{short}": np.median(seeds.column(f"centre_mm.{method}"))
            for method, short in shorts.items()
        },
        "lost_percent": 100 * np.mean(seeds.column("without_ray")),
        "seeds_rendered": corners.trials_per_condition,
        "celect_refused": counted[0, 0],
        "clickless_refused": counted[1, 0],
        "boards_shown": counted[0, 1],
    }
    for name, number in found.items():
        value(name, number)
