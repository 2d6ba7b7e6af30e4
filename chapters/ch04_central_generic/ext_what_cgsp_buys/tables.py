"""The steps from the standard method to CGSP, in numbers."""

from itertools import pairwise

import numpy as np

from chapters.ch04_central_generic.ext_what_cgsp_buys.results import (
    NAMES,
    centre,
    failed,
    gain,
)
from chapters.ch04_central_generic.ext_what_cgsp_buys.trials import OUTLIERS, STEPS
from chapters.shared.methods import LINEAR_NAMES
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table


@table("ext_cgsp_steps_table", needs=("ext_cgsp_steps",), evidence="synthetic")
def cgsp_steps(results):
    """Median error of the centre after every change."""
    result = results["ext_cgsp_steps"]
    found = {method: centre(result, method) for method in STEPS}
    gains = [gain(result, *pair) for pair in pairwise(STEPS)]
    return Table(
        {
            "Method": [NAMES[method] for method in STEPS],
            "Error of the centre (mm)": [Measured(*e[:3]) for e in found.values()],
            "Smaller by (1)": [None, *(Measured(*g[:3]) for g in gains)],
            "Gave nothing (trials)": [failed(result, m) for m in STEPS],
        },
        "Error of the centre at a noise of 0.5 px as one change after the "
        "other is made to the standard linear stage: medians over "
        f"{result.trials_per_condition} trials with 95 % intervals. Each line "
        "differs from the one above it by what it names.",
    )


@table("ext_cgsp_outliers_table", needs=("ext_cgsp_outliers",), evidence="synthetic")
def cgsp_outliers(results):
    """Median error of the centre by the share of wrong points."""
    result = results["ext_cgsp_outliers"]
    shown = ("well_conditioned", "cgsp", "cgsp_robust", "well_conditioned_robust")
    words = NAMES | LINEAR_NAMES
    columns = {"Wrong points (%)": [100 * share for share in OUTLIERS]}
    for method in shown:
        columns[f"{words[method]} (mm)"] = [
            _cell(centre(result, method, outliers=share)) for share in OUTLIERS
        ]
    return Table(
        columns,
        "Error of the centre with a share of the points of grids 2 and 3 put "
        "anywhere within 300 mm of the grid's origin: medians over "
        f"{result.trials_per_condition} trials with 95 % intervals. The last "
        "column gives the standard method the rays that CGSP's RANSAC kept. No "
        "interval: its end is among trials that were refused; no number: most "
        "trials were.",
    )


def _cell(found):
    """A median with its interval, as far as they are finite."""
    if np.isfinite(found.high):
        return Measured(*found[:3])
    return float(f"{found.value:.3g}") if np.isfinite(found.value) else None
