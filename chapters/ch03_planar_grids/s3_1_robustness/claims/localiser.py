"""The claim of section 3.3.1 on the localiser, Fig. 3.11(f)."""

from __future__ import annotations

from chapters.shared.localiser_basin import (
    FARTHEST_START_PX,
    HALF_WINDOWS,
    LOCALISED_PX,
    farthest_start,
    worst_within,
)
from repro.run.experiment import claim
from repro.run.outcomes import Reading


@claim("c3_localise_converges", needs=("fig_3_11_localised",), evidence="rendered")
def judge_localise_converges(results):
    """Less than 0.46 px from all starts up to 8 px, in both windows.

    The largest error over all trials is counted, not estimated.
    """
    result = results["fig_3_11_localised"]
    readings = []
    for window, half in HALF_WINDOWS.items():
        worst = worst_within(result, window)
        left = result.column(f"{window}.left_share", start_px=FARTHEST_START_PX).mean()
        readings.append(
            Reading(
                "reproduced" if worst < LOCALISED_PX else "differs",
                worst,
                reading={"localiser_window": window},
                interval=(worst, worst),
                unit="px",
                reason=f"largest error, {2 * half + 1} x {2 * half + 1} "
                f"pixels; all corners are within {LOCALISED_PX} px up to a "
                f"start error of {farthest_start(result, window):g} px; "
                f"started 8 px off, {100 * left:.0f} % of the corners are "
                "left where they were put",
            )
        )
    return readings
