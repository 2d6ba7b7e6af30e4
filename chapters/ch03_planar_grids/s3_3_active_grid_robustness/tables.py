"""Exposure, and errors away from the corners, in numbers."""

from __future__ import annotations

import numpy as np

from chapters.ch03_planar_grids.s3_3_active_grid_robustness.trials.sweeps import (
    METHODS,
    ONE_WINDOW,
)
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Table


@table(
    "ext_active_exposure",
    needs=("ext_active_exposure",),
    evidence="rendered",
)
def ext_active_exposure(results):
    """What blooming does to each method at the default condition."""
    result = results["ext_active_exposure"]
    rows = []
    for white in sorted({c["white_of_well"] for c in result.conditions}):
        cells = [white, _median(result, "full_wells", white, 100)]
        for kind, digits in (("off_px", 3), ("lost", 0)):
            cells += [
                _median(
                    result, f"{ONE_WINDOW}.{kind}.{m}", white, 1, digits
                )
                for m in METHODS
            ]
        rows.append(cells)
    names = (
        "white (full wells)",
        "full pixels (%)",
        *(f"{method}, error (px)" for method in METHODS),
        *(f"{method}, lost" for method in METHODS),
    )
    return Table(
        columns(names, rows),
        "Default condition, photographed with more and more light, first "
        "grid and chessboard alike: RMS distance from the true corners, and "
        "how many of 225 corners are lost. A full well gives half of what "
        "is too much to its column.",
    )


def _median(result, name, white, factor, digits=1):
    found = result.column(name, white_of_well=white)
    middle = factor * float(np.median(found))
    return round(middle, digits) if np.isfinite(middle) else None


@table(
    "ext_active_pixels", needs=("ext_active_pixels",), evidence="rendered"
)
def ext_active_pixels(results):
    """Errors of the first grid over all its pixels and next to the corners."""
    result = results["ext_active_pixels"]
    rows = [
        (
            condition["camera_gamma"],
            condition["steps"],
            *(
                round(1000 * float(result.column(name, **condition)[0]), 1)
                for name in ("all_mm", "corners_mm")
            ),
        )
        for condition in result.conditions
    ]
    return Table(
        columns(
            (
                "gamma of the camera",
                "phase steps",
                "all pixels, RMS (um)",
                "at corners, RMS (um)",
            ),
            rows,
        ),
        "Error of the decoded point of a pixel against the truth, at the "
        "default condition. Corners lie where sines cross their mean, where "
        "a bent response does no harm.",
    )
