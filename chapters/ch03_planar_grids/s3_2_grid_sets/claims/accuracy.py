"""The claims of section 3.3.2 about errors of corners, over right grids alone."""

from __future__ import annotations

from itertools import product

import numpy as np

from chapters.ch03_planar_grids.s3_2_grid_sets.results.pictures import (
    ALL_WHICH,
    DETECTORS_OF_TODAY,
    GRIDS,
    any_of,
    errors,
    spread,
)
from chapters.ch03_planar_grids.s3_2_grid_sets.results.verdicts import (
    decided,
    seeds_told,
)
from chapters.ch03_planar_grids.s3_2_grid_sets.trials.scores import REFERENCES, TRUTH
from chapters.shared.grid_detectors import CELECT
from chapters.shared.localiser_basin import HALF_WINDOWS
from repro.run.experiment import claim
from repro.run.outcomes import Reading

MOST_LOCALISED_PX, MOST_GAP_PX = 0.22, 0.01
LEFT_OUT = "a set in which one of them finds nothing is left out"


def of_both(results, detector, seed, *asked, **options):
    """Errors (N,) of the detector and of CELECT, of every set that has both.

    asked: when and against what; options: as `errors` takes them.
    """
    for result in results.values():
        pair = [
            errors(result, method, *asked, seed=seed, **options)
            for method in (detector, CELECT)
        ]
        if all(pair):
            yield tuple(np.concatenate(grids) for grids in pair)


@claim("c3_less_accurate_raw", needs=GRIDS, evidence="rendered")
def judge_less_accurate_raw(results):
    """Mean and largest error before localisation: CELECT's are larger.

    Against truth alone, as the test has it.
    """
    readings = []
    for detector, which in product(DETECTORS_OF_TODAY, ALL_WHICH):
        holds, ratios = [], []
        for seed in any_of(results, which):
            larger = []
            for theirs, ours in of_both(
                results, detector, seed, "before", TRUTH, which=which
            ):
                ratios.append(ours.mean() / theirs.mean())
                larger += [ratios[-1] > 1, ours.max() > theirs.max()]
            if larger:
                holds.append(all(larger))
        value, interval = spread(ratios) if ratios else ("none", None)
        readings.append(
            Reading(
                decided(holds),
                value,
                reading={"opencv_detector": detector, **which.asked()},
                interval=interval,
                reason="mean error of CELECT over that of the detector, mean "
                f"and range over sets and seeds; {LEFT_OUT}; "
                f"{seeds_told(holds)}",
            )
        )
    return readings


@claim("c3_same_after_loc", needs=GRIDS, evidence="rendered")
def judge_same_after_loc(results):
    """After localisation: no error above 0.22 px, means within 0.01 px."""
    readings = []
    for detector, which, reference, window in product(
        DETECTORS_OF_TODAY, ALL_WHICH, REFERENCES, HALF_WINDOWS
    ):
        holds, largest, gaps = [], [], []
        for seed in any_of(results, which):
            good = []
            for theirs, ours in of_both(
                results, detector, seed, "after", reference, which=which, window=window
            ):
                largest.append(max(theirs.max(), ours.max()))
                gaps.append(abs(ours.mean() - theirs.mean()))
                good += [largest[-1] <= MOST_LOCALISED_PX, gaps[-1] <= MOST_GAP_PX]
            if good:
                holds.append(all(good))
        readings.append(
            Reading(
                decided(holds),
                float(max(largest)) if largest else "none to compare",
                reading={
                    "opencv_detector": detector,
                    "corner_reference": reference,
                    "localiser_window": window,
                    **which.asked(),
                },
                unit="px",
                reason="largest error of either after localisation; largest "
                f"difference of means: {max(gaps, default=0):.3f} px; "
                f"{LEFT_OUT}; {seeds_told(holds)}",
            )
        )
    return readings
