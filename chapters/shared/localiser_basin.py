"""The localisers of Fig. 3.11(f), and how far off a start they bring back."""

from functools import lru_cache

import numpy as np

from chapters.shared.synthetic_board import SyntheticBoard

# OpenCV's half widths of the 9 x 9 window: the printed 9 is its argument, or the width.
HALF_WINDOWS = {"half window": 9, "full window": 4}
LOCALISED_PX = 0.46
FARTHEST_START_PX = 8
START_ERRORS_PX = {"quick": (0, 4, 8), "full": (0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12)}
BASIN_BLUR_PX = 1.0


@lru_cache(maxsize=1)
def basin_image():
    """The image of Fig. 3.10(b), and its true corners (N, 2)."""
    board = SyntheticBoard()
    return board.image(BASIN_BLUR_PX), board.corners


def off_by(distance, truth, rng):
    """Starts (N, 2) that are `distance` px from the truth (N, 2), in any direction."""
    angle = rng.uniform(0, 2 * np.pi, len(truth))
    return truth + distance * np.column_stack([np.cos(angle), np.sin(angle)])


def basin_scores(localised, truth):
    """Errors px of what a localiser returned, and the share it left in place."""
    error = np.linalg.norm(localised.corners - truth, axis=1)
    return {
        "max_px": float(error.max()),
        "mean_px": float(error.mean()),
        "left_share": float(1 - localised.converged.mean()),
    }


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
