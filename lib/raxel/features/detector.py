"""The interface of every chessboard detector, and what all their answers go through."""

from typing import NamedTuple

import numpy as np

from raxel.errors import InputError
from raxel.features.lattice import lattice_fault, misfit, spacing, standard_order
from raxel.features.localise.subpix import opencv_subpix

# Grey levels as a camera stores them, and the light that they stand for.


START, SLOPE = 0.04045, 12.92
OFFSET, POWER = 0.055, 2.4


def undo_srgb(image):
    """An image (height, width) uint8 as it was before the tone curve of sRGB, uint8.

    0 and 255 stay what they are. The curve is that of IEC 61966-2-1: straight for dark
    levels, a power above them; eight bits leave few levels for the dark ones.
    """
    grey = np.arange(256) / 255
    light = np.where(
        grey <= START, grey / SLOPE, ((grey + OFFSET) / (1 + OFFSET)) ** POWER
    )
    return np.rint(255 * light).astype(np.uint8)[image]


SPAN_FOR_8_BIT = (0.1, 99.9)


class Partial(NamedTuple):
    """The part of a refused board that is in order.

    `corners` (M, 2) pixels (u, v); `indices` (M, 2) int: row and column of each on
    their lattice, counted from 0, with the first corner and the direction left open.
    """

    corners: np.ndarray
    indices: np.ndarray


class Detection(NamedTuple):
    """What a detector says about one image.

    `corners` (rows * columns, 2) float64 pixels (u, v), row by row, x along the
    columns, in the order of `lattice.standard_order`, NaN for a corner that is missing;
    (0, 2) where not found. `reason` says why not, in a few words. `sd` (rows *
    columns,) px: standard deviation of each corner, by the rule of
    `raxel.sets.model`; None where a detector gives none. `partial`: what is in
    order of a refused board, None where there is nothing. `complete`: sizes (columns,
    rows) of the boards seen, where several are a reason to refuse.
    """

    found: bool
    corners: np.ndarray
    columns: int | None
    rows: int | None
    reason: str = ""
    sd: np.ndarray | None = None
    partial: Partial | None = None
    complete: tuple = ()

    @property
    def missing(self):
        """Number of corners that the board lacks."""
        return int(np.count_nonzero(np.isnan(self.corners[:, 0])))


def refused(columns, rows, reason):
    """The answer of a detector that has no board to show."""
    return Detection(False, np.empty((0, 2)), columns, rows, reason)


def verified(corners, columns, rows, image):
    """A Detection of these corners, refused where they are no chessboard lattice.

    `corners` (rows * columns, 2) in any order that is row by row.
    """
    corners = np.asarray(corners, dtype=float).reshape(-1, 2)
    fault = lattice_fault(corners, columns, rows, image)
    if fault:
        return refused(columns, rows, f"what was found is no lattice: {fault}")
    order = standard_order(corners, columns, rows, image)
    return Detection(True, corners[order], columns, rows)


def as_8_bit(image):
    """Grey (height, width) as uint8; deeper images are stretched over their range.

    Raises InputError for an array of another shape, as that of a colour picture.
    """
    if image.ndim != 2:
        raise InputError(
            f"image: found an array of shape {image.shape}; give grey, (height, width)"
        )
    if image.dtype == np.uint8:
        return image
    low, high = np.percentile(image, SPAN_FOR_8_BIT)
    stretched = (image - low) * (255 / max(high - low, 1))
    return np.clip(np.rint(stretched), 0, 255).astype(np.uint8)


# OpenCV's two chessboard detectors, brought to sub-pixel by one refinement. Both are
# refined by cornerSubPix, also the sector-based one with its own sub-pixel step: on
# drawn boards of 640 x 480 px with bend and noise its largest errors are 0.3 to 1 px
# without and 0.1 to 0.3 px with refinement, its medians fall by a quarter to a half.


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
