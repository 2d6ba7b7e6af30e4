"""Table 4.4, beside what the thesis printed."""

import numpy as np

from chapters.ch04_central_generic.s3_3_correction.results import (
    BOARDS,
    NAMES,
    of_camera,
)
from chapters.shared.central_sets import FISH, OMNI
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table

COLUMNS = {
    "Omnidirectional, mean (mm)": (OMNI, "mean_mm"),
    "Omnidirectional, SD (mm)": (OMNI, "sd_mm"),
    "Fisheye, mean (mm)": (FISH, "mean_mm"),
    "Fisheye, SD (mm)": (FISH, "sd_mm"),
}


@table("table_4_4", needs=("fig_4_9_boards",), evidence="rendered")
def table_4_4(results):
    """Residual statistics of both cameras by method."""
    result = results[BOARDS]
    cells = {
        title: [_cell(of_camera(result, camera, f"{m}.{name}")) for m in NAMES]
        for title, (camera, name) in COLUMNS.items()
    }
    return Table(
        {"Method": list(NAMES.values()), **cells},
        "Residuals of chessboards after correction: median of the rendered "
        "seeds, with the smallest and the largest. A board is cut with the "
        "plane across its rays and carried onto the metric grid by a "
        "homography.",
    )


def _cell(found):
    return Measured.of_seeds(found) if np.isfinite(found).all() else None
