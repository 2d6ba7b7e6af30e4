"""The pictures of 3.1.3's study, and how a localiser is scored on them."""

import numpy as np

from chapters.shared.localiser_basin import OTHERS, basin_image, basin_scores, off_by
from chapters.shared.synthetic_board import SyntheticBoard

SQUARES_PX = (50, 100, 150, 200)
BLUR_PX, NOISE_SD, START_SD_PX = 2.0, 4.0, 1.0


def neighbour_distances(board):
    """Mean distance (N,) of every corner to its neighbours in the lattice, px."""
    lattice = board.corners.reshape(board.rows, board.columns, 2)
    total = np.zeros(lattice.shape[:2])
    count = np.zeros(lattice.shape[:2])
    for axis in (0, 1):
        steps = np.linalg.norm(np.diff(lattice, axis=axis), axis=2)
        for side in (0, 1):
            place = [slice(None), slice(None)]
            place[axis] = slice(1, None) if side else slice(None, -1)
            total[tuple(place)] += steps
            count[tuple(place)] += 1
    return (total / count).ravel()


def study_image(square_px, rng):
    """Board, noisy image (H, W) float and starts (N, 2) of one trial of 3.1.3."""
    board = SyntheticBoard(square_px=square_px)
    image = board.image(BLUR_PX, NOISE_SD, rng).astype(float)
    noise = rng.normal(0, START_SD_PX, board.corners.shape)
    return board, image, board.corners + noise


def residuals(found, settled, start, truth):
    """Distance (N,) from the truth; where nothing was found, that of the start."""
    at = np.where(settled[:, None], found, start)
    return np.linalg.norm(at - truth, axis=1)


def basin_trial(condition, rng):
    """The other localisers from starts that are all off by the same distance."""
    image, truth = basin_image()
    start = off_by(condition["start_px"], truth, rng)
    return {
        name: basin_scores(function(image, start, **given), truth)
        for name, (function, given) in OTHERS.items()
    }
