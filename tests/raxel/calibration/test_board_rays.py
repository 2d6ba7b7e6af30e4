"""The table of rays against its definition, pixel by pixel."""

import numpy as np

from raxel.calibration.generic.board_growth import ray_table
from raxel.calibration.views.correspondence import pixels_on_board
from raxel.geometry import on_plane, transform
from tests.board_scenes import HEIGHT, WIDTH, board_poses, views_of

CENTRE = np.array([0.02, -0.03, 0.05])


def directly(views, poses):
    """Dominant eigenvectors of the second moments, towards the points."""
    moments = np.zeros((HEIGHT, WIDTH, 3, 3))
    ahead = np.zeros((HEIGHT, WIDTH, 3))
    for view, T in zip(views, poses, strict=True):
        pixels, points = pixels_on_board(view, WIDTH, HEIGHT)
        u, v = pixels.T
        p = transform(T, on_plane(points)) - CENTRE
        moments[v, u] += p[:, :, None] * p[:, None, :]
        ahead[v, u] += p
    axis = np.linalg.eigh(moments)[1][..., 2]
    axis *= np.sign(np.sum(axis * ahead, axis=2, keepdims=True))
    return np.where(np.any(ahead, axis=2, keepdims=True), axis, np.nan)


def test_ray_table_contains_main_axes_of_points():
    poses = board_poses(4, 4)
    views = views_of(poses, noise=0.05)
    views[1].pixels[[0, 40, 41]] = np.nan  # a board with holes
    table = ray_table(views, poses, CENTRE, WIDTH, HEIGHT)
    expected = directly(views, poses)
    assert np.array_equal(np.isnan(table), np.isnan(expected))
    assert 0.2 < np.mean(np.isfinite(table)) < 1
    assert np.nanmax(np.abs(table - expected)) < 1e-12


def test_ray_table_without_cells_is_empty():
    poses = board_poses(4, 1)
    views = views_of(poses)
    views[0].pixels[:] = np.nan
    assert np.isnan(ray_table(views, poses, CENTRE, WIDTH, HEIGHT)).all()
    assert np.isnan(ray_table([], [], CENTRE, WIDTH, HEIGHT)).all()
