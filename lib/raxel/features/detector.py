"""The interface of every chessboard detector, and the verification of their results."""

from __future__ import annotations

from typing import NamedTuple

import cv2
import numpy as np
from numpy.typing import NDArray

from raxel.errors import InputError
from raxel.features.lattice import lattice_fault, misfit, spacing, standard_order
from raxel.features.localise.subpix import opencv_subpix

# The sRGB tone curve.


SRGB_LINEAR_END, SRGB_LINEAR_SLOPE = 0.04045, 12.92
SRGB_OFFSET, SRGB_POWER = 0.055, 2.4


def undo_srgb(image: NDArray[np.uint8]) -> NDArray[np.uint8]:
    """Return the linear light of an image with the tone curve of sRGB.

    The curve is that of IEC 61966-2-1: straight for dark levels, a power above them.
    0 and 255 are unchanged. Eight bits leave few levels for the dark ones.

    Parameters
    ----------
    image : NDArray[np.uint8]
        (height, width) grey levels as the camera stores them.

    Returns
    -------
    NDArray[np.uint8]
        (height, width) levels proportional to light.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.features import undo_srgb
    >>> undo_srgb(np.array([[0, 128, 255]], np.uint8)).tolist()
    [[0, 55, 255]]
    """
    grey = np.arange(256) / 255
    light = np.where(
        grey <= SRGB_LINEAR_END,
        grey / SRGB_LINEAR_SLOPE,
        ((grey + SRGB_OFFSET) / (1 + SRGB_OFFSET)) ** SRGB_POWER,
    )
    return np.rint(255 * light).astype(np.uint8)[image]


STRETCH_PERCENTILES = (0.1, 99.9)


class Partial(NamedTuple):
    """Hold the part of a rejected board that is in order.

    Attributes
    ----------
    corners : np.ndarray
        (M, 2) pixels (u, v).
    indices : np.ndarray
        (M, 2) int: row and column of each corner on its lattice, counted from 0. The
        first corner and the direction are undetermined.
    """

    corners: np.ndarray
    indices: np.ndarray


class Detection(NamedTuple):
    """Hold the answer of a detector for one image.

    Attributes
    ----------
    found : bool
        Whether the board was detected.
    corners : np.ndarray
        (rows * columns, 2) float64 pixels (u, v), row by row, x along the columns, in
        the order of `lattice.standard_order`. NaN for a missing corner; (0, 2) where
        the board was not found.
    columns, rows : int or None
        Numbers of interior corners; None where unknown.
    reason : str
        Why the board was not found, in a few words.
    sd : np.ndarray or None
        (rows * columns,) px: predicted standard deviation of each corner, by the rule
        of `raxel.sets.model`. None where a detector gives none.
    partial : Partial or None
        The ordered part of a rejected board, or None.
    complete : tuple
        Sizes (columns, rows) of the detected boards, where several are a reason to
        reject.
    other_target : bool
        Whether `reason` names another target that the image shows.
    """

    found: bool
    corners: np.ndarray
    columns: int | None
    rows: int | None
    reason: str = ""
    sd: np.ndarray | None = None
    partial: Partial | None = None
    complete: tuple = ()
    other_target: bool = False

    @property
    def missing(self) -> int:
        """Return the number of corners that the board lacks."""
        return int(np.count_nonzero(np.isnan(self.corners[:, 0])))


def rejected(columns, rows, reason):
    """The Detection of a detector that found no board."""
    return Detection(False, np.empty((0, 2)), columns, rows, reason)


def verified(corners, columns, rows, image):
    """A Detection of these corners, rejected where they are not a chessboard lattice.

    `corners` (rows * columns, 2) in any order that is row by row.
    """
    corners = np.asarray(corners, dtype=float).reshape(-1, 2)
    fault = lattice_fault(corners, columns, rows, image)
    if fault:
        return rejected(
            columns, rows, f"the detected corners are not a lattice: {fault}"
        )
    order = standard_order(corners, columns, rows, image)
    return Detection(True, corners[order], columns, rows)


def as_8_bit(image: np.ndarray) -> NDArray[np.uint8]:
    """Return a grey image as uint8; stretch deeper images over their range.

    Parameters
    ----------
    image : np.ndarray
        (height, width) grey levels. An image of uint8 is returned as it is.

    Returns
    -------
    NDArray[np.uint8]
        (height, width) grey levels.

    Raises
    ------
    InputError
        `bad-input` for an array of another shape, as that of a colour image.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.features import as_8_bit
    >>> as_8_bit(np.array([[0, 65535]], np.uint16)).tolist()
    [[0, 255]]
    """
    if image.ndim != 2:
        raise InputError(
            f"image: found an array of shape {image.shape}; give grey levels "
            "(height, width)"
        )
    if image.dtype == np.uint8:
        return image
    low, high = np.percentile(image, STRETCH_PERCENTILES)
    stretched = (image - low) * (255 / max(high - low, 1))
    return np.clip(np.rint(stretched), 0, 255).astype(np.uint8)


# OpenCV's two chessboard detectors, refined by cornerSubPix. This includes the
# sector-based one with its own sub-pixel step. On rendered boards of 640 x 480 px with
# bend and noise its largest errors are 0.3 to 1 px without and 0.1 to 0.3 px with
# refinement; its medians fall by a quarter to a half.


HALF_WINDOW_STEPS = 0.35
MIN_HALF_WINDOW_PX, MAX_HALF_WINDOW_PX = 2, 8
STEP_TOL_PX = 1e-3
RESTART_MISFIT_STEPS, MAX_RESTARTS = 0.12, 3
MIN_N_CORNERS = 3
# cv2.CALIB_CB_ADAPTIVE_THRESH | cv2.CALIB_CB_NORMALIZE_IMAGE
PLAIN_FLAGS = 1 | 2
# cv2.CALIB_CB_EXHAUSTIVE | cv2.CALIB_CB_ACCURACY
SECTOR_FLAGS = 16 | 32
SECTOR_SEED = 0
NOT_FOUND = "OpenCV found no board of {} x {} interior corners"


def chessboard_corners(
    image: np.ndarray, columns: int, rows: int, flags: int = PLAIN_FLAGS
) -> NDArray[np.float64] | None:
    """Return the corners of cv2.findChessboardCorners, or None without a board.

    Parameters
    ----------
    image : np.ndarray
        (height, width) grey levels, uint8 or uint16.
    columns, rows : int
        Numbers of interior corners.
    flags : int
        Flags of OpenCV.

    Returns
    -------
    NDArray[np.float64] or None
        (rows * columns, 2) pixels (u, v), row by row, from the corner with which OpenCV
        begins. None where OpenCV finds no board.
    """
    size = columns, rows
    found, corners = cv2.findChessboardCorners(as_8_bit(image), size, flags=flags)
    return _all_of(found, corners, size)


def chessboard_corners_sb(
    image: np.ndarray, columns: int, rows: int, flags: int = SECTOR_FLAGS
) -> NDArray[np.float64] | None:
    """Return the corners of cv2.findChessboardCornersSB, the sector-based detector.

    OpenCV sorts its candidates by k-means from random starts. The starts are the same
    for every image here, so that no answer depends on earlier calls.

    Parameters
    ----------
    image : np.ndarray
        (height, width) grey levels, uint8 or uint16.
    columns, rows : int
        Numbers of interior corners.
    flags : int
        Flags of OpenCV.

    Returns
    -------
    NDArray[np.float64] or None
        As of `chessboard_corners`.
    """
    size = columns, rows
    cv2.setRNGSeed(SECTOR_SEED)
    found, corners = cv2.findChessboardCornersSB(as_8_bit(image), size, flags=flags)
    return _all_of(found, corners, size)


def _all_of(found, corners, size):
    if not found or len(corners) != size[0] * size[1]:
        return None
    return np.asarray(corners, dtype=float).reshape(-1, 2)


def find_opencv(image: np.ndarray, columns: int | None, rows: int | None) -> Detection:
    """Detect a chessboard by cv2.findChessboardCorners and refine its corners.

    OpenCV uses its adaptive threshold and a normalised image.

    Parameters
    ----------
    image : np.ndarray
        (height, width) grey levels, uint8 or uint16.
    columns, rows : int or None
        Numbers of interior corners. They must be known: without them the result is a
        rejected Detection.

    Returns
    -------
    Detection
        The board, or the reason for its rejection.

    Examples
    --------
    >>> import numpy as np
    >>> from raxel.features import find_opencv
    >>> squares = np.indices((5, 6)).sum(axis=0) % 2
    >>> board = np.kron(squares, np.ones((30, 30)))
    >>> image = np.pad(255 * board, 40, constant_values=255).astype(np.uint8)
    >>> found = find_opencv(image, 5, 4)
    >>> found.found, found.corners.shape, found.missing
    (True, (20, 2), 0)
    """
    if columns is None or rows is None:
        reason = "this detector requires target.columns and target.rows; use opencv-sb"
        return rejected(columns, rows, reason)
    corners = chessboard_corners(image, columns, rows)
    return _refined_and_verified(corners, columns, rows, image)


def find_opencv_sb(
    image: np.ndarray, columns: int | None, rows: int | None
) -> Detection:
    """Detect a chessboard by cv2.findChessboardCornersSB and refine its corners.

    OpenCV uses its exhaustive search and its accurate mode.

    Parameters
    ----------
    image : np.ndarray
        (height, width) grey levels, uint8 or uint16.
    columns, rows : int or None
        Numbers of interior corners. Where they are unknown, the largest board is taken,
        its longer side as columns.

    Returns
    -------
    Detection
        The board, or the reason for its rejection.
    """
    if columns is None or rows is None:
        return _largest_board(image)
    corners = chessboard_corners_sb(image, columns, rows)
    return _refined_and_verified(corners, columns, rows, image)


def _largest_board(image):
    flags = SECTOR_FLAGS | cv2.CALIB_CB_LARGER
    found, corners, marks = cv2.findChessboardCornersSBWithMeta(
        as_8_bit(image), (MIN_N_CORNERS, MIN_N_CORNERS), flags=flags
    )
    if not found:
        return rejected(None, None, "OpenCV found no board of any size")
    rows, columns = marks.shape[:2]
    lattice = np.asarray(corners, float).reshape(rows, columns, 2)
    if rows > columns:
        lattice = lattice.transpose(1, 0, 2)
    rows, columns = lattice.shape[:2]
    return _refined_and_verified(lattice.reshape(-1, 2), columns, rows, image)


def _refined_and_verified(corners, columns, rows, image):
    if corners is None or not np.isfinite(corners).all():
        return rejected(columns, rows, NOT_FOUND.format(columns, rows))
    return verified(refine(image, corners, columns, rows), columns, rows, image)


def refine(
    image: np.ndarray, corners: np.ndarray, columns: int, rows: int
) -> NDArray[np.float64]:
    """Return corners moved to the saddle of the grey levels nearby.

    Each window reaches about a third of the way to the nearest neighbour, so that it
    holds one saddle only. A corner that is then out of line starts again from the
    position that its neighbours predict. It keeps the new position only if that is
    better in line.

    Parameters
    ----------
    image : np.ndarray
        (height, width) grey levels.
    corners : np.ndarray
        (rows * columns, 2) pixels (u, v), row by row.
    columns, rows : int
        Numbers of interior corners.

    Returns
    -------
    NDArray[np.float64]
        (rows * columns, 2) pixels (u, v).
    """
    corners = _at_saddles(image, corners, spacing(corners, columns, rows))
    for _ in range(MAX_RESTARTS):
        error, prediction = misfit(corners, columns, rows)
        restarted = error > RESTART_MISFIT_STEPS
        if not restarted.any():
            break
        trial = np.where(restarted[:, None], prediction, corners)
        trial = _at_saddles(image, trial, spacing(corners, columns, rows))
        better = restarted & (misfit(trial, columns, rows)[0] < error)
        corners = np.where(better[:, None], trial, corners)
    return corners


def _at_saddles(image, corners, steps):
    """cornerSubPix, in groups of corners that share a window size."""
    grey = image if image.dtype == np.uint8 else image.astype(np.float32)
    height, width = image.shape
    inside = np.all((corners >= 0) & (corners <= (width - 1, height - 1)), axis=1)
    half = np.clip(
        HALF_WINDOW_STEPS * steps, MIN_HALF_WINDOW_PX, MAX_HALF_WINDOW_PX
    ).astype(int)
    moved = corners.copy()
    for window in np.unique(half[inside]):
        group = inside & (half == window)
        moved[group] = opencv_subpix(
            grey, corners[group], int(window), termination_px=STEP_TOL_PX
        )
    return moved
