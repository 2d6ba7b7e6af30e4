"""Results of this page read: values of the prose, figures, tables, judgements."""

import numpy as np

from raxel.calibration import N_RANSAC_PAIRS
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
    value("four_mm", with_worst(minimal.column("length_mm", rays=4)).max())
    value("scenes", minimal.trials_per_condition)
    ratios = over_clean(open_results("exp_c4_ransac_h"), "ransac_mm")
    worst = max(ratios, key=lambda ratio: ratio.value)
    value("ransac_most", rounded(worst.value, (worst.low, worst.high)))
    svd = precision_ratio(open_results("exp_c4_svd_precision"), "noisy, normalised")
    value("svd.noisy, normalised", svd.value)


def over_clean(result, name):
    """Return the ratio of medians to the error without outliers, at every noise."""
    return [
        median_ratio(*result.column((name, "clean_mm"), **condition), paired=True)
        for condition in result.conditions
    ]


def precision_ratio(result, pairs):
    """Return the residual in single over that in double precision, an Estimate."""
    names = ("single_residual_mm", "double_residual_mm")
    errors = result.column(names, **SVD_CONDITIONS[pairs])
    return median_ratio(*errors, paired=True)


# Table on the precision of the SVD.


@table("ext_svd_precision", needs=("exp_c4_svd_precision",), evidence="synthetic")
def ext_svd_precision(results):
    """Residuals and errors of 20 000 pairs in two precisions."""
    result = results["exp_c4_svd_precision"]
    heads = {
        "Residual, single (mm)": "single_residual_mm",
        "Residual, double (mm)": "double_residual_mm",
        "Error, single (mm)": "single_error_mm",
        "Error, double (mm)": "double_error_mm",
    }
    rows = [
        (
            pairs,
            *np.median(result.column(tuple(heads.values()), **c), axis=-1).tolist(),
            Measured(*precision_ratio(result, pairs)[:3]),
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


FULL_RANK = 8


@claim("c4_min_triplets", needs=("exp_c4_min_triplets",), evidence="analytic")
def judge_minimum(results):
    """Exact from four rays; with three, each homography lacks two equations."""
    result = results["exp_c4_min_triplets"]
    errors = with_worst(result.column(("length_mm", "angle_rad"), rays=4))
    length, angle = errors.max(axis=1).tolist()
    ranks, three_mm = result.column(("rank", "length_mm"), rays=3)
    without = ranks.max() < FULL_RANK and np.isnan(three_mm).all()
    return Reading.of(
        bool(max(length, angle) < 1e-6 and without),
        length,
        "mm",
        f"largest error of a length from four rays in "
        f"{result.trials_per_condition} scenes; of an angle {angle:.1g} "
        f"rad. With three rays a homography has {ranks.max():.0f} "
        f"independent equations for {FULL_RANK} unknowns",
    )


@claim("c4_ransac_h", needs=("exp_c4_ransac_h",), evidence="synthetic")
def judge_ransac(results):
    """At every level: 1.2 x at most with RANSAC, more than 5 x without."""
    result = results["exp_c4_ransac_h"]
    kept, spoilt = (over_clean(result, name) for name in ("ransac_mm", "spoilt_mm"))
    decisions = [r.below(np.nextafter(1.2, 2)) for r in kept]
    decisions += [r.above(5.0) for r in spoilt]
    worst = max(kept, key=lambda ratio: ratio.high)
    smallest = min(spoilt, key=lambda ratio: ratio.low)
    without = "most trials give no centre at all"
    if np.isfinite(smallest.value):
        without = f"{smallest.value:.3g} at least (from {smallest.low:.3g})"
    return Reading.of(
        all_of(decisions),
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
    result, pairs = results["exp_c4_svd_precision"], options["svd_condition"]
    ratio = precision_ratio(result, pairs)
    single = np.median(result.column("single_residual_mm", **SVD_CONDITIONS[pairs]))
    return Reading.of(
        ratio.above(10.0),
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
    by_rays = results["exp_c4_min_triplets"].by("rays").items()
    enough = [n for n, found in by_rays if (found.column("rank") == FULL_RANK).all()]
    determined = results["sec_4_1_2_unknowns"].column("determined")
    return {
        "s4_1_2_triplets": Value(float(min(enough))),
        "s4_1_2_params": Value(float(np.median(determined))),
        "s4_1_2_pairs": Value(N_RANSAC_PAIRS, unit="count"),
    }
