"""Tests of the claims of section 4.1.2, as the registry states them."""

import numpy as np

from chapters.ch04_central_generic.s1_2_linear_stage.results import (
    SVD_CONDITIONS,
    largest,
    precision_ratio,
    ratio_of_medians,
)
from raxel.calibration.linear.cgsp import SUBSET
from repro.judge.statistics import all_of
from repro.run.experiment import claim, numbers
from repro.run.outcomes import Reading, Value

EXACT = 1e-6
FULL_RANK = 8
WITH_RANSAC, WITHOUT = 1.2, 5.0
SVD_RATIO = 10.0


@claim("c4_min_triplets", needs=("exp_c4_min_triplets",), evidence="analytic")
def judge_minimum(results):
    """Exact from four rays; with three, each homography lacks two equations."""
    found = results["exp_c4_min_triplets"]
    length = largest(found, "length_mm", rays=4)
    angle = largest(found, "angle_rad", rays=4)
    ranks = found.column("rank", rays=3)
    refused = np.isnan(found.column("length_mm", rays=3)).all()
    holds = max(length, angle) < EXACT and ranks.max() < FULL_RANK and refused
    return Reading.of(
        holds,
        length,
        "mm",
        f"largest error of a length from four rays in "
        f"{found.trials_per_condition} scenes; of an angle {angle:.1g} "
        f"rad. With three rays a homography has {ranks.max():.0f} "
        f"independent equations for {FULL_RANK} unknowns",
    )


@claim("c4_ransac_h", needs=("exp_c4_ransac_h",), evidence="synthetic")
def judge_ransac(results):
    """At every level: 1.2 x at most with RANSAC, more than 5 x without."""
    found = results["exp_c4_ransac_h"]
    kept, spoilt = (
        [ratio_of_medians(found, name, "clean_mm", **c) for c in found.conditions]
        for name in ("ransac_mm", "spoilt_mm")
    )
    decision = all_of(
        [r.below(np.nextafter(WITH_RANSAC, 2)) for r in kept]
        + [r.above(WITHOUT) for r in spoilt]
    )
    worst = max(kept, key=lambda ratio: ratio.high)
    least = min(spoilt, key=lambda ratio: ratio.low)
    without = "most trials give no centre at all"
    if np.isfinite(least.value):
        without = f"{least.value:.3g} at least (from {least.low:.3g})"
    return Reading.of(
        decision,
        worst,
        "1",
        "error with RANSAC over the error without outliers, at the worst of "
        f"{len(kept)} levels of noise; without RANSAC {without}",
    )


@claim(
    "c4_svd_precision",
    needs=("exp_c4_svd_precision",),
    evidence="synthetic",
    readings=("svd_condition",),
)
def judge_precision(results, options):
    """Single over double precision, in each of the four conditions."""
    found = results["exp_c4_svd_precision"]
    condition = SVD_CONDITIONS[options["svd_condition"]]
    ratio = precision_ratio(found, **condition)
    single = np.median(found.column("single_residual_mm", **condition))
    return Reading.of(
        ratio.above(SVD_RATIO),
        ratio,
        "1",
        f"the residual in single precision is {single:.2g} mm",
    )


@numbers(
    "sec_4_1_2",
    needs=("exp_c4_min_triplets", "sec_4_1_2_unknowns"),
    evidence="analytic",
)
def values_of_the_minimum(results):
    """Unknowns that two homographies determine; smallest number of rays."""
    found = results["exp_c4_min_triplets"]
    enough = [
        c["rays"]
        for c in found.conditions
        if (found.column("rank", **c) == FULL_RANK).all()
    ]
    determined = results["sec_4_1_2_unknowns"].column("determined")
    return {
        "s4_1_2_triplets": Value(float(min(enough))),
        "s4_1_2_params": Value(float(np.median(determined))),
        "s4_1_2_pairs": Value(SUBSET, unit="count"),
    }
