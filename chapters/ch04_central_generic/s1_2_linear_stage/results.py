"""What section 4.1.2 found, read from its results."""

import numpy as np

from repro.judge.statistics import median_interval, median_ratio, with_worst
from repro.page.reader import value
from repro.page.wording import rounded

# Of the question svd_condition, in the order of settings.yaml.
SVD_CONDITIONS = {
    "noisy, normalised": {"noise_px": 0.5, "normalised": True},
    "noisy, as they come": {"noise_px": 0.5, "normalised": False},
    "exact, normalised": {"noise_px": 0.0, "normalised": True},
    "exact, as they come": {"noise_px": 0.0, "normalised": False},
}
WARNS = 0.03  # degeneracy below which the docstring advises suspicion


def name_values(open_results):
    """Name the numbers that the prose of the page quotes."""
    minimal = open_results("exp_c4_min_triplets")
    spoilt = open_results("exp_c4_ransac_h")
    svd = precision_ratio(
        open_results("exp_c4_svd_precision"), **SVD_CONDITIONS["noisy, normalised"]
    )
    choices = open_results("ext_linear_choices_trials")
    found = {
        "four_mm": largest(minimal, "length_mm", rays=4),
        "scenes": minimal.trials_per_condition,
        "rank_3": minimal.column("rank", rays=3).max(),
        "ransac_most": largest_with_ransac(spoilt),
        "svd.noisy, normalised": svd.value,
        **of_angles(open_results("ext_degeneracy_sweep")),
        **{
            f"choice.{fov_deg}.{name}": median_interval(
                choices.column(name, fov_deg=fov_deg, grids=3)
            ).value
            for fov_deg in (100, 150)
            for name in ("as in the thesis", "weighted")
        },
    }
    for name, number in found.items():
        value(name, number)


def of_angles(found):
    """Errors and refusals at the angles to the base that the prose names."""
    angles = found.by("angle_deg", which="base")
    refused = {angle: one.column("refused").mean() for angle, one in angles.items()}
    parallel, wide = angles[min(angles)], angles[max(angles)]
    return {
        "base.always_deg": max(a for a, share in refused.items() if share == 1),
        "base.never_deg": min(a for a, share in refused.items() if share == 0),
        "base.parallel_mm": np.nanmedian(parallel.column("unguarded_mm")),
        "base.wide_mm": median_interval(wide.column("centre_mm")).value,
        "base.wide_deg": max(angles),
    }


def largest_with_ransac(spoilt):
    """Error with outliers and RANSAC over that without outliers, at its worst."""
    ratios = [
        ratio_of_medians(spoilt, "ransac_mm", "clean_mm", **c)
        for c in spoilt.conditions
    ]
    worst = max(ratios, key=lambda ratio: ratio.value)
    return rounded(worst.value, (worst.low, worst.high))


def largest(found, name, **condition):
    """Largest error over trials; a trial without a result is infinitely off."""
    return float(with_worst(found.column(name, **condition)).max())


def ratio_of_medians(found, one, other, **condition):
    """Ratio of the medians of two errors of the same trials: Estimate."""
    a, b = (found.column(name, **condition) for name in (one, other))
    return median_ratio(a, b, paired=True)


def precision_ratio(found, **condition):
    """Residual in single over that in double precision: Estimate."""
    return ratio_of_medians(
        found, "single_residual_mm", "double_residual_mm", **condition
    )
