"""Outliers, the precision of the SVD, and what the choices are worth."""

import numpy as np

from chapters.ch04_central_generic.s1_2_linear_stage.results import (
    SVD_CONDITIONS,
    precision_ratio,
)
from chapters.ch04_central_generic.s1_2_linear_stage.trials.choices import CHOICES
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table


@table("ext_outliers", needs=("exp_c4_ransac_h",), evidence="synthetic")
def ext_outliers(results):
    """The centre without outliers, with them, with them left out."""
    found = results["exp_c4_ransac_h"]
    rows = []
    for noise, trials in found.by("noise_px").items():
        spoilt, *shares = (
            trials.column(name) for name in ("spoilt_mm", "wrong_kept", "right_lost")
        )
        rows.append(
            (
                noise,
                Measured.median(trials.column("clean_mm")),
                float(np.nanmedian(spoilt)),
                float(100 * np.mean(np.isnan(spoilt))),
                Measured.median(trials.column("ransac_mm")),
                *(float(100 * np.nanmean(share)) for share in shares),
            )
        )
    names = (
        "noise (px)",
        "no outliers (mm)",
        "5 %, all fitted (mm)",
        "no centre then (%)",
        "5 %, RANSAC (mm)",
        "outliers kept (%)",
        "right pairs lost (%)",
    )
    return Table(
        columns(names, rows),
        "Centre error with 5 % of the points of each grid anywhere on it: "
        "medians with their 95 % intervals; with outliers in the fit, of the "
        "trials that gave a centre. "
        "A pair is an outlier when either of its points is.",
    )


@table("ext_svd_precision", needs=("exp_c4_svd_precision",), evidence="synthetic")
def ext_svd_precision(results):
    """Residuals and errors of 20 000 pairs in two precisions."""
    found = results["exp_c4_svd_precision"]
    heads = {
        "residual, single (mm)": "single_residual_mm",
        "residual, double (mm)": "double_residual_mm",
        "error, single (mm)": "single_error_mm",
        "error, double (mm)": "double_error_mm",
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
        columns(("pairs", *heads, "single / double (1)"), rows),
        "A homography of 20 000 pairs by the SVD of all equations: medians of "
        "the RMS distance from the given pairs (residual) and from the true "
        "ones (error), and the ratio of the residuals with its 95 % interval.",
    )


@table("ext_linear_choices", needs=("ext_linear_choices_trials",), evidence="synthetic")
def ext_linear_choices(results):
    """Centre errors with each choice, in four scenes."""
    found = results["ext_linear_choices_trials"]
    rows = [
        (
            c["fov_deg"],
            c["grids"],
            *(Measured.median(found.column(name, **c)) for name in CHOICES),
        )
        for c in found.conditions
    ]
    names = ("field of view (deg)", "grids", *(f"{name} (mm)" for name in CHOICES))
    return Table(
        columns(names, rows),
        "Centre error at 0.5 px, medians with their 95 % intervals. 100°: the "
        "lens of 4.1.5; 150°: equidistance. Without any outlier.",
    )
