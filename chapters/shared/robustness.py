"""The synthetic board of 3.3.1 as a condition describes it, and CELECT's smoothings."""

from chapters.shared.synthetic_board import FULL_RANGE, SIZE_PX, SyntheticBoard
from raxel.features.celect import CelectSettings

# How far Canny's and Harris's gradients are smoothed: 3.3.1 is run with both.
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


def board_of(condition):
    """The board of a condition."""
    return SyntheticBoard(
        square_px=SIZE_PX / condition["squares_across"],
        fov_deg=condition["fov_deg"],
        yaw_deg=condition["yaw_deg"],
    )
