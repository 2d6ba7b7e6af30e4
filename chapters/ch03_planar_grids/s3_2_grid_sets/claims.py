"""The claims of section 3.3.2, tested on rendered sets, seed by seed.

A claim about hardware that we do not have holds if it is true of at least 90 %
of the rendered seeds.
"""

from __future__ import annotations

import numpy as np

from chapters.ch03_planar_grids.s3_2_grid_sets.results import (
    DETECTORS_OF_TODAY,
    EXPERIMENTS,
    GRIDS,
    any_of,
    causes,
    errors,
    of_each_seed,
    pictures_of,
    right,
    spread,
)
from chapters.ch03_planar_grids.s3_2_grid_sets.trials.scores import (
    CONTOUR,
    REFERENCES,
    TRUTH,
)
from chapters.shared.grid_detectors import CELECT, OPENCV
from repro.judge.statistics import FAILS, HOLDS, UNDECIDED, mcnemar
from repro.run.experiment import claim
from repro.run.outcomes import DECISIONS, Reading

MOST_SEEDS = 0.9
LEAST_EXCESS, MOST_CHANCE = 0.2, 0.001
RARE = 0.2
MOST_LOCALISED_PX, MOST_GAP_PX = 0.22, 0.01
CONTOUR_SHARE = 1 / 3
FLEXIBLE_RATE = 0.93


def decided(holds, counted=True):
    """Verdict from whether the predicate is true of each seed.

    counted: whether any seed has what the predicate is about.
    """
    if not counted:
        return DECISIONS[UNDECIDED]
    share = np.mean(holds)
    return DECISIONS[HOLDS if share >= MOST_SEEDS else FAILS]


def seeds_told(holds):
    """The same in words."""
    return f"true of {int(np.sum(holds))} of {len(holds)} seeds"


@claim(
    "c3_beats_opencv",
    needs=GRIDS,
    evidence="rendered",
)
def judge_beats_opencv(results):
    """More in each set, and 20 points more in all, not by chance."""
    readings = []
    for detector in DETECTORS_OF_TODAY:
        holds, excess = [], []
        for seed, ours, theirs in of_each_seed(results, detector):
            excess.append(100 * (ours.mean() - theirs.mean()))
            more = all(
                right(result, CELECT, seed).sum()
                > right(result, detector, seed).sum()
                for result in results.values()
            )
            sure = mcnemar(ours, theirs) < MOST_CHANCE
            holds.append(more and sure and excess[-1] >= 100 * LEAST_EXCESS)
        value, interval = spread(excess)
        readings.append(
            Reading(
                decided(holds),
                value,
                reading={"opencv_detector": detector},
                interval=interval,
                unit="percentage points",
                reason="CELECT's success rate less that of the detector, mean "
                f"and range of the seeds; {seeds_told(holds)}",
            )
        )
    return readings


@claim(
    "c3_subset",
    needs=GRIDS,
    evidence="rendered",
)
def judge_subset(results):
    """Grids only OpenCV finds: at most a fifth of those only CELECT finds."""
    readings = []
    for detector in DETECTORS_OF_TODAY:
        holds, told, counted = [], [], 0
        for _, ours, theirs in of_each_seed(results, detector):
            alone, spared = (theirs & ~ours).sum(), (ours & ~theirs).sum()
            counted += alone + spared
            holds.append(alone <= RARE * spared)
            told.append(f"{alone} to {spared}")
        readings.append(
            Reading(
                decided(holds, counted),
                ", ".join(told),
                reading={"opencv_detector": detector},
                reason="pictures that only the detector, to those that only "
                f"CELECT gets right, by seed; {seeds_told(holds)}",
            )
        )
    return readings


def of_both(results, detector, reference):
    """(set, seed) -> errors of detector and CELECT, before and after."""
    found = {}
    for name, experiment in EXPERIMENTS.items():
        for seed in any_of(results):
            found[name, seed] = {
                (method, when): errors(
                    results[experiment], method, when, reference, seed
                )
                for method in (detector, CELECT)
                for when in ("before", "after")
            }
    return found


def both_have(part, detector):
    """Whether both have a right grid to compare."""
    return min(len(part[m, "before"]) for m in (detector, CELECT)) > 0


def options():
    """Every combination of the open questions of the accuracy claims."""
    return [(d, r) for d in DETECTORS_OF_TODAY for r in REFERENCES]


@claim(
    "c3_less_accurate_raw",
    needs=GRIDS,
    evidence="rendered",
)
def judge_less_accurate_raw(results):
    """Mean and largest error before localisation: CELECT's are larger.

    Against truth alone, as the test has it.
    """
    readings = []
    for detector in DETECTORS_OF_TODAY:
        parts = of_both(results, detector, TRUTH)
        holds, ratios = [], []
        for seed in any_of(results):
            larger = []
            for name in EXPERIMENTS:
                part = parts[name, seed]
                if not both_have(part, detector):
                    larger.append(False)
                    continue
                theirs, ours = (
                    part[method, "before"] for method in (detector, CELECT)
                )
                ratios.append(ours.mean() / theirs.mean())
                larger += [
                    ours.mean() > theirs.mean(),
                    ours.max() > theirs.max(),
                ]
            holds.append(all(larger))
        value, interval = spread(ratios) if ratios else ("none", None)
        readings.append(
            Reading(
                decided(holds),
                value,
                reading={"opencv_detector": detector},
                interval=interval,
                reason="mean error of CELECT over that of the detector, mean "
                "and range over sets and seeds; a set in which one of them "
                f"finds nothing counts against it; {seeds_told(holds)}",
            )
        )
    return readings


@claim(
    "c3_same_after_loc",
    needs=GRIDS,
    evidence="rendered",
)
def judge_same_after_loc(results):
    """After localisation: no error above 0.22 px, means within 0.01 px."""
    readings = []
    for detector, reference in options():
        parts = of_both(results, detector, reference)
        holds, largest, gaps = [], [], []
        for seed in any_of(results):
            good = []
            for name in EXPERIMENTS:
                part = parts[name, seed]
                theirs, ours = (
                    part[method, "after"] for method in (detector, CELECT)
                )
                largest += [e.max() for e in (theirs, ours) if len(e)]
                if not both_have(part, detector):
                    good.append(False)
                    continue
                gaps.append(abs(ours.mean() - theirs.mean()))
                good += [
                    max(theirs.max(), ours.max()) <= MOST_LOCALISED_PX,
                    gaps[-1] <= MOST_GAP_PX,
                ]
            holds.append(all(good))
        gap = f"{max(gaps):.3f} px" if gaps else "none to compare"
        readings.append(
            Reading(
                decided(holds),
                float(max(largest, default=np.inf)),
                reading={
                    "opencv_detector": detector,
                    "corner_reference": reference,
                },
                unit="px",
                reason="largest error of either after localisation; largest "
                f"difference of means: {gap}; a set in which one of them "
                f"finds nothing counts against it; {seeds_told(holds)}",
            )
        )
    return readings


@claim(
    "c3_fail_causes",
    needs=GRIDS,
    evidence="rendered",
)
def judge_fail_causes(results):
    """Lost contours are at most a third of CELECT's failures."""
    told, holds, counted = [], [], 0
    for seed in any_of(results):
        found = causes(results, seed)
        counted += len(found)
        lost = found.count(CONTOUR)
        holds.append(lost <= CONTOUR_SHARE * len(found))
        told.append(f"{lost} of {len(found)}")
    return [
        Reading(
            decided(holds, counted),
            ", ".join(told),
            reason="failures in which a contour was lost, by seed; the first "
            f"failed contour of a picture tells; {seeds_told(holds)}",
        )
    ]


@claim(
    "c3_opencv_missed",
    needs=GRIDS,
    evidence="rendered",
)
def judge_opencv_missed(results):
    """What a Harris detector sees where OpenCV of today fails."""
    shares = np.concatenate(
        [
            [
                result.column("independent", **c)[0]
                for c in pictures_of(result)
            ]
            for result in results.values()
        ]
    )
    shares = shares[np.isfinite(shares)]
    if not len(shares):
        return [
            Reading(
                DECISIONS[FAILS],
                "no failure",
                reason="differs (today's software): OpenCV did not fail",
            )
        ]
    wrong = sum(
        result.column(f"{OPENCV}.returned", **c)[0] == 1
        and result.column(f"{OPENCV}.success", **c)[0] == 0
        for result in results.values()
        for c in pictures_of(result)
    )
    return [
        Reading(
            DECISIONS["undecided"],
            float(shares.mean()),
            interval=(float(shares.min()), float(shares.max())),
            reason="not comparable: today's function returns no unordered "
            "corners. Mean and range of the share of corners that a Harris "
            f"detector sees in the {len(shares)} pictures in which it fails; "
            f"in {wrong} of them it returned wrong corners, else none",
        )
    ]


@claim(
    "c3_examples_exist",
    needs=GRIDS,
    evidence="rendered",
)
def judge_examples_exist(results):
    """Both classes in every set, and CELECT nearly always in the last."""
    readings = []
    for detector in DETECTORS_OF_TODAY:
        holds, rates = [], []
        for seed in any_of(results):
            classes = []
            for result in results.values():
                ours = right(result, CELECT, seed)
                theirs = right(result, detector, seed)
                classes += [(ours & theirs).any(), (ours & ~theirs).any()]
            flexible = results[EXPERIMENTS["flexible-mirror"]]
            rates.append(right(flexible, CELECT, seed).mean())
            holds.append(all(classes) and rates[-1] >= FLEXIBLE_RATE)
        value, interval = spread(rates)
        readings.append(
            Reading(
                decided(holds),
                value,
                reading={"opencv_detector": detector},
                interval=interval,
                reason="CELECT's success rate in the Flexible Mirror set, "
                f"mean and range of the seeds; {seeds_told(holds)}",
            )
        )
    return readings
