"""What section 4.1.2 found, read from its results."""

import numpy as np

from repro.judge.statistics import bootstrap, median_interval, with_worst
from repro.page.reader import value

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
    of_minimum(open_results("exp_c4_min_triplets"))
    of_outliers(open_results("exp_c4_ransac_h"))
    svd = precision_ratio(
        open_results("exp_c4_svd_precision"), **SVD_CONDITIONS["noisy, normalised"]
    )
    value("svd.noisy, normalised", svd.value)
    of_angles(open_results("ext_degeneracy_sweep"))
    of_choices(open_results("ext_linear_choices_trials"))


def of_minimum(found):
    """Errors of four rays."""
    value("four_mm", largest(found, "length_mm", rays=4))
    value("scenes", found.trials_per_condition)
    value("rank_3", found.column("rank", rays=3).max())


def of_outliers(found):
    """The largest ratio to the error without outliers, over the levels of noise."""
    ratios = [
        ratio_of_medians(found, "ransac_mm", "clean_mm", **c).value
        for c in found.conditions
    ]
    value("ransac_most", max(ratios))


def of_angles(found):
    """Errors and refusals at the angles to the base that the prose names."""
    angles = found.by("angle_deg", which="base")
    refused = {angle: one.column("refused").mean() for angle, one in angles.items()}
    value("base.always_deg", max(a for a, share in refused.items() if share == 1))
    value("base.never_deg", min(a for a, share in refused.items() if share == 0))
    parallel, wide = angles[min(angles)], angles[max(angles)]
    value("base.parallel_mm", float(np.nanmedian(parallel.column("unguarded_mm"))))
    value("base.wide_mm", median_interval(wide.column("centre_mm")).value)
    value("base.wide_deg", max(angles))


def of_choices(found):
    """Centre errors in the scene of 4.1.5 and with the wider lens."""
    for fov_deg in (100, 150):
        for name in ("as in the thesis", "weighted"):
            trials = found.column(name, fov_deg=fov_deg, grids=3)
            value(f"choice.{fov_deg}.{name}", median_interval(trials).value)


def largest(found, name, **condition):
    """Largest error over trials; a trial without a result is infinitely off."""
    return float(with_worst(found.column(name, **condition)).max())


def ratio_of_medians(found, one, other, **condition):
    """Ratio of the medians of two errors of the same trials: Estimate."""
    a, b = (with_worst(found.column(name, **condition)) for name in (one, other))
    return bootstrap(
        lambda x, y: np.median(x, axis=-1) / np.median(y, axis=-1), a, b, paired=True
    )


def precision_ratio(found, **condition):
    """Residual in single over that in double precision: Estimate."""
    return ratio_of_medians(
        found, "single_residual_mm", "double_residual_mm", **condition
    )
