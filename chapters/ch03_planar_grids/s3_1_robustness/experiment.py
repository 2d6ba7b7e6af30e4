"""Levels of the sweeps of 3.3.1, and functions shared by their trials."""

from itertools import pairwise

import numpy as np

from chapters.shared.grids import (
    FULL_RANGE,
    HALF_WINDOWS,
    SIZE_PX,
    SyntheticBoard,
    basin_image,
    basin_scores,
    off_by,
)
from raxel.evaluation import distances
from raxel.features.celect import CelectSettings, celect
from raxel.features.localise import corner_subpix

# Smoothing of Canny's and Harris's gradients. The sweeps run with both.
SMOOTHINGS = {
    "share of the square": CelectSettings(),
    "0.7 px": CelectSettings(smoothing_limits_px=(0.7, 0.7)),
}

LEVELS = {"full range": FULL_RANGE, "half range": (64.0, 191.0)}

DEFAULTS = {
    "squares_across": 10,
    "fov_deg": 134,
    "yaw_deg": 0,
    "blur_px": 1,
    "noise_sd": 0,
    "levels": "full range",
}

HALF_NOISE_SD = (0, 5, 10, 15, 18, 22, 26, 30, 34, 40, 50)
# With half the contrast no board is correct at 50.
NOISE_SD = {"full range": (*HALF_NOISE_SD, 65, 80, 100), "half range": HALF_NOISE_SD}
BLUR_PX = (0, 1, 2, 3, 4, 5, 6, 8)
SQUARES_ACROSS = (5, 6, 8, 10, 12, 15, 20, 25, 30, 40)
FOV_DEG = (60, 80, 100, 120, 134, 140, 146, 152, 158, 164)
YAW_DEG = (0, 10, 20, 30, 40, 44, 48, 52, 56)
# Sweeps of Fig. 3.11 other than noise: experiment -> (name, levels).
SWEPT = {
    "fig_3_11_blur": ("blur_px", BLUR_PX),
    "fig_3_11_square": ("squares_across", SQUARES_ACROSS),
    "fig_3_11_fov": ("fov_deg", FOV_DEG),
    "fig_3_11_yaw": ("yaw_deg", YAW_DEG),
}
TRIALS = {"quick": 1, "full": 50}
# Levels of a quick build: those that a claim needs.
QUICK = {
    "noise_sd": (0, 15, 26),
    "blur_px": (1, 2, 4),
    "squares_across": (10, 20, 40),
    "fov_deg": (134, 152),
    "yaw_deg": (0, 40, 56),
}

SETTINGS = {
    "image_px": SIZE_PX,
    "defaults": DEFAULTS,
    "clicks": {"sd_px": 2.0, "cap_px": 4.0},
    "lost_px": 8.0,
    "celect": "the thesis's values (Tables 3.1 and 3.2)",
    "smoothings": list(SMOOTHINGS),
}

BASIN_TRIALS = {"quick": 2, "full": 50}
TERMINATION_PX = 0.1


def board_of(condition):
    """The board of a condition."""
    return SyntheticBoard(
        square_px=SIZE_PX / condition["squares_across"],
        fov_deg=condition["fov_deg"],
        yaw_deg=condition["yaw_deg"],
    )


def sweep(name, values, effort, **other):
    """Conditions along one nuisance, with defaults for the others."""
    taken = QUICK[name] if effort == "quick" else values
    return [DEFAULTS | other | {name: value} for value in taken]


def by_smoothing(score):
    """score(settings) for every smoothing; the values of the first have no prefix."""
    first, *others = SMOOTHINGS
    return score(SMOOTHINGS[first]) | {name: score(SMOOTHINGS[name]) for name in others}


def largest_in_order(result, lattice):
    """Largest error (px) of a complete grid in the right order, without a limit.

    In order: every corner is nearest to its own true corner. Otherwise None.
    """
    if not result.found:
        return None
    truth = lattice.reshape(-1, 2)
    apart = distances(truth, result.corners.reshape(-1, 2))
    own = np.diagonal(apart)
    return float(own.max()) if (own == apart.min(axis=0)).all() else None


SHOWN_YAW_DEG = 40
MERGING_YAW_DEG = {
    "quick": (0, SHOWN_YAW_DEG, 48),
    "full": (0, 10, 20, 30, 34, 36, 38, SHOWN_YAW_DEG, 42, 44, 46, 48),
}


def gaps(candidates, truth):
    """Distance (N - 1,) px between candidates of neighbouring corners (N, 2).

    Each of the candidates (M, 2) belongs to its nearest corner, and the two nearest
    ones count. nan if a corner has no candidate.
    """
    owner = distances(candidates, truth).argmin(axis=1)
    own = [candidates[owner == k] for k in range(len(truth))]
    return np.array(
        [
            distances(a, b).min() if len(a) and len(b) else np.nan
            for a, b in pairwise(own)
        ]
    )


def merging_trial(condition, rng):
    """Candidates on side 1 of a rotated board, with exact clicks."""
    board = board_of(DEFAULTS | {"yaw_deg": condition["yaw_deg"]})
    image = board.image(DEFAULTS["blur_px"])
    truth = board.lattice[0]

    def along_side(settings):
        result = celect(
            image, board.outer_corners, board.columns, board.rows, settings=settings
        )
        side = result.contours[0]
        return {
            "t8_px": settings.merge * side.s,
            "gap_px": float(np.min(gaps(side.inliers, truth))),
            "corners": len(side.merged),
            "candidates": side.inliers,
            "merged": side.merged,
        }

    steps = np.linalg.norm(np.diff(truth, axis=0), axis=1)
    found = {"step_px": float(steps.min())} | by_smoothing(along_side)
    if condition["yaw_deg"] == SHOWN_YAW_DEG:
        found |= {"picture": image, "truth": truth}
    return found


def basin_trial(condition, rng):
    """OpenCV's localiser from starts that all have the same error."""
    image, truth = basin_image()
    start = off_by(condition["start_px"], truth, rng)
    found = {
        name: corner_subpix(
            image, start, half_window=half, termination_px=TERMINATION_PX
        )
        for name, half in HALF_WINDOWS.items()
    }
    return {name: basin_scores(one, truth) for name, one in found.items()}


def image_trial(condition, rng):
    """The board of Fig. 3.10, without blur and noise."""
    board = board_of(condition["of"])
    corners = board.corners
    if condition["shape"] == "bent":
        return {"picture": board.image(0.0), "corners": corners}
    flat = board.chessboard.points()
    flat = flat - flat.mean(axis=0) + (SIZE_PX - 1) / 2
    return {"picture": board.flat_image(), "corners": flat}
