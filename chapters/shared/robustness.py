"""The sweeps of 3.3.1: CELECT on the synthetic board, one nuisance at a time."""

from __future__ import annotations

import numpy as np

from chapters.shared.scoring import scored
from chapters.shared.synthetic_board import (
    FULL_RANGE,
    SIZE_PX,
    Board,
    clicks,
)
from raxel.features.celect import celect

NOISE_SD = (0, 5, 10, 15, 18, 22, 26, 30, 34, 40, 50, 65, 80, 100)
BLUR_PX = (0, 1, 2, 3, 4, 5, 6, 8)
SQUARES_ACROSS = (5, 6, 8, 10, 12, 15, 20, 25, 30, 40)
FOV_DEG = (60, 80, 100, 120, 134, 140, 146, 152, 158, 164)
YAW_DEG = (0, 10, 20, 30, 40, 44, 48, 52, 56)
LEVELS = {"full range": FULL_RANGE, "half range": (64.0, 191.0)}
TRIALS = {"quick": 1, "full": 50}
# Levels of a quick build: those that a claim asks for by name, and no more.
QUICK = {
    "noise_sd": (0, 15, 26),
    "blur_px": (1, 2, 4),
    "squares_across": (10, 20, 40),
    "fov_deg": (134, 152),
    "yaw_deg": (0, 40, 56),
}

DEFAULTS = {
    "squares_across": 10,
    "fov_deg": 134,
    "yaw_deg": 0,
    "blur_px": 1,
    "noise_sd": 0,
    "levels": "full range",
}
SETTINGS = {
    "image_px": SIZE_PX,
    "defaults": DEFAULTS,
    "clicks": {"sd_px": 2.0, "cap_px": 4.0},
    "lost_px": 8.0,
    "celect": "the thesis's values (Tables 3.1 and 3.2)",
}


def sweep(name, values, effort, **other):
    """Conditions along one nuisance, the rest as it is by default."""
    taken = QUICK[name] if effort == "quick" else values
    return [DEFAULTS | other | {name: value} for value in taken]


def board_of(condition):
    """The board of a condition."""
    return Board(
        square_px=SIZE_PX / condition["squares_across"],
        fov_deg=condition["fov_deg"],
        yaw_deg=condition["yaw_deg"],
    )


def robustness_trial(condition, rng):
    """One picture, one set of clicks, one run of CELECT, and its score.

    Where an outer corner is not in the picture nobody can click it: lost.
    """
    board = board_of(condition)
    distances = {
        "least_px": board.least_spacing,
        "rim_px": board.rim_spacing,
    }
    if np.isnan(board.corners).any():
        return distances | {
            "success": False,
            "stage": "corner not in the picture",
            "missed": int(np.isnan(board.corners[:, 0]).sum()),
            "missed_on_rim": int(np.isnan(board.corners[:, 0]).sum()),
        }
    outer = clicks(board.outer_corners, rng)
    image = board.image(
        condition["blur_px"],
        condition["noise_sd"],
        rng,
        LEVELS[condition["levels"]],
    )
    result = celect(image, outer, board.columns, board.rows)
    lattice = board.corners.reshape(board.rows, board.columns, 2)
    off = np.linalg.norm(outer - board.outer_corners, axis=1).mean()
    return distances | scored(result, lattice) | {"click_px": float(off)}
