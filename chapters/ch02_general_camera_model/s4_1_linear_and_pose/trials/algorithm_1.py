"""The boards that Algorithm 1 is run on: chessboards in drawn poses."""

import numpy as np

from raxel.geometry import pose, rotation_from_vector

SIZE_PX = 240
COLUMNS, ROWS = 25, 21
PITCH_MM = 30.0
DISTANCE_MM = 450.0
SHIFT_MM = 150.0
TILT_DEG = 30.0
BOARDS = 8


def board_points():
    """Return the corners (N, 2) of the board, its centre at the origin, mm."""
    x, y = np.meshgrid(np.arange(COLUMNS), np.arange(ROWS))
    middle = [(COLUMNS - 1) / 2, (ROWS - 1) / 2]
    return PITCH_MM * (np.column_stack([x.ravel(), y.ravel()]) - middle)


def draw_poses(rng):
    """Return poses T_camera_grid (n, 4, 4), tilted and shifted in all directions."""
    angles = np.radians(rng.uniform(-TILT_DEG, TILT_DEG, (BOARDS, 3)))
    shift = rng.uniform(-SHIFT_MM, SHIFT_MM, (BOARDS, 3))
    return pose(rotation_from_vector(angles), shift + [0.0, 0.0, DISTANCE_MM])
