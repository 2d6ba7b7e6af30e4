"""Claims of section 3.3.2 about errors of corners, over correct grids alone."""

import numpy as np

from chapters.ch03_planar_grids.s3_2_grid_sets.results.pictures import (
    GRIDS,
    GRIDS_AND_SPACING,
    MIN_SPACING_PX,
    SPACING,
    Which,
    apart,
    errors,
    seeds_of,
    spread,
)
from chapters.ch03_planar_grids.s3_2_grid_sets.results.verdicts import seed_by_seed
from chapters.ch03_planar_grids.s3_2_grid_sets.trials.scores import TRUTH
from chapters.shared.grid_detectors import CELECT
from repro.run.experiment import claim

MAX_LOCALISED_PX, MAX_GAP_PX = 0.22, 0.01
LEFT_OUT = "a set in which one of them finds nothing is left out"


def pairs_by_seed(results, options, errors_of):
    """Errors (N,), (N,) of the detector and of CELECT, of every set that has both.

    options: of the ledger's questions; errors_of: (result, method, which, seed) -> the
    errors of each grid that counts. Returns a list of pairs for every seed that has
    some.
    """
    which = Which.of(options)
    methods = options["opencv_detector"], CELECT
    found = [
        [
            [errors_of(result, m, which, seed) for m in methods]
            for result in results.values()
        ]
        for seed in seeds_of(results, which)
    ]
    of_both = [
        [tuple(map(np.concatenate, pair)) for pair in of_seed if all(pair)]
        for of_seed in found
    ]
    return [pairs for pairs in of_both if pairs]


@claim(
    "c3_less_accurate_raw",
    needs=GRIDS,
    evidence="rendered",
    readings=("opencv_detector", "pose_range", "spots"),
)
def judge_less_accurate_raw(results, options):
    """Mean and largest error before localisation: CELECT's are larger.

    Against truth alone, as the test has it.
    """

    def before(result, method, which, seed):
        return errors(result, method, "before", TRUTH, which, seed)

    seeds = pairs_by_seed(results, options, before)
    ratios = [[ours.mean() / theirs.mean() for theirs, ours in s] for s in seeds]
    holds = [
        min(of_means) > 1 and all(ours.max() > theirs.max() for theirs, ours in pairs)
        for of_means, pairs in zip(ratios, seeds, strict=True)
    ]
    return seed_by_seed(
        holds,
        spread(np.concatenate(ratios)) if seeds else "none",
        "mean error of CELECT over that of the detector, mean and range over sets "
        f"and seeds; {LEFT_OUT}",
    )


@claim(
    "c3_same_after_loc",
    needs=GRIDS_AND_SPACING,
    evidence="rendered",
    readings=(
        "opencv_detector",
        "pose_range",
        "spots",
        "corner_reference",
        "localiser_window",
        "corner_spacing",
    ),
)
def judge_same_after_loc(results, options):
    """After localisation: no error above 0.22 px, means within 0.01 px."""
    reference, window = options["corner_reference"], options["localiser_window"]
    least_px = MIN_SPACING_PX[options["corner_spacing"]]

    def after(result, method, which, seed):
        found = errors(result, method, "after", reference, which, seed, window)
        return apart(found, result, results[SPACING], least_px, method, which, seed)

    seeds = pairs_by_seed({name: results[name] for name in GRIDS}, options, after)
    largest = [max(max(e.max() for e in pair) for pair in pairs) for pairs in seeds]
    gaps = [max(abs(a.mean() - b.mean()) for a, b in pairs) for pairs in seeds]
    holds = [
        high <= MAX_LOCALISED_PX and gap <= MAX_GAP_PX
        for high, gap in zip(largest, gaps, strict=True)
    ]
    return seed_by_seed(
        holds,
        float(max(largest)) if seeds else "none to compare",
        "largest error of either after localisation; largest difference of means: "
        f"{max(gaps, default=0):.3f} px; {LEFT_OUT}",
        "px",
    )
