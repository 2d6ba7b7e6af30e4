"""The methods, exposure, and errors away from the corners, in numbers."""

import numpy as np

from chapters.ch03_planar_grids.s3_3_active_grid_robustness.results import (
    SWEPT,
    blur_ratios,
    errors,
    levels_of,
    residuals,
    swept,
)
from chapters.ch03_planar_grids.s3_3_active_grid_robustness.trials.sweeps import (
    DEFAULT_MM,
    METHODS,
    ONE_WINDOW,
    OVER,
    TRUE,
)
from repro.run.columns import columns
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table


@table("ext_active_methods", needs=SWEPT, evidence="rendered")
def ext_active_methods(results):
    """Every method at the default condition and at the ends of two sweeps."""
    result = swept(results)
    most = levels_of(result, "noise")[-1]
    blurred = blur_ratios(result)
    rows = [
        (
            method,
            _middle(residuals(result, "distance", DEFAULT_MM, method)),
            _middle(errors(result, "distance", DEFAULT_MM, method)),
            _middle(errors(result, "distance", DEFAULT_MM, method, OVER)),
            _middle(errors(result, "noise", most, method)),
            _middle(blurred[method]),
        )
        for method in METHODS
    ]
    floor = residuals(result, "distance", DEFAULT_MM, TRUE)
    rows.append((TRUE, _middle(floor), *[None] * 4))
    return Table(
        columns(
            (
                "method",
                "residual (mm)",
                "error (px)",
                "error, overexposed (px)",
                f"error, noise {most:g} (px)",
                "residual, blurred to sharp (1)",
            ),
            rows,
        ),
        "At 200 mm and 0°: RMS residual in the second grid, and RMS distance "
        "from the true corners; the ratio is that of the residuals with the "
        "strongest blur and with none. Median over the sets of pictures, and "
        "the least and the largest.",
    )


def _middle(found):
    """Median and range (n,) over sets; None where a set has no value."""
    if not np.isfinite(found).all():
        return None
    return Measured.of_seeds(found)


@table("ext_active_exposure", needs=("ext_active_exposure",), evidence="rendered")
def ext_active_exposure(results):
    """What blooming does to each method at the default condition."""
    result = results["ext_active_exposure"]
    rows = []
    for white in sorted(result.levels("white_of_well")):
        cells = [white, _median(result, "full_wells", white, 100)]
        for kind, digits in (("off_px", 3), ("lost", 0)):
            cells += [
                _median(result, f"{ONE_WINDOW}.{kind}.{m}", white, 1, digits)
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


@table("ext_active_pixels", needs=("ext_active_pixels",), evidence="rendered")
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
