"""Images of the study of 3.1.3, and the residual of a localiser."""

import numpy as np

from chapters.shared.grids import SyntheticBoard

SQUARES_PX = (50, 100, 150, 200)
BLUR_PX, NOISE_SD, START_SD_PX = 2.0, 4.0, 1.0


def neighbour_distances(board):
    """Mean distance (N,) in px of each corner to its neighbours in the lattice."""
    total, count = np.zeros((2, board.rows, board.columns))
    for axis in (0, 1):
        steps = np.linalg.norm(np.diff(board.lattice, axis=axis), axis=2)
        # Both ends of each step.
        for end in (slice(None, -1), slice(1, None)):
            place = (end, slice(None)) if axis == 0 else (slice(None), end)
            total[place] += steps
            count[place] += 1
    return (total / count).ravel()


def study_image(square_px, rng):
    """Board, noisy image (H, W) float and starts (N, 2) of one trial of 3.1.3."""
    board = SyntheticBoard(square_px=square_px)
    image = board.image(BLUR_PX, NOISE_SD, rng).astype(float)
    noise = rng.normal(0, START_SD_PX, board.corners.shape)
    return board, image, board.corners + noise


def residuals(found, settled, start, truth):
    """Distance (N,) from the truth, that of the start for failed corners."""
    at = np.where(settled[:, None], found, start)
    return np.linalg.norm(at - truth, axis=1)


def settled_residuals(found, start, board, shape=(-1,)):
    """Residuals (N, *shape) of every setting, and the share (shape) of convergence.

    found: (corners (N, 2), settled (N,)) of each setting.
    """
    errors = [residuals(*one, start, board.corners) for one in found]
    errors = np.stack(errors, axis=-1).astype(np.float32)
    return {
        "error": errors.reshape(len(errors), *shape),
        "distance": neighbour_distances(board),
        "converged": np.reshape([settled.mean() for _, settled in found], shape),
    }
