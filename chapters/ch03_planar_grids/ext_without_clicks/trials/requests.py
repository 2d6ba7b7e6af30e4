"""What the detectors are asked for, and when their answer is right."""

import numpy as np

from chapters.ch03_planar_grids.ext_without_clicks.trials.zoo_boards import (
    DRAWN,
    LARGER,
)
from raxel.evaluation.benchmark import corner_errors
from raxel.evaluation.board_scores import share_in_order
from raxel.sets.reference import ReferenceCorners

RIGHT_PX = 1.0
COUNTING = ("raxel", "opencv-sb")
NAMES = {"known": "size given", "counted": "size not given"}
SETTINGS = {
    "right_px": RIGHT_PX,
    "larger": LARGER,
    "drawn": {name: list(limits) for name, limits in DRAWN.items()},
}
SWEPT = {
    "noise": ("noise_sd", "SD of the noise", "grey levels"),
    "blur": ("blur_px", "SD of the blur", "px"),
    "squares": ("square_px", "side of a square", "px"),
    "field": ("fov_deg", "field of view", "°"),
    "yaw": ("yaw_deg", "yaw", "°"),
}
LEVELS = {
    "noise": (0, 10, 20, 30, 40, 60),
    "blur": (1, 2, 3, 4, 5, 7),
    "squares": (100, 66, 50, 40, 33),
    "field": (100, 120, 134, 145, 152),
    "yaw": (0, 15, 30, 40, 44),
}
QUICK_LEVELS = {"noise": (20,), "blur": (2,), "squares": (), "field": (), "yaw": ()}


def sweep_conditions(effort):
    """Every level of every sweep."""
    levels = LEVELS if effort == "full" else QUICK_LEVELS
    return [
        {"sweep": sweep, "level": level}
        for sweep, values in levels.items()
        for level in values
    ]


def scored(found, corners, columns, rows):
    """{found, right, wrong, worst_px} of a Detection."""
    certain = np.ones(len(corners), bool)
    truth = ReferenceCorners(corners, certain, columns, rows, RIGHT_PX)
    errors = corner_errors(found, truth)
    right = errors is not None and bool(errors.max() <= RIGHT_PX)
    return {
        "found": bool(found.found),
        "right": right,
        "wrong": bool(found.found) and not right,
        "worst_px": float(errors.max()) if right else None,
    }


def handed_over(found, corners, columns, shape):
    """Share of the visible true corners that a refusal holds, in order."""
    return share_in_order(found.partial, corners, columns, shape, RIGHT_PX)
