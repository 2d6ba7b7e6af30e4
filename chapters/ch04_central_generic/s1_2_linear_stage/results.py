"""Estimates of section 4.1.2, from its results."""

from repro.judge.statistics import median_ratio, with_worst
from repro.page.reader import value
from repro.page.wording import rounded

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
