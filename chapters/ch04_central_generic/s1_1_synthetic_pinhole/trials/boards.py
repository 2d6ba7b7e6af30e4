"""A chessboard with interpolation in place of an active grid as the base."""

import numpy as np

from chapters.ch04_central_generic.s1_1_synthetic_pinhole.trials.centres import (
    centre_off,
)
from chapters.shared.wide_angle import (
    CENTRE_MM,
    PRINCIPAL,
    RADIUS_PX,
    RAYS,
    SETTINGS,
    SIZE_PX,
    T_BASE_CAMERA,
    back_project,
    draw_poses,
    equidistance,
    observe,
    radial_lens,
)
from raxel.calibration import BoardView, pixels_on_board
from raxel.cameras.core.base import pixel_grid
from raxel.geometry import inverse_pose, on_plane, transform
from repro.run.experiment import experiment
from repro.run.outcomes import Plan, crossed

PITCH_MM = 20.0
COMPARED_PX = 0.1
REACH = 2.5  # of the board to either side, in distances of the camera
FISHEYE_DEG = 150.0
LENSES = ("radial, 100°", "equidistance, 150°")
PITCHES_MM = {"quick": [20.0, 80.0], "full": [20.0, 40.0, 80.0, 160.0]}
EVERY = 13  # pixels that are tried, of all: about 31 000


def lens_of(name):
    """One of LENSES."""
    return radial_lens() if name == LENSES[0] else equidistance(FISHEYE_DEG)


def interpolated(camera, T_base_grid, pixels, pitch_mm):
    """Points (N, 2) of a chessboard by a homography per cell, and of no other.

    T_base_grid: (4, 4). NaN where no whole cell is in the round picture.
    """
    half = pitch_mm * np.ceil(REACH * CENTRE_MM[2] / pitch_mm)
    along = np.arange(-half, half + pitch_mm / 2, pitch_mm)
    board = np.stack(np.meshgrid(along, along), axis=-1).reshape(-1, 2)
    T_camera_grid = inverse_pose(T_BASE_CAMERA) @ T_base_grid
    at = camera.project(transform(T_camera_grid, on_plane(board)))
    off = np.linalg.norm(at.pixels - PRINCIPAL, axis=1)
    visible = (at.valid & (off <= RADIUS_PX))[:, None]
    corners = np.where(visible, at.pixels, np.nan)
    view = BoardView(corners, board, len(along), len(along))
    places, points = pixels_on_board(view, SIZE_PX, SIZE_PX)
    table = np.full((SIZE_PX, SIZE_PX, 2), np.nan)
    table[places[:, 1], places[:, 0]] = points
    return table[pixels[:, 1], pixels[:, 0]]


def board_trial(condition, rng):
    """Centre errors: the base from a chessboard's cells, or from every pixel."""
    camera, T_base_grid = lens_of(condition["lens"]), draw_poses(rng)
    pixels = rng.permutation(pixel_grid(SIZE_PX, SIZE_PX)[::EVERY].astype(int))
    exact, seen = back_project(camera, pixels.astype(float), T_base_grid)
    boards = T_base_grid if condition["all_grids"] else T_base_grid[:1]
    pitch = condition["pitch_mm"]
    guessed = np.stack([interpolated(camera, T, pixels, pitch) for T in boards])
    found = np.isfinite(guessed).all(axis=(0, 2))
    use = np.flatnonzero(seen.all(axis=0) & found)[:RAYS]
    exact, guessed = exact[:, use], guessed[:, use]
    measured = observe(camera, T_base_grid, pixels[use] + 0.0, COMPARED_PX, "px", rng)
    gap = np.linalg.norm(guessed[0] - exact[0], axis=1)
    return {
        "rays": len(use),
        "gap_mm": float(np.median(gap)),
        "base_mm": centre_off("CGSP", np.stack([guessed[0], *exact[1:]])),
        "all_mm": centre_off("CGSP", guessed) if len(boards) > 1 else None,
        "noise_mm": centre_off("CGSP", measured.noisy),
    }


@experiment("exp_c4_interp_bias_centre", artefact="sec_4_1_1")
def boards_as_base(effort):
    """The claim's case: 20 mm squares before the camera of 4.1.5."""
    conditions = crossed(lens=LENSES[:1], pitch_mm=[PITCH_MM], all_grids=[True])
    return Plan(board_trial, conditions, {"quick": 4, "full": 50}[effort], SETTINGS)


@experiment("ext_board_as_base_sweep", artefact="ext_board_as_base")
def pitches(effort):
    """Larger squares, and a lens that bends them more."""
    conditions = crossed(lens=LENSES, pitch_mm=PITCHES_MM[effort], all_grids=[False])
    return Plan(board_trial, conditions, {"quick": 3, "full": 20}[effort], SETTINGS)
