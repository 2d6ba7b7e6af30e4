"""Outliers, the precision of the SVD, and what the choices are worth."""

from __future__ import annotations

import numpy as np

from chapters.ch04_central_generic.s1_2_linear_stage.results import (
    SVD_CONDITIONS,
    precision_ratio,
)
from chapters.ch04_central_generic.s1_2_linear_stage.trials.choices import CHOICES
from repro.judge.statistics import median_interval
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table


def measured(found, name, condition):
    """Median of a column with its interval, as a cell."""
    return Measured(*median_interval(found.column(name, **condition))[:3])


@table("ext_outliers", needs=("exp_c4_ransac_h",), evidence="synthetic")
def ext_outliers(results):
    """The centre without outliers, with them, with them left out."""
    found = results["exp_c4_ransac_h"]
    conditions = found.conditions
    shares = {
        name: [100 * np.nanmean(found.column(key, **c)) for c in conditions]
        for name, key in (
            ("outliers kept (%)", "wrong_kept"),
            ("right pairs lost (%)", "right_lost"),
        )
    }
    return Table(
        {
            "noise (px)": [c["noise_px"] for c in conditions],
            "no outliers (mm)": [measured(found, "clean_mm", c) for c in conditions],
            "5 %, all fitted (mm)": [
                float(np.nanmedian(found.column("spoilt_mm", **c))) for c in conditions
            ],
            "no centre then (%)": [
                float(100 * np.mean(np.isnan(found.column("spoilt_mm", **c))))
                for c in conditions
            ],
            "5 %, RANSAC (mm)": [measured(found, "ransac_mm", c) for c in conditions],
            **{name: list(map(float, cells)) for name, cells in shares.items()},
        },
        "Centre error with 5 % of the points of each grid anywhere on it: "
        "medians with their 95 % intervals; with outliers in the fit, of the "
        "trials that gave a centre. "
        "A pair is an outlier when either of its points is.",
    )


@table("ext_svd_precision", needs=("exp_c4_svd_precision",), evidence="synthetic")
def ext_svd_precision(results):
    """Residuals and errors of 20 000 pairs in two precisions."""
    found = results["exp_c4_svd_precision"]
    cells = {
        "pairs": list(SVD_CONDITIONS),
        "residual, single (mm)": "single_residual_mm",
        "residual, double (mm)": "double_residual_mm",
        "error, single (mm)": "single_error_mm",
        "error, double (mm)": "double_error_mm",
    }
    conditions = SVD_CONDITIONS.values()
    for name, key in cells.items():
        if name != "pairs":
            cells[name] = [float(np.median(found.column(key, **c))) for c in conditions]
    cells["single / double (1)"] = [
        Measured(*precision_ratio(found, **c)[:3]) for c in conditions
    ]
    return Table(
        cells,
        "A homography of 20 000 pairs by the SVD of all equations: medians of "
        "the RMS distance from the given pairs (residual) and from the true "
        "ones (error), and the ratio of the residuals with its 95 % interval.",
    )


@table("ext_linear_choices", needs=("ext_linear_choices_trials",), evidence="synthetic")
def ext_linear_choices(results):
    """Centre errors with each choice, in four scenes."""
    found = results["ext_linear_choices_trials"]
    return Table(
        {
            "field of view (deg)": [c["fov_deg"] for c in found.conditions],
            "grids": [c["grids"] for c in found.conditions],
            **{
                f"{name} (mm)": [measured(found, name, c) for c in found.conditions]
                for name in CHOICES
            },
        },
        "Centre error at 0.5 px, medians with their 95 % intervals. 100°: the "
        "lens of 4.1.5; 150°: equidistance. Without any outlier.",
    )
