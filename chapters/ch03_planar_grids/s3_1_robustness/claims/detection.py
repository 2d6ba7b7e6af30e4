"""The claim of section 6.3.1 on CELECT's error, along the sweeps of Fig. 3.11."""

import numpy as np

from chapters.ch03_planar_grids.s3_1_robustness.results import (
    full_range_levels,
    sweeps_under,
)
from chapters.shared.scoring import LOST_PX
from repro.judge.statistics import proportion
from repro.run.experiment import claim
from repro.run.outcomes import Reading

NEARLY_ALL = 0.99


@claim(
    "c6_detect_8px",
    needs=(
        "fig_3_11_noise",
        "fig_3_11_blur",
        "fig_3_11_square",
        "fig_3_11_fov",
        "fig_3_11_yaw",
    ),
    evidence="rendered",
    readings=("celect_smoothing",),
)
def judge_detect_8px(results, options):
    """Of the complete grids in the right order 99 % are less than 8 px off.

    The order alone says which grids count: with the limit of 8 px that 3.3.1 calls
    a success none could fail.
    """
    levels = full_range_levels(sweeps_under(results, options["celect_smoothing"]))
    largest = np.concatenate(
        [result.column("ordered_px", **condition) for result, condition in levels]
    )
    largest = largest[np.isfinite(largest)]
    share = proportion(largest < LOST_PX)
    return Reading.of(
        share.above(NEARLY_ALL - 1e-9),
        share,
        "1",
        f"of {len(largest)} complete grids in the right order in the synthetic tests "
        f"of 3.3.1; largest error {largest.max():.1f} px",
    )
