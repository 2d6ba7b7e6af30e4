"""Corners of both boards in rendered images, and redrawn for further runs."""

from functools import partial

import numpy as np

from chapters.ch04_central_generic.s3_4_motion.trials.calibrations import (
    LATTICE_PX,
    LINEAR_GRIDS,
    THRESHOLD_MM,
)
from chapters.ch04_central_generic.s3_4_motion.trials.stage import (
    BOARDS,
    RIG,
    RIG_FILES,
    SETTINGS,
    STEPS,
    Setup,
    drawn_setup,
    photograph,
    target_poses,
    true_pixels,
)
from chapters.shared.decoding_errors import DecodingErrors
from chapters.shared.grid_detectors import CLICK_SD_PX, CLICKLESS, returned
from chapters.shared.lattices import clockwise, outer
from chapters.shared.rigs import rig_named
from raxel.errors import InputError
from raxel.features.celect.clicked import find_celect
from raxel.features.opencv import refine
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

DETECTORS = ("CELECT", "without clicks")
SWEPT_DETECTOR = "CELECT"  # along the sweep of the noise level


def by_celect(picture, board, lattice, rng):
    """Return corners (N, 2) from four clicks on the board, None if rejected.

    lattice: true corners (rows, columns, 2), which the user clicks.
    """
    clicks = outer(clockwise(lattice))
    clicks = clicks + CLICK_SD_PX * rng.standard_normal(clicks.shape)
    try:
        found = find_celect(picture, board.columns, board.rows, clicks)
    except InputError:
        return None
    return in_order(found.corners, lattice) if found.found else None


def by_hand(picture, board, lattice, rng):
    """Return corners (N, 2) clicked one by one, then refined."""
    clicks = lattice.reshape(-1, 2)
    clicks = clicks + CLICK_SD_PX * rng.standard_normal(clicks.shape)
    return refine(picture, clicks, board.columns, board.rows)


def without_clicks(picture, board, lattice):
    """Return corners (N, 2) by the detector of whole boards, None if rejected."""
    found = returned(CLICKLESS, picture, board.columns, board.rows)
    return None if found is None else in_order(found, lattice)


def in_order(found, lattice):
    """Return corners (N, 2) in the order of the board, which is given by hand.

    A mirror image does not determine the orientation of a board.
    """
    found = np.asarray(found).reshape(lattice.shape)
    ways = [found[::r, ::c] for r in (1, -1) for c in (1, -1)]
    gaps = [np.linalg.norm(way - lattice, axis=2).mean() for way in ways]
    return ways[int(np.argmin(gaps))].reshape(-1, 2)


def detected_boards(poses, rng):
    """Return errors and rejections of the detectors on the target in poses (n, 4, 4).

    errors: {detector: a list for each board of (n, N, 2) px}; boards that a detector
    rejects are clicked by hand. refused: {detector: (n, boards) bool}.
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


DECODED = {"quick": "onevr-d70-small", "full": "onevr-d70"}
RENDERED = {"quick": 1, "full": 3}
# Quick builds render every n-th image, which represents those up to the next.
EVERY = {"quick": 5, "full": 1}
MEASURED = "table_4_3_errors", "fig_4_10_corners"


def corner_trial(condition, rng, every):
    """Return corner errors and rejections of one run, in images of one motion."""
    setup = drawn_setup(rng)
    poses = target_poses(condition["motion"], setup)[::every]
    errors, refused = detected_boards(poses, rng)
    return {
        "turn": setup.turn,
        "shift": setup.shift,
        "errors": {
            name: {str(k): e for k, e in enumerate(of_boards)}
            for name, of_boards in errors.items()
        },
        "refused": refused,
    }


@experiment(
    "fig_4_10_corners", artefact="fig_4_10", shards={"full": 2}, inputs=RIG_FILES
)
def corners(effort):
    """Plan corners of the target in rendered images, by both detectors."""
    trial = partial(corner_trial, every=EVERY[effort])
    return Plan(trial, crossed(motion=STEPS), RENDERED[effort], SETTINGS)


class MeasuredCorners:
    """Corner errors of the rendered runs, to be redrawn.

    An error has a part common to all runs, which depends on the position, and a
    residual. A redrawn corner has the first, and the residual of any corner of its
    board and image.
    """

    def __init__(self, result, every):
        self.every = every
        self.errors, self.setups = {}, {}
        for motion in STEPS:
            stood = (result.arrays(name, motion=motion) for name in ("turn", "shift"))
            self.setups[motion] = [Setup(*one) for one in zip(*stood, strict=True)]
            for name in DETECTORS:
                self.errors[motion, name] = [
                    np.stack(result.arrays(f"errors.{name}.{k}", motion=motion))
                    for k in range(len(BOARDS))
                ]

    def setup(self, motion, seed, rng):
        """Return the Setup of the target in a rendered run, or a new one (None)."""
        return drawn_setup(rng) if seed is None else self.setups[motion][seed]

    def of_seed(self, motion, name, seed, rng):
        """Return errors (images, corners, 2) px, both boards, of a rendered run,
        or redrawn (None)."""
        if seed is None:
            return self._redrawn(motion, name, rng)
        return np.concatenate(
            [self._all(e[seed], motion) for e in self.errors[motion, name]], axis=1
        )

    def _redrawn(self, motion, name, rng):
        boards = []
        for errors in self.errors[motion, name]:
            shared, own = errors.mean(axis=0), errors[0]
            if len(errors) > 1:
                own = (errors - shared) * np.sqrt(len(errors) / (len(errors) - 1))
                own = own[rng.integers(len(own))]
            else:
                shared = np.zeros_like(shared)
            order = rng.permuted(
                np.broadcast_to(np.arange(own.shape[1]), own.shape[:2]), axis=1
            )
            own = np.take_along_axis(own, order[..., None], axis=1)
            boards.append(self._all(shared + own, motion))
        return np.concatenate(boards, axis=1)

    def _all(self, errors, motion):
        """Return errors of all images, if not rendered those of the last rendered."""
        return errors[np.arange(STEPS[motion] + 1) // self.every]


def measured(results, effort):
    """Return (MeasuredCorners, DecodingErrors) of the rendered images."""
    decoded = DecodingErrors.by_rig(results["table_4_3_errors"])[DECODED[effort]]
    return MeasuredCorners(results["fig_4_10_corners"], EVERY[effort]), decoded


CALIBRATION = {
    "lattice_px": LATTICE_PX,
    "linear_grids": LINEAR_GRIDS,
    "ransac_threshold_mm": THRESHOLD_MM,
}
