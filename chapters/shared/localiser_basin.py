"""The localisers of Fig. 3.11(f), and how far off a start they bring back.

Sections 3.1.3 and 3.3.1 read the same experiment.
"""

from __future__ import annotations

import numpy as np

from raxel.features.localise import derivative, saddle_point

# OpenCV's half widths of the 9 x 9 window, in both readings.
HALF_WINDOWS = {"full window": 4, "half window": 9}
OTHERS = {
    "saddle point": (saddle_point, {"window": 19, "blur_sd": 2.0}),
    "derivative": (derivative, {"window": 19}),
}
LOCALISED_PX = 0.46
FARTHEST_START_PX = 8


def starts_of(result):
    """Start errors (n,) that were run, in order."""
    return np.array([c["start_px"] for c in result.conditions])


def largest_by_start(result, window):
    """Largest error (n,) over corners and trials, for every start error."""
    return np.array(
        [
            result.column(f"{window}.max_px", start_px=start).max()
            for start in starts_of(result).tolist()
        ]
    )


def farthest_start(result, window):
    """Largest start error (px) up to which no corner of any trial is off."""
    good = largest_by_start(result, window) < LOCALISED_PX
    reached = len(good) if good.all() else int(np.argmin(good))
    return float(starts_of(result)[reached - 1]) if reached else 0.0


def worst_within(result, window):
    """Largest error (px) from starts that are no further off than 8 px."""
    near = starts_of(result) <= FARTHEST_START_PX
    return float(largest_by_start(result, window)[near].max())
