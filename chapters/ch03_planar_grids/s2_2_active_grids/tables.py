"""Table of blooming at corners and over all pixels."""

from itertools import product

import numpy as np

from chapters.ch03_planar_grids.s2_2_active_grids.results import METHODS, bloom_errors
from chapters.ch03_planar_grids.s2_2_active_grids.trials.blooming import (
    EXPOSURES,
    SHARES,
)
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table

# Name in the trials of blooming -> name in the table.
BLOOMED = {method: method for method in METHODS} | {
    "masked": "active grid, masked",
    "all pixels": "all pixels, masked",
}


@table("ext_blooming", needs=("exp_c3_blooming",), evidence="rendered")
def ext_blooming(results):
    """Errors at overexposure, with and without blooming."""
    ran = results["exp_c3_blooming"]
    rows = [
        (
            exposure,
            round(100 * share),
            *(_of_located(bloom_errors(ran, n, exposure, share)) for n in BLOOMED),
            *(
                float(100 * np.median(bloom_errors(ran, n, exposure, share, "share")))
                for n in BLOOMED
            ),
        )
        for exposure, share in product(EXPOSURES, SHARES)
    ]
    names = (
        "Light (full wells)",
        "Overflow (%)",
        *(f"{name} (px)" for name in BLOOMED.values()),
        *(f"{name}, located (%)" for name in BLOOMED.values()),
    )
    return Table(
        columns(names, rows),
        "RMS errors at the corners at overexposure, for two corner methods on a "
        "chessboard and for an active grid with clipped sines kept or masked. Last: "
        "all pixels of the masked grid. Errors: medians over trials that located "
        "anything. Located shares: medians over all trials. Overflow: share of the "
        "excess charge that flows into neighbours.",
    )


def _of_located(errors):
    """Median of the trials that located anything, else None."""
    located = errors[np.isfinite(errors)]
    return Measured.median(located) if len(located) else None
