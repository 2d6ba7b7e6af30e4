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
    "Omnidirectional, mean (mm)": (OMNI, "mean"),
    "Omnidirectional, SD (mm)": (OMNI, "sd"),
    "Fisheye, mean (mm)": (FISH, "mean"),
    "Fisheye, SD (mm)": (FISH, "sd"),
}
# What the ledger's ids call cameras, and the methods that the thesis has.
PRINTED_CAMERAS = {OMNI: "omni", FISH: "fish"}
PRINTED_METHODS = {"printed": "std", "cgsp": "cgsp"}


@table("table_4_4", needs=("fig_4_9_boards",), evidence="rendered")
def table_4_4(results):
    """Residual statistics of both cameras by method."""
    result = results[BOARDS]
    cells = {
        title: [_cell(of_camera(result, camera, f"{m}.{name}_mm")) for m in NAMES]
        for title, (camera, name) in COLUMNS.items()
    }
    printed = {
        title: [
            f"t4_4_{PRINTED_CAMERAS[camera]}_{PRINTED_METHODS[m]}_{name}"
            if m in PRINTED_METHODS
            else None
            for m in NAMES
        ]
        for title, (camera, name) in COLUMNS.items()
    }
    return Table(
        {"Method": list(NAMES.values()), **cells},
        "Residuals of chessboards after correction: median of the rendered "
        "seeds, with the smallest and the largest. A board is cut with the "
        "plane across its rays and carried onto the metric grid by a "
        "homography.",
        printed=printed,
    )


def _cell(found):
    return Measured.of_seeds(found) if np.isfinite(found).all() else None
