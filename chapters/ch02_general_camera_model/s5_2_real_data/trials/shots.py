"""Images of section 2.5.2: boards in front of a lens at three zoom settings.

A simulated run draws its poses. Its corners are then detected in rendered images, or
redrawn: true projections, each board with the errors of one board that was detected
in a rendered image (or missing, as some of those).
"""

from __future__ import annotations

from typing import NamedTuple

import numpy as np

from chapters.shared.zoom_rigs import STAGE_ZOOM, camera_of, laboratory_of, rig_of
from raxel.calibration import BoardView
from raxel.features import find_opencv
from raxel.geometry import on_plane, pose, rotation_from_vector, transform
from raxel.lab import board_scene

STAGE_IMAGES, STEP_MM = 5, 25.0
STAGE_TURN_DEG = 10.0
MAX_DRAWS = 2000


class Counts(NamedTuple):
    """Number of board images of a run, by their use."""

    calibration: int
    held_out: int


class Boards(NamedTuple):
    """Corners (n, N, 2) of n boards, NaN where not detected, and true ones.

    Only STAGE_ZOOM has boards of the stage.
    """

    found: np.ndarray
    true: np.ndarray


def draw_poses(zoom, counts, rng):
    """Return poses T_camera_grid (n, 4, 4) of a run's boards, by their use."""
    rig = rig_of(zoom)
    uses = {
        "calibration": rig.draw_poses(rng, counts.calibration),
        "held_out": rig.draw_poses(rng, counts.held_out),
    }
    if zoom == STAGE_ZOOM:
        uses["stage"] = draw_stage(rig, rng)
    return uses


def draw_stage(rig, rng):
    """Return five poses, 25 mm apart along one line, all in view."""
    for _ in range(MAX_DRAWS):
        middle = rig.draw_poses(rng, 1)[0]
        axis = rng.standard_normal(3)
        turn = np.radians(rng.uniform(0, STAGE_TURN_DEG))
        turned = rotation_from_vector(turn * axis / np.linalg.norm(axis))
        along = middle[:3, :3] @ turned[:, 0]
        steps = np.arange(STAGE_IMAGES) - (STAGE_IMAGES - 1) / 2
        poses = pose(middle[:3, :3], middle[:3, 3] + STEP_MM * steps[:, None] * along)
        if all(rig.shows(T) for T in poses):
            return poses
    raise RuntimeError("the rig's boards leave no room for the stage")


def true_corners(zoom, poses):
    """Return the projections (n, N, 2) of the board's corners."""
    flat = on_plane(rig_of(zoom).target.points())
    return np.stack([camera_of(zoom).project(transform(T, flat)).pixels for T in poses])


def true_shape(zoom):
    """Return the shape (N, 2) of the board's corners."""
    target = rig_of(zoom).target
    return target.columns * target.rows, 2


def photograph(zoom, T_camera_grid, rng):
    """Render one image of the board, uint8 (height, width)."""
    rig = rig_of(zoom)
    scene = board_scene(rig.target, T_camera_grid, rig.border_mm)
    return laboratory_of(zoom).photograph(scene, np.eye(4), rng)


def find(zoom, image):
    """Return the detected corners (N, 2), or NaN."""
    target = rig_of(zoom).target
    seen = find_opencv(image, target.columns, target.rows)
    if seen.found:
        return seen.corners
    return np.full((target.columns * target.rows, 2), np.nan)


def found_in_pictures(zoom, poses, rng):
    """Render the boards and detect corners in every image: (Boards, images)."""
    pictures = [photograph(zoom, T, rng) for T in poses]
    found = np.stack([find(zoom, picture) for picture in pictures])
    return Boards(found, true_corners(zoom, poses)), pictures


def redrawn(zoom, poses, errors, rng):
    """Return boards with the corner errors of one board of `errors` (m, N, 2) each."""
    true = true_corners(zoom, poses)
    return Boards(true + errors[rng.integers(len(errors), size=len(true))], true)


def noisier(boards, sd_px, rng):
    """Return the boards with Gaussian noise (px, each axis) on detected corners."""
    noise = rng.normal(0.0, sd_px, boards.found.shape)
    return boards._replace(found=boards.found + noise)


def views_of(zoom, corners):
    """Return BoardViews of the detected boards."""
    target = rig_of(zoom).target
    return [
        BoardView(pixels, target.points(), target.columns, target.rows, str(index))
        for index, pixels in enumerate(corners)
        if np.isfinite(pixels).all()
    ]
