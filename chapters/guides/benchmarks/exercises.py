"""What the exercise of the page of benchmarks compares an answer with."""

import numpy as np

from raxel.evaluation.benchmark import corner_errors
from raxel.features.detector import Detection
from raxel.sets import Chessboard
from raxel.sets.reference import ReferenceCorners


def shift_task():
    """Every corner is off by the same distance, the hypotenuse of 0.3 and 0.4 px."""
    return {
        "expected": shift_rms,
        "hint": "the distance of each corner, not of each coordinate",
        "slips": {"That is per coordinate.": lambda: shift_rms() / np.sqrt(2)},
    }


def shift_rms():
    """RMS error in px of a board whose corners are all shifted alike."""
    board = Chessboard(7, 5, 30.0)
    corners, everywhere = board.points(), np.ones(35, bool)
    truth = ReferenceCorners(corners, everywhere, 7, 5, 1.0)
    errors = corner_errors(Detection(True, corners + [0.3, 0.4], 7, 5), truth)
    return float(np.sqrt(np.mean(errors**2)))
