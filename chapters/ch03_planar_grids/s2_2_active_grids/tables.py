"""One pixel by hand, the window, the bits, the edges, and blooming as tables."""

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

# What the trials of blooming call it -> its columns.
BLOOMED = {method: method for method in METHODS} | {
    "masked": "active grid, masked",
    "all pixels": "all pixels, masked",
}


@table("ext_blooming", needs=("exp_c3_blooming",), evidence="rendered")
def ext_blooming(results):
    """Errors in too much light, with and without spilling."""
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
        "light (full wells)",
        "spills (%)",
        *(f"{name} (px)" for name in BLOOMED.values()),
        *(f"{name}, located (%)" for name in BLOOMED.values()),
    )
    return Table(
        columns(names, rows),
        "RMS errors at the corners in too much light, by methods that localise them "
        "in a chessboard and by an active grid, with all sines kept and with those "
        "masked that are cut off; then of all pixels of the latter. Of what was "
        "located, medians over the trials that located anything; shares are medians "
        "over all trials.",
    )


def _of_located(errors):
    """Median of the trials that located anything; None where none did."""
    located = errors[np.isfinite(errors)]
    return Measured.median(located) if len(located) else None
