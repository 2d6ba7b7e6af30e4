"""Results of this page read: values of the prose, figures, tables, judgements."""

import numpy as np

from raxel.calibration.linear.cgsp import SUBSET
from repro.page import rounded, value
from repro.run import (
    Measured,
    Reading,
    Table,
    Value,
    all_of,
    claim,
    columns,
    median_ratio,
    numbers,
    table,
    with_worst,
)

# Estimates of section 4.1.2, from its results.


# Options of svd_condition, in the order of settings.yaml.
SVD_CONDITIONS = {
    "noisy, normalised": {"noise_px": 0.5, "normalised": True},
    "noisy, as they come": {"noise_px": 0.5, "normalised": False},
    "exact, normalised": {"noise_px": 0.0, "normalised": True},
    "exact, as they come": {"noise_px": 0.0, "normalised": False},
}


def name_values(open_results):
    """Name the numbers that the prose quotes."""
    minimal = open_results("exp_c4_min_triplets")
    spoilt = open_results("exp_c4_ransac_h")
    svd = precision_ratio(
        open_results("exp_c4_svd_precision"), **SVD_CONDITIONS["noisy, normalised"]
    )
    found = {
        "four_mm": largest(minimal, "length_mm", rays=4),
        "scenes": minimal.trials_per_condition,
        "ransac_most": largest_with_ransac(spoilt),
        "svd.noisy, normalised": svd.value,
    }
    for name, number in found.items():
        value(name, number)


def largest_with_ransac(spoilt):
    """Return the largest ratio of the errors with outliers (RANSAC) and without."""
    ratios = [
        ratio_of_medians(spoilt, "ransac_mm", "clean_mm", **c)
        for c in spoilt.conditions
    ]
    worst = max(ratios, key=lambda ratio: ratio.value)
    return rounded(worst.value, (worst.low, worst.high))


def largest(found, name, **condition):
    """Return the largest error over trials; a failed trial counts as infinite."""
    return float(with_worst(found.column(name, **condition)).max())


def ratio_of_medians(found, one, other, **condition):
    """Return the ratio of the medians of two errors of the same trials, an Estimate."""
    a, b = (found.column(name, **condition) for name in (one, other))
    return median_ratio(a, b, paired=True)


def precision_ratio(found, **condition):
    """Return the residual in single over that in double precision, an Estimate."""
    return ratio_of_medians(
        found, "single_residual_mm", "double_residual_mm", **condition
    )


# Table on the precision of the SVD.


@table("ext_svd_precision", needs=("exp_c4_svd_precision",), evidence="synthetic")
def ext_svd_precision(results):
    """Residuals and errors of 20 000 pairs in two precisions."""
    found = results["exp_c4_svd_precision"]
    heads = {
        "Residual, single (mm)": "single_residual_mm",
        "Residual, double (mm)": "double_residual_mm",
        "Error, single (mm)": "single_error_mm",
        "Error, double (mm)": "double_error_mm",
    }
    rows = [
        (
            pairs,
            *(float(np.median(found.column(key, **c))) for key in heads.values()),
            Measured(*precision_ratio(found, **c)[:3]),
        )
        for pairs, c in SVD_CONDITIONS.items()
    ]
    return Table(
        columns(("Pairs", *heads, "Residual, single / double"), rows),
        "Residuals and errors of a homography of 20 000 pairs, by the SVD of all "
        "equations in single and double precision. Residual: RMS distance from "
        "the given pairs. Error: RMS distance from the true pairs. Medians, and "
        "the ratio of the residuals with its 95 % interval.",
    )


# Tests of the claims of section 4.1.2, as the registry states them.


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
