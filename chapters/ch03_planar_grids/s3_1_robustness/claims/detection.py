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

MIN_SHARE = 0.99


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
    """Of the complete grids in the right order 99 % have an error below 8 px.

    The order alone decides which grids count. With the limit of 8 px of 3.3.1 no
    grid could fail.
    """
    levels = full_range_levels(sweeps_under(results, options["celect_smoothing"]))
    largest = np.concatenate(
        [result.column("ordered_px", **condition) for result, condition in levels]
    )
    largest = largest[np.isfinite(largest)]
    share = proportion(largest < LOST_PX)
    return Reading.of(
        share.above(MIN_SHARE - 1e-9),
        share,
        "1",
        f"of {len(largest)} complete grids in the right order in the synthetic tests "
        f"of 3.3.1; largest error {largest.max():.1f} px",
    )
