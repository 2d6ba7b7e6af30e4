"""The claim of section 3.3.1 on the localiser, Fig. 3.11(f)."""

from chapters.shared.localiser_basin import (
    FARTHEST_START_PX,
    HALF_WINDOWS,
    LOCALISED_PX,
    farthest_start,
    worst_within,
)
from repro.judge.statistics import FAILS, HOLDS, Estimate
from repro.run.experiment import claim
from repro.run.outcomes import Reading


@claim(
    "c3_localise_converges",
    needs=("fig_3_11_localised",),
    evidence="rendered",
    readings=("localiser_window",),
)
def judge_localise_converges(results, options):
    """Less than 0.46 px from all starts up to 8 px, in both windows.

    The largest error over all trials is counted, not estimated.
    """
    result, window = results["fig_3_11_localised"], options["localiser_window"]
    side, worst = 2 * HALF_WINDOWS[window] + 1, worst_within(result, window)
    left = result.column(f"{window}.left_share", start_px=FARTHEST_START_PX).mean()
    return Reading.of(
        HOLDS if worst < LOCALISED_PX else FAILS,
        Estimate(worst, worst, worst),
        "px",
        f"largest error, {side} x {side} pixels; all corners are within "
        f"{LOCALISED_PX} px up to a start error of "
        f"{farthest_start(result, window):g} px; started 8 px off, "
        f"{100 * left:.0f} % of the corners are left where they were put",
    )
