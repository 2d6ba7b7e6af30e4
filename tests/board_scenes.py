"""Views of a chessboard through a fisheye, for the tests of whole calibrations."""

import numpy as np

from raxel.calibration.views.correspondence import BoardView
from raxel.cameras.lenses.fisheye import FisheyeCamera
from raxel.geometry import on_plane, pose, rotation_from_vector, transform

COLUMNS, ROWS, PITCH = 13, 10, 12.0
BOARD = PITCH * np.stack(
    np.meshgrid(np.arange(COLUMNS), np.arange(ROWS)), axis=-1
).reshape(-1, 2).astype(float)
WIDTH, HEIGHT = 240, 180
FISHEYE = FisheyeCamera("equidistance", 100.0, [122.0, 88.0], WIDTH, HEIGHT, np.pi / 2)


def board_poses(seed, count, tilt=0.5, spread=(45.0, 30.0)):
    """Poses (count, 4, 4) of boards in front of the camera, tilted all ways."""
    rng = np.random.default_rng(seed)
    around = np.linspace(0, 2 * np.pi, count, endpoint=False) + rng.uniform(0, 1)
    vectors = np.column_stack(
        [tilt * np.cos(around), tilt * np.sin(around), rng.uniform(-0.3, 0.3, count)]
    )
    R = rotation_from_vector(vectors)
    x, y = spread
    t = rng.uniform([-x, -y, 110], [x, y, 150], (count, 3))
    return pose(R, t - R @ [*BOARD.mean(axis=0), 0.0])


def views_of(poses, camera=FISHEYE, noise=0.0, seed=0, solid=None):
    """BoardViews of the board at these poses, with Gaussian noise in px; solid: where
    its corners are, (N, 3), None for a flat one."""
    rng = np.random.default_rng(seed)
    flat = on_plane(BOARD) if solid is None else solid
    views = []
    for k, T in enumerate(poses):
        pixels = camera.project(transform(T, flat)).pixels
        pixels = pixels + noise * rng.normal(size=pixels.shape)
        views.append(BoardView(pixels, BOARD, COLUMNS, ROWS, f"{k}.png"))
    return views
