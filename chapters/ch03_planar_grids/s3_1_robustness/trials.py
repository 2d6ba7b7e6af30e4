"""The levels of the sweeps of 3.3.1, and what their trials share."""

from __future__ import annotations

from functools import lru_cache

from chapters.shared.robustness import DEFAULTS
from chapters.shared.synthetic_board import SIZE_PX, SyntheticBoard

NOISE_SD = (0, 5, 10, 15, 18, 22, 26, 30, 34, 40, 50, 65, 80, 100)
BLUR_PX = (0, 1, 2, 3, 4, 5, 6, 8)
SQUARES_ACROSS = (5, 6, 8, 10, 12, 15, 20, 25, 30, 40)
FOV_DEG = (60, 80, 100, 120, 134, 140, 146, 152, 158, 164)
YAW_DEG = (0, 10, 20, 30, 40, 44, 48, 52, 56)
TRIALS = {"quick": 1, "full": 50}
# Levels of a quick build: those that a claim asks for by name, and no more.
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
}

START_ERRORS_PX = (0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12)
BASIN_QUICK = (0, 4, 8)
BASIN_TRIALS = {"quick": 2, "full": 50}
BASIN_BLUR_PX = 1.0
TERMINATION_PX = 0.1


def sweep(name, values, effort, **other):
    """Conditions along one nuisance, the rest as it is by default."""
    taken = QUICK[name] if effort == "quick" else values
    return [DEFAULTS | other | {name: value} for value in taken]


@lru_cache(maxsize=1)
def basin_image():
    """The image of Fig. 3.10(b), and its true corners (N, 2)."""
    board = SyntheticBoard()
    return board.image(BASIN_BLUR_PX), board.corners
