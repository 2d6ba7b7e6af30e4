"""The precision of the SVD."""

import numpy as np

from chapters.ch04_central_generic.s1_2_linear_stage.results import (
    SVD_CONDITIONS,
    precision_ratio,
)
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table


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
