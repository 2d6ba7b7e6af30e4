"""The claims of section 3.3.2 about which grids are found, seed by seed.

A claim about hardware that we do not have holds if it is true of at least 90 %
of the rendered seeds.
"""

from __future__ import annotations

from itertools import product

import numpy as np

from chapters.ch03_planar_grids.s3_2_grid_sets.results.pictures import (
    ALL_WHICH,
    DETECTORS_OF_TODAY,
    EXPERIMENTS,
    GRIDS,
    any_of,
    causes,
    numbers_of,
    of_each_seed,
    right,
    spread,
)
from chapters.ch03_planar_grids.s3_2_grid_sets.results.verdicts import (
    decided,
    seeds_told,
)
from chapters.ch03_planar_grids.s3_2_grid_sets.trials.scores import CONTOUR
from chapters.shared.grid_detectors import CELECT, OPENCV
from repro.judge.statistics import FAILS, mcnemar
from repro.run.experiment import claim
from repro.run.outcomes import DECISIONS, Reading

LEAST_EXCESS, MOST_CHANCE = 0.2, 0.001
RARE = 0.2
CONTOUR_SHARE = 1 / 3
FLEXIBLE_RATE = 0.93
# Every combination of the open questions of the counts.
READINGS = list(product(DETECTORS_OF_TODAY, ALL_WHICH))


@claim("c3_beats_opencv", needs=GRIDS, evidence="rendered")
def judge_beats_opencv(results):
    """More in each set, and 20 points more in all, not by chance."""
    readings = []
    for detector, which in READINGS:
        holds, excess, rates = [], [], []
        for seed, ours, theirs in of_each_seed(results, detector, which):
            excess.append(100 * (ours.mean() - theirs.mean()))
            rates.append(100 * theirs.mean())
            more = all(
                right(result, CELECT, which, seed).sum()
                > right(result, detector, which, seed).sum()
                for result in results.values()
            )
            sure = mcnemar(ours, theirs) < MOST_CHANCE
            holds.append(more and sure and excess[-1] >= 100 * LEAST_EXCESS)
        value, interval = spread(excess)
        readings.append(
            Reading(
                decided(holds),
                value,
                reading={"opencv_detector": detector, **which.asked()},
                interval=interval,
                unit="percentage points",
                reason="CELECT's success rate less that of the detector, mean "
                f"and range of the seeds; the detector has "
                f"{np.mean(rates):.0f} %, and above 80 % nobody can be 20 "
                f"points ahead; {seeds_told(holds)}",
            )
        )
    return readings


@claim("c3_subset", needs=GRIDS, evidence="rendered")
def judge_subset(results):
    """Grids only OpenCV finds: at most a fifth of those only CELECT finds."""
    readings = []
    for detector, which in READINGS:
        holds, told = [], []
        for _, ours, theirs in of_each_seed(results, detector, which):
            alone, spared = (theirs & ~ours).sum(), (ours & ~theirs).sum()
            told.append(f"{alone} to {spared}")
            if alone + spared:
                holds.append(alone <= RARE * spared)
        readings.append(
            Reading(
                decided(holds),
                ", ".join(told),
                reading={"opencv_detector": detector, **which.asked()},
                reason="pictures that only the detector, to those that only "
                f"CELECT gets right, by seed; {seeds_told(holds)}",
            )
        )
    return readings


@claim("c3_fail_causes", needs=GRIDS, evidence="rendered")
def judge_fail_causes(results):
    """Lost contours are at most a third of CELECT's failures."""
    readings = []
    for which in ALL_WHICH:
        told, holds = [], []
        for seed in any_of(results, which):
            found = causes(results, which, seed)
            lost = found.count(CONTOUR)
            told.append(f"{lost} of {len(found)}")
            if found:
                holds.append(lost <= CONTOUR_SHARE * len(found))
        readings.append(
            Reading(
                decided(holds),
                ", ".join(told),
                reading=which.asked(),
                reason="failures in which a contour was lost, by seed; the "
                "first failed contour of a picture tells; "
                f"{seeds_told(holds)}",
            )
        )
    return readings


@claim("c3_opencv_missed", needs=GRIDS, evidence="rendered")
def judge_opencv_missed(results):
    """What a Harris detector sees where OpenCV of today fails."""
    return [missed_by_opencv(results, which) for which in ALL_WHICH]


def missed_by_opencv(results, which):
    """One reading of it."""
    shares, returned, good = (
        np.concatenate([numbers_of(r, n, which) for r in results.values()])
        for n in ("independent", f"{OPENCV}.returned", f"{OPENCV}.success")
    )
    shares = shares[np.isfinite(shares)]
    if not len(shares):
        return Reading(
            DECISIONS[FAILS],
            "no failure",
            reading=which.asked(),
            reason="differs (today's software): OpenCV did not fail",
        )
    wrong = int(((returned == 1) & (good == 0)).sum())
    return Reading(
        DECISIONS["undecided"],
        float(shares.mean()),
        interval=(float(shares.min()), float(shares.max())),
        reading=which.asked(),
        reason="not comparable: today's function returns no unordered "
        "corners. Mean and range of the share of corners that a Harris "
        f"detector sees in the {len(shares)} pictures in which it fails; "
        f"in {wrong} of them it returned wrong corners, else none",
    )


@claim("c3_examples_exist", needs=GRIDS, evidence="rendered")
def judge_examples_exist(results):
    """Both classes in every set, and CELECT nearly always in the last."""
    readings = []
    for detector, which in READINGS:
        holds, rates = [], []
        for seed in any_of(results, which):
            classes = []
            for result in results.values():
                ours = right(result, CELECT, which, seed)
                theirs = right(result, detector, which, seed)
                classes += [(ours & theirs).any(), (ours & ~theirs).any()]
            flexible = results[EXPERIMENTS["flexible-mirror"]]
            rates.append(right(flexible, CELECT, which, seed).mean())
            holds.append(all(classes) and rates[-1] >= FLEXIBLE_RATE)
        value, interval = spread(rates)
        readings.append(
            Reading(
                decided(holds),
                value,
                reading={"opencv_detector": detector, **which.asked()},
                interval=interval,
                reason="CELECT's success rate in the Flexible Mirror set, "
                f"mean and range of the seeds; {seeds_told(holds)}",
            )
        )
    return readings
