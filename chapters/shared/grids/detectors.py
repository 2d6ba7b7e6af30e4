"""The detectors of 3.3.2 by name, what they return, and when that is right."""

from functools import lru_cache

import numpy as np

from chapters.shared.grids.synthetic_board import SyntheticBoard
from raxel.evaluation import in_place
from raxel.features import chessboard_corners, chessboard_corners_sb, find_board
from raxel.features.localise import opencv_subpix

CELECT, OPENCV = "celect", "findChessboardCorners"
OPENCV_SB, CLICKLESS = "findChessboardCornersSB", "raxel"
# CELECT on an image whose tone curve is undone.
LINEAR = "celect-linear"
# SD on both axes of the clicks that the author made.
CLICK_SD_PX = 0.614
PRECISION_PX = 0.1


def returned(name, image, columns, rows):
    """Corners (N, 2) of a detector without clicks; None if it rejects the image.

    OpenCV's corners are not refined: with adaptive threshold and normalised image,
    or sector-based, exhaustive and accurate. Whole boards are compared: one that
    lacks corners counts as rejected.
    """
    if name == CLICKLESS:
        seen = find_board(image, columns, rows)
        return seen.corners if seen.found and not seen.missing else None
    find = {OPENCV: chessboard_corners, OPENCV_SB: chessboard_corners_sb}
    return find[name](image, columns, rows)


def is_right(corners, truth):
    """Whether every corner (N, 2) is next to its own true one, within 8 px."""
    return in_place(corners, truth, LOST_PX)


def localised(image, corners, window="full window"):
    """Corners (N, 2) after OpenCV's cornerSubPix to 0.1 px; window: of HALF_WINDOWS."""
    return opencv_subpix(
        image, corners, HALF_WINDOWS[window], termination_px=PRECISION_PX
    )


# How far CELECT's corners are from the truth, and where a run was lost.


LOST_PX = 8.0


def scored(result, lattice):
    """Values of one CELECT run, against the true lattice (rows, columns, 2).

    A run succeeds if every corner is returned within 8 px (3.3.1).
    """
    if not result.found:
        return {"success": False}
    error = np.linalg.norm(result.corners - lattice, axis=2)
    if error.max() > LOST_PX:
        return {"success": False}
    return {
        "success": True,
        "max_px": float(error.max()),
        "mean_px": float(error.mean()),
    }


# The localisers of Fig. 3.11(f), and how far off a start they bring back.


# OpenCV's half widths of the 9 x 9 window: the printed 9 is its argument, or the width.
HALF_WINDOWS = {"half window": 9, "full window": 4}
LOCALISED_PX = 0.46
MAX_START_PX = 8
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
    trials = result.by("start_px").values()
    return np.array([of_start.column(window, "max_px").max() for of_start in trials])


def farthest_start(result, window):
    """Largest start error (px) up to which no corner of any trial is off."""
    good = largest_by_start(result, window) < LOCALISED_PX
    reached = len(good) if good.all() else int(np.argmin(good))
    return float(starts_of(result)[reached - 1]) if reached else 0.0


def worst_within(result, window):
    """Largest error (px) from starts that are at most 8 px off."""
    near = starts_of(result) <= MAX_START_PX
    return float(largest_by_start(result, window)[near].max())
