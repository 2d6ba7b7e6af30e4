"""Table 4.4, beside what the thesis printed."""

from itertools import product

import numpy as np

from chapters.ch04_central_generic.s3_3_correction.results import (
    BOARDS,
    NAMES,
    Corrected,
)
from chapters.shared.bench_noise import BENCH
from chapters.shared.central_sets import FISH, OMNI
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table

NOISES = {"bench": BENCH, "laboratory": "laboratory"}
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
    rows = list(product(NOISES.items(), NAMES))
    cells = {
        title: [
            _cell(Corrected(results[BOARDS], noise=noise).of(camera, f"{m}.{name}_mm"))
            for (_, noise), m in rows
        ]
        for title, (camera, name) in COLUMNS.items()
    }
    printed = {
        title: [
            f"t4_4_{PRINTED_CAMERAS[camera]}_{PRINTED_METHODS[m]}_{name}"
            if m in PRINTED_METHODS and noise == BENCH
            else None
            for (_, noise), m in rows
        ]
        for title, (camera, name) in COLUMNS.items()
    }
    return Table(
        {
            "Noise": [words for (words, _), _ in rows],
            "Method": [NAMES[m] for _, m in rows],
            **cells,
        },
        "Residuals of chessboards after correction: median of the rendered "
        "seeds, with the smallest and the largest. A board is cut with the "
        "plane across its rays and carried onto the metric grid by a "
        "homography. The grids that calibrated were decoded with errors as large as "
        "the bench's, or with the laboratory's own.",
        printed=printed,
    )


def _cell(found):
    return Measured.of_seeds(found) if np.isfinite(found).all() else None
