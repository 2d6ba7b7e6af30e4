"""Table 4.4."""

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

NOISES = {"thesis-matched": BENCH, "low-noise": "laboratory"}
COLUMNS = {
    "Omnidirectional, mean (mm)": (OMNI, "mean"),
    "Omnidirectional, SD (mm)": (OMNI, "sd"),
    "Fisheye, mean (mm)": (FISH, "mean"),
    "Fisheye, SD (mm)": (FISH, "sd"),
}
# Cameras, and methods of the thesis, in the ids of the registry.
PRINTED_CAMERAS = {OMNI: "omni", FISH: "fish"}
PRINTED_METHODS = {"printed": "std", "cgsp": "cgsp"}


@table("table_4_4", needs=("fig_4_9_boards",), evidence="rendered")
def table_4_4(results):
    """Tabulate residual statistics of both cameras by method."""
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
            "Noise level": [words for (words, _), _ in rows],
            "Method": [NAMES[m] for _, m in rows],
            **cells,
        },
        "Residuals of chessboards after distortion correction: median, smallest and "
        "largest value of the rendered runs. The rays are intersected with the plane "
        "most nearly perpendicular to them, and a homography maps the points to the "
        "metric grid. The noise level is that of the decoded calibration grids.",
        printed=printed,
    )


def _cell(found):
    return Measured.of_seeds(found) if np.isfinite(found).all() else None
