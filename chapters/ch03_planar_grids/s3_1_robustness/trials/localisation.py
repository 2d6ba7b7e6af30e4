"""Trials of the localisers: parameters of 3.1.3, and the basin of Fig. 3.11(f)."""

from __future__ import annotations

from functools import lru_cache

import numpy as np

from chapters.shared.synthetic_board import SIZE_PX, Board
from raxel.features.localise import (
    corner_subpix,
    derivative,
    saddle_point,
)
from raxel.features.localise.ridges import fit_ridges, gradient
from raxel.features.localise.saddle import blurred, fit_saddles
from repro.run.experiment import experiment
from repro.run.outcomes import Plan

SQUARES_PX = (50, 100, 150, 200)
BLUR_PX, NOISE_SD, START_SD_PX = 2.0, 4.0, 1.0

# OpenCV's half widths of the 9 x 9 window, in both readings.
HALF_WINDOWS = {"full window": 4, "half window": 9}
START_ERRORS_PX = (0, 1, 2, 3, 4, 5, 6, 7, 8, 9, 10, 12)
BASIN_TRIALS = {"quick": 2, "full": 50}
BASIN_QUICK = (0, 4, 8)
BASIN_BLUR_PX = 1.0
TERMINATION_PX = 0.1
OTHERS = {
    "saddle point": (saddle_point, {"window": 19, "blur_sd": 2.0}),
    "derivative": (derivative, {"window": 19}),
}


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
    board = Board(square_px=square_px)
    image = board.image(BLUR_PX, NOISE_SD, rng).astype(float)
    noise = rng.normal(0, START_SD_PX, board.corners.shape)
    return board, image, board.corners + noise


def residuals(found, settled, start, truth):
    """Distance (N,) from the truth; where nothing was found, that of the start."""
    at = np.where(settled[:, None], found, start)
    return np.linalg.norm(at - truth, axis=1)


def derivative_trial(condition, rng):
    """Residual of every corner with every window: (N, windows)."""
    board, image, start = study_image(condition["square_px"], rng)
    slopes = gradient(image)
    errors, share = [], []
    for window in condition["windows"]:
        ridges, settled = fit_ridges(slopes, start, window)
        errors.append(
            residuals(ridges[:, :2], settled, start, board.corners)
        )
        share.append(settled.mean())
    return {
        "error": np.stack(errors, axis=-1).astype(np.float32),
        "distance": neighbour_distances(board),
        "converged": np.array(share),
    }


def saddle_trial(condition, rng):
    """Residual of every corner with every window and blur: (N, windows, blurs)."""
    board, image, start = study_image(condition["square_px"], rng)
    errors, share = [], []
    for blur in condition["blurs"]:
        soft = blurred(image, blur)
        for window in condition["windows"]:
            found, settled = fit_saddles(soft, start, window)
            errors.append(residuals(found, settled, start, board.corners))
            share.append(settled.mean())
    shape = len(condition["blurs"]), len(condition["windows"])
    errors = np.stack(errors, axis=-1).astype(np.float32)
    errors = errors.reshape(len(errors), *shape).transpose(0, 2, 1)
    return {
        "error": errors,
        "distance": neighbour_distances(board),
        "converged": np.reshape(share, shape).T,
    }


def spread_trial(condition, rng):
    """Errors of a localiser beside the standard deviations that it states.

    What is left without noise is its bias.
    """
    board, image, start = study_image(condition["square_px"], rng)
    image, clean = image.astype(np.uint8), board.image(BLUR_PX)
    functions = {
        "saddle point": saddle_point,
        "derivative": derivative,
        "OpenCV": corner_subpix,
    }
    found = {}
    for name, function in functions.items():
        result, without = function(image, start), function(clean, start)
        good = result.converged
        error = (result.corners - board.corners)[good]
        bias = (without.corners - board.corners)[good & without.converged]
        stated = result.sd[good, None]
        found[name] = {
            "converged": float(good.mean()),
            "rms_px": float(np.sqrt(np.mean(error**2))),
            "sd_px": float(np.sqrt(np.mean(stated**2))),
            "bias_px": float(np.sqrt(np.mean(bias**2))),
            "score_sd": float(np.sqrt(np.mean((error / stated) ** 2))),
            "within": float(np.mean(np.abs(error) < stated)),
        }
    return found


@lru_cache(maxsize=1)
def basin_image():
    """The image of Fig. 3.10(b), and its true corners (N, 2)."""
    board = Board()
    return board.image(BASIN_BLUR_PX), board.corners


def basin_trial(condition, rng):
    """Localisation from starts that are all off by the same distance."""
    image, truth = basin_image()
    angle = rng.uniform(0, 2 * np.pi, len(truth))
    away = np.column_stack([np.cos(angle), np.sin(angle)])
    start = truth + condition["start_px"] * away
    found = {
        name: corner_subpix(
            image, start, half_window=half, termination_px=TERMINATION_PX
        )
        for name, half in HALF_WINDOWS.items()
    }
    for name, (function, parameters) in OTHERS.items():
        found[name] = function(image, start, **parameters)
    return {name: _scores(one, truth) for name, one in found.items()}


def _scores(localised, truth):
    error = np.linalg.norm(localised.corners - truth, axis=1)
    return {
        "max_px": float(error.max()),
        "mean_px": float(error.mean()),
        "left_share": float(1 - localised.converged.mean()),
    }


@experiment(
    "fig_3_11_localised",
    artefact="fig_3_11",
    shards={"quick": 1, "full": 1},
)
def localised_starts(effort):
    """Error after localisation for starts of falling accuracy."""
    starts = BASIN_QUICK if effort == "quick" else START_ERRORS_PX
    settings = {
        "image": {"px": SIZE_PX, "square_px": 100, "fov_deg": 134},
        "blur_px": BASIN_BLUR_PX,
        "noise_sd": 0,
        "half_windows": HALF_WINDOWS,
        "termination_px": TERMINATION_PX,
        "others": {name: given for name, (_, given) in OTHERS.items()},
    }
    conditions = [{"start_px": start} for start in starts]
    return Plan(basin_trial, conditions, BASIN_TRIALS[effort], settings)
