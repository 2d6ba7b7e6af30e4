"""The detectors of 3.3.2 by name, what they return, and when that is right."""

from chapters.shared.localiser_basin import HALF_WINDOWS
from chapters.shared.scoring import LOST_PX
from raxel.evaluation.board_scores import in_place
from raxel.features import find_board
from raxel.features.localise.subpix import opencv_subpix
from raxel.features.opencv import chessboard_corners, chessboard_corners_sb

CELECT, OPENCV = "celect", "findChessboardCorners"
OPENCV_SB, CLICKLESS = "findChessboardCornersSB", "raxel"
# CELECT on a picture whose tone curve is undone.
LINEAR = "celect-linear"
# SD on both axes of the clicks that the author made.
CLICK_SD_PX = 0.614
PRECISION_PX = 0.1


def returned(name, image, columns, rows):
    """Corners (N, 2) of a detector without clicks; None where it refuses.

    OpenCV's stand as they are returned: with adaptive threshold and normalised
    image, or sector-based, exhaustive and accurate. What is compared are whole
    boards: one that lacks corners counts as refused.
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
