"""Corners of both boards in rendered pictures, by CELECT and without clicks."""

import numpy as np

from chapters.ch04_central_generic.s3_4_motion.trials.stage import (
    BOARDS,
    RIG,
    photograph,
    true_pixels,
)
from chapters.shared.grid_detectors import CLICK_SD_PX, CLICKLESS, returned
from chapters.shared.lattices import clockwise, outer
from chapters.shared.rigs import rig_named
from raxel.errors import InputError
from raxel.features.celect.clicked import find_celect
from raxel.features.opencv import refine

DETECTORS = ("CELECT", "without clicks")
SWEPT_DETECTOR = "CELECT"  # along the sweep of the bench's noise


def by_celect(picture, board, lattice, rng):
    """Corners (N, 2) from four clicks on the board, None where it refuses.

    lattice: true corners (rows, columns, 2), which a person who clicks sees.
    """
    clicks = outer(clockwise(lattice))
    clicks = clicks + CLICK_SD_PX * rng.standard_normal(clicks.shape)
    try:
        found = find_celect(picture, board.columns, board.rows, clicks)
    except InputError:
        return None
    return in_order(found.corners, lattice) if found.found else None


def by_hand(picture, board, lattice, rng):
    """Corners (N, 2) that a person clicks one by one, then refined."""
    clicks = lattice.reshape(-1, 2)
    clicks = clicks + CLICK_SD_PX * rng.standard_normal(clicks.shape)
    return refine(picture, clicks, board.columns, board.rows)


def without_clicks(picture, board, lattice):
    """Corners (N, 2) by the detector of whole boards, None where it refuses."""
    found = returned(CLICKLESS, picture, board.columns, board.rows)
    return None if found is None else in_order(found, lattice)


def in_order(found, lattice):
    """Corners (N, 2) in the order of the board, which is told by hand.

    A picture in a mirror leaves open which way round a board is seen.
    """
    found = np.asarray(found).reshape(lattice.shape)
    ways = [found[::r, ::c] for r in (1, -1) for c in (1, -1)]
    gaps = [np.linalg.norm(way - lattice, axis=2).mean() for way in ways]
    return ways[int(np.argmin(gaps))].reshape(-1, 2)


def seen_boards(poses, rng):
    """Errors and refusals of the detectors on the target in poses (n, 4, 4).

    errors: {detector: a list for each board of (n, N, 2) px}; what a detector
    refuses is clicked by hand. refused: {detector: (n, boards) bool}.
    """
    camera = rig_named(RIG).camera
    errors = {
        name: [np.empty((len(poses), b.columns * b.rows, 2)) for b in BOARDS]
        for name in DETECTORS
    }
    refused = {name: np.zeros((len(poses), len(BOARDS)), bool) for name in DETECTORS}
    for index, T in enumerate(poses):
        picture, first = photograph(T, rng)
        seen = zip(BOARDS, true_pixels(camera, T), strict=True)
        for k, (board, true) in enumerate(seen):
            lattice = (true - first).reshape(board.rows, board.columns, 2)
            found = {
                "CELECT": by_celect(picture, board, lattice, rng),
                "without clicks": without_clicks(picture, board, lattice),
            }
            clicked = by_hand(picture, board, lattice, rng)
            for name, corners in found.items():
                refused[name][index, k] = corners is None
                corners = clicked if corners is None else corners
                errors[name][k][index] = corners - (true - first)
    return errors, refused
