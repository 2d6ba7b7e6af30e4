"""The verdict of a claim on a rendered rig: true in nine of ten seeds, or not."""

from __future__ import annotations

import numpy as np

from repro.judge.statistics import proportion
from repro.run.outcomes import Reading

SHARE_OF_SEEDS = 0.9


def decided(holds, found, reading, unit, reason):
    """The Reading of a counterpart: true in at least 90 % of the seeds, or not.

    holds: (seeds,) bool; found: (seeds,) what was measured, nan where a method failed.
    """
    share = proportion(np.array(holds, float))
    known = found[np.isfinite(found)]
    return Reading(
        "reproduced" if share.value >= SHARE_OF_SEEDS else "differs",
        float(np.median(known)) if len(known) else "nothing",
        reading=reading,
        interval=(float(known.min()), float(known.max())) if len(known) else None,
        unit=unit,
        reason=f"{reason}; true in {np.count_nonzero(holds)} of {len(holds)} seeds "
        f"({share.low:.2f} to {share.high:.2f})",
    )
