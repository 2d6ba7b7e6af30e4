"""Table 3.8, and the numbers of Fig. 3.18."""

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

# Names of the methods in the registry's ids.
PRINTED = ("derivative", "opencv", "saddle", "active")


of_seeds = Measured.of_seeds


@table("table_3_8", needs=("table_3_8_corners",), evidence="rendered")
def table_3_8(results):
    """Return the errors of four methods with their best settings."""
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
        "Residuals of the corners of one chessboard after a homography from the "
        "metric grid, with the window and blur of the smallest mean residual: median "
        f"and range over {len(case.trials.conditions)} simulated runs. Images are "
        "undistorted with Zhang's calibration.",
        printed={
            "Mean (px)": [f"t3_8_{name}_mean" for name in PRINTED],
            "SD (px)": [f"t3_8_{name}_sd" for name in PRINTED],
            "Best window (px)": [*(f"t3_8_{name}_win" for name in PRINTED[:3]), None],
        },
    )


@table("ext_fig_3_18_numbers", needs=("fig_3_18_facets",), evidence="rendered")
def ext_fig_3_18_numbers(results):
    """Return the results of the mirror ball by simulated run."""
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
            "Run": trials.levels("seed"),
            "Facets with the monitor": count["facets"],
            "Corners of the board": count["corners"],
            "Corners measured": [int(np.isfinite(e).sum()) for e in off],
            "Median error (squares)": [float(np.nanmedian(e)) for e in off],
            "Largest error (squares)": [float(np.nanmax(e)) for e in off],
            "Static grid fails, all facets (%)": all_together,
            "Static grid fails, each alone (%)": alone,
            "Boards found by a detector": count["detector_found"],
        },
        "Corners of the chessboard reassembled from the facets, by simulated run. A "
        "static grid fails on a facet if less than half of its pixels get a position "
        "within 0.1 square.",
    )
