"""Table 3.8, and the same in other readings."""

import numpy as np

from chapters.ch03_planar_grids.s3_4_active_grid_images.results import (
    CORNERS,
    FACETS,
    METHODS,
    NAMES,
    Corners,
)
from repro.run.experiment import table
from repro.run.outcomes import Measured, Table

# What the ledger's ids call the methods.
PRINTED = ("derivative", "opencv", "saddle", "active")


of_seeds = Measured.of_seeds


@table("table_3_8", needs=("table_3_8_corners",), evidence="rendered")
def table_3_8(results):
    """Errors of four methods with their best settings."""
    case = Corners(results[CORNERS])
    windows = [of_seeds(case.best_window(m)) for m in METHODS[:3]]
    blur = of_seeds(case.best_blur())
    return Table(
        {
            "Method": list(METHODS),
            "Mean (px)": [of_seeds(case.statistic(m, "mean")) for m in METHODS],
            "SD (px)": [of_seeds(case.statistic(m, "sd")) for m in METHODS],
            "Best window (px)": [*windows, None],
            "Best blur SD (px)": [None, None, blur, None],
        },
        "Residuals of the corners of one chessboard after the homography from the "
        "metric grid, with the window and blur of the least mean residual: "
        "medians, and "
        f"ranges over {len(case.trials.conditions)} seeds. Pictures undistorted with "
        "Zhang's calibration.",
        printed={
            "Mean (px)": [f"t3_8_{name}_mean" for name in PRINTED],
            "SD (px)": [f"t3_8_{name}_sd" for name in PRINTED],
            "Best window (px)": [*(f"t3_8_{name}_win" for name in PRINTED[:3]), None],
        },
    )


@table("ext_fig_3_18_numbers", needs=("fig_3_18_facets",), evidence="rendered")
def ext_fig_3_18_numbers(results):
    """The mirror ball by seed."""
    trials = results[FACETS].select()
    off = trials.arrays("corner_squares")
    count = {
        name: [int(n) for n in trials.column(name)]
        for name in ("facets", "corners", "detector_found")
    }
    all_together, alone = (
        [float(100 * np.mean(one < 0.5)) for one in trials.arrays(name)]
        for name in NAMES["static_grid"].values()
    )
    return Table(
        {
            "Seed": trials.levels("seed"),
            "Facets with the monitor": count["facets"],
            "Corners of the board": count["corners"],
            "Corners measured": [int(np.isfinite(e).sum()) for e in off],
            "Median error (squares)": [float(np.nanmedian(e)) for e in off],
            "Largest error (squares)": [float(np.nanmax(e)) for e in off],
            "Static grid fails, all facets (%)": all_together,
            "Static grid fails, each alone (%)": alone,
            "Boards found by a detector": count["detector_found"],
        },
        "Corners of the chessboard put together from the facets, and facets on which a "
        "static grid gives less than half of the pixels a place within 0.1 square.",
    )
