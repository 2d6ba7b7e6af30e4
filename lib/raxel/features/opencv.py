"""OpenCV's two chessboard detectors, brought to sub-pixel by one refinement.

Both are refined by cornerSubPix, also the sector-based one with its own sub-pixel
step: on drawn boards of 640 x 480 px with bend and noise its largest errors are 0.3 to
1 px without and 0.1 to 0.3 px with refinement, its medians fall by a quarter to a half.
"""

import numpy as np

from raxel.features.detector import as_8_bit, refused, verified
from raxel.features.lattice import misfit, spacing
from raxel.features.localise.subpix import opencv_subpix

WINDOW_IN_STEPS = 0.35
SMALLEST_WINDOW, LARGEST_WINDOW = 2, 8
STILL_PX = 1e-3
RESTART_MISFIT, RESTARTS = 0.12, 3
LEAST_COUNT = 3
# cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE
PLAIN_FLAGS = 1 | 2
# cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY
SECTOR_FLAGS = 16 | 32
SECTOR_SEED = 0
NOT_FOUND = "OpenCV found no board of {} x {} interior corners"


def chessboard_corners(image, columns, rows, flags=PLAIN_FLAGS):
    """Corners as cv2.findChessboardCorners returns them; None where it has no board.

    `image` (height, width) uint8 or uint16; `columns` and `rows` count interior
    corners, `flags` are OpenCV's. Returns (rows * columns, 2) float64 pixels (u, v),
    row by row, from whichever corner OpenCV begins with.
    """
    import cv2

    size = columns, rows
    found, corners = cv2.findChessboardCorners(as_8_bit(image), size, flags=flags)
    return _all_of(found, corners, size)


def chessboard_corners_sb(image, columns, rows, flags=SECTOR_FLAGS):
    """Corners as cv2.findChessboardCornersSB, the sector-based one, returns them.

    As `chessboard_corners`. It sorts its candidates by k-means from random starts; they
    are the same for every picture here, so that no answer hangs on what ran before.
    """
    import cv2

    size = columns, rows
    cv2.setRNGSeed(SECTOR_SEED)
    found, corners = cv2.findChessboardCornersSB(as_8_bit(image), size, flags=flags)
    return _all_of(found, corners, size)


def _all_of(found, corners, size):
    if not found or len(corners) != size[0] * size[1]:
        return None
    return np.asarray(corners, dtype=float).reshape(-1, 2)


def find_opencv(image, columns, rows):
    """findChessboardCorners (adaptive threshold, normalised image), then refined.

    `image` (height, width) uint8 or uint16; `columns` and `rows` count interior
    corners and must be known. Returns a Detection.
    """
    if columns is None or rows is None:
        reason = "this detector needs target.columns and target.rows; try opencv-sb"
        return refused(columns, rows, reason)
    corners = chessboard_corners(image, columns, rows)
    return _refined_and_verified(corners, columns, rows, image)


def find_opencv_sb(image, columns, rows):
    """findChessboardCornersSB (exhaustive, accurate), then refined.

    As `find_opencv`; where the counts are unknown the largest board is taken, its
    longer side as columns.
    """
    if columns is None or rows is None:
        return _largest_board(image)
    corners = chessboard_corners_sb(image, columns, rows)
    return _refined_and_verified(corners, columns, rows, image)


def _largest_board(image):
    import cv2

    flags = SECTOR_FLAGS | cv2.CALIB_CB_LARGER
    found, corners, marks = cv2.findChessboardCornersSBWithMeta(
        as_8_bit(image), (LEAST_COUNT, LEAST_COUNT), flags=flags
    )
    if not found:
        return refused(None, None, "OpenCV found no board of any size")
    rows, columns = marks.shape[:2]
    lattice = np.asarray(corners, float).reshape(rows, columns, 2)
    if rows > columns:
        lattice = lattice.transpose(1, 0, 2)
    rows, columns = lattice.shape[:2]
    return _refined_and_verified(lattice.reshape(-1, 2), columns, rows, image)


def _refined_and_verified(corners, columns, rows, image):
    if corners is None or not np.isfinite(corners).all():
        return refused(columns, rows, NOT_FOUND.format(columns, rows))
    return verified(refine(image, corners, columns, rows), columns, rows, image)


def refine(image, corners, columns, rows):
    """Corners moved to the saddle of the grey values nearby, (rows * columns, 2).

    Each window reaches about a third of the way to the nearest neighbour, so that it
    holds one saddle only. A corner that is then out of line starts again from where
    its neighbours put it, and keeps that only if it ends up better in line.
    """
    corners = _at_saddles(image, corners, spacing(corners, columns, rows))
    for _ in range(RESTARTS):
        off, prediction = misfit(corners, columns, rows)
        again = off > RESTART_MISFIT
        if not again.any():
            break
        trial = np.where(again[:, None], prediction, corners)
        trial = _at_saddles(image, trial, spacing(corners, columns, rows))
        better = again & (misfit(trial, columns, rows)[0] < off)
        corners = np.where(better[:, None], trial, corners)
    return corners


def _at_saddles(image, corners, steps):
    """cornerSubPix, in groups of corners that share a window."""
    grey = image if image.dtype == np.uint8 else image.astype(np.float32)
    height, width = image.shape
    inside = np.all((corners >= 0) & (corners <= (width - 1, height - 1)), axis=1)
    half = np.clip(WINDOW_IN_STEPS * steps, SMALLEST_WINDOW, LARGEST_WINDOW).astype(int)
    moved = corners.copy()
    for window in np.unique(half[inside]):
        group = inside & (half == window)
        at = opencv_subpix(grey, corners[group], int(window), termination_px=STILL_PX)
        moved[group] = at
    return moved
