"""Requests to the detectors, and scores of their results."""

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


def scored(found, corners, columns, rows):
    """Return {found, right, wrong, worst_px} of a Detection."""
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
    """Return the share of visible true corners that a rejection reports in order."""
    return share_in_order(found.partial, corners, columns, shape, RIGHT_PX)
