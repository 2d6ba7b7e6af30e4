"""The claims of section 3.3.3, decided by the share of the sets that bear them out."""

from __future__ import annotations

from itertools import product

import numpy as np
from scipy.stats import spearmanr

from chapters.ch03_planar_grids.s3_3_active_grid_robustness.results import (
    NEARLY_ALL,
    PRIMARY,
    SWEPT,
    blur_ratios,
    points_along,
    points_of,
    readings_of,
    shares,
    swept,
    wins,
)
from chapters.ch03_planar_grids.s3_3_active_grid_robustness.trials.sweeps import (
    ACTIVE,
    STATIC,
)
from repro.run.experiment import claim
from repro.run.outcomes import Reading

MOST_CONDITIONS, MOST_LEVELS = 0.8, 0.7
MOST_BLUR_RATIO = 1.5
LEAST_RANK, LEAST_FALL = -0.9, 0.01
ALL = ("corner_window", "second_grid_pictures", "exposure")
OF_FIRST = ("corner_window", "exposure")


def decided(holds):
    """The verdict of a predicate's outcomes, one for each set."""
    return "reproduced" if np.mean(holds) >= NEARLY_ALL else "differs"


def share_readings(results, points_in, least, questions):
    """A reading for each combination: in which share the active grid wins."""
    result = swept(results)
    readings = []
    for asked in readings_of(questions):
        points = points_in(result)
        won = wins(result, points, PRIMARY | asked)
        share = won.mean(axis=0)
        beaten = [
            f"{sweep} {level:g}"
            for (sweep, level), sets in zip(points, won, strict=True)
            if not sets.all()
        ]
        readings.append(
            Reading(
                decided(share >= least),
                float(np.median(share)),
                reading=asked,
                interval=(float(share.min()), float(share.max())),
                unit="1",
                reason=f"median and range over {len(share)} sets, of "
                f"{len(points)} conditions each; holds in "
                f"{int(np.sum(share >= least))}; not the best in every set "
                f"at: {', '.join(beaten) or 'none'}",
            )
        )
    return readings


@claim("c3_active_best", needs=SWEPT, evidence="rendered")
def judge_active_best(results):
    """In four fifths of the conditions no method leaves less."""
    return share_readings(results, points_of, MOST_CONDITIONS, ALL)


@claim("c3_active_distance", needs=SWEPT, evidence="rendered")
def judge_active_distance(results):
    """At seven tenths of the distances no method leaves less."""
    return share_readings(
        results, lambda result: points_along(result, "distance"), MOST_LEVELS, OF_FIRST
    )


@claim("c3_active_orientation", needs=SWEPT, evidence="rendered")
def judge_active_orientation(results):
    """At seven tenths of the orientations no method leaves less."""
    return share_readings(
        results,
        lambda result: points_along(result, "orientation"),
        MOST_LEVELS,
        OF_FIRST,
    )


@claim("c3_active_noise", needs=SWEPT, evidence="rendered")
def judge_active_noise(results):
    """At seven tenths of the levels of noise no method leaves less."""
    return share_readings(
        results, lambda result: points_along(result, "noise"), MOST_LEVELS, ALL
    )


@claim("c3_active_blur", needs=SWEPT, evidence="rendered")
def judge_active_blur(results):
    """Strongest blur over none: least for the active grid, and at most 1.5."""
    readings = []
    for asked in readings_of(ALL):
        ratios = blur_ratios(swept(results), PRIMARY | asked)
        ours, theirs = ratios[ACTIVE], [ratios[method] for method in STATIC]
        holds = (ours < np.minimum(*theirs)) & (ours <= MOST_BLUR_RATIO)
        told = ", ".join(
            f"{method} {np.median(ratio):.3f}" for method, ratio in ratios.items()
        )
        readings.append(
            Reading(
                decided(holds),
                float(np.median(ours)),
                reading=asked,
                interval=(float(ours.min()), float(ours.max())),
                unit="1",
                reason=f"median ratios over {len(ours)} sets: {told}; holds "
                f"in {int(holds.sum())}",
            )
        )
    return readings


@claim(
    "c3_active_viewing_angle",
    needs=("exp_c3_active_viewing_angle",),
    evidence="rendered",
)
def judge_active_viewing_angle(results):
    """The decoded share of the visible area falls as the monitor turns."""
    result = results["exp_c3_active_viewing_angle"]
    turns = sorted({c["turn_deg"] for c in result.conditions})
    readings = []
    for (rim, name), (response, gamma) in product(
        {"with the rim": "share", "without the rim": "without_rim"}.items(),
        {"gamma 2.2": 2.2, "linear": 1.0}.items(),
    ):
        found = np.array([shares(result, t, name, gamma=gamma) for t in turns])
        fall = np.round(found[0] - found[-1], 9)
        holds = [
            drop > LEAST_FALL and spearmanr(turns, along)[0] <= LEAST_RANK
            for drop, along in zip(fall, found.T, strict=True)
        ]
        plain = found[0] - shares(result, turns[-1], name, falloff=0)
        readings.append(
            Reading(
                decided(holds),
                float(np.median(fall)),
                reading={"decodable": rim, "camera_file": response},
                interval=(float(fall.min()), float(fall.max())),
                unit="1",
                reason=f"fall of the share from 0 to {turns[-1]} deg, median "
                f"and range over {len(fall)} seeds; holds in {sum(holds)}"
                + (
                    f"; a monitor without fall-off loses {np.median(plain):.3f}"
                    if gamma > 1
                    else ""
                ),
            )
        )
    return readings
