"""Divisions of the images by position and orientation of the boards."""

from types import SimpleNamespace

import numpy as np
import pytest

from raxel.evaluation.split_half import halves_of
from raxel.geometry import on_plane, pose, rotation_from_vector

CORNERS = np.array([[x, y] for y in (-20.0, 0, 20) for x in (-30.0, 0, 30)])


def seen(towards, turn):
    """(score, view) of a board whose middle is 500 mm away, about so many degrees to
    the right and down; turn: its rotation vector, degrees, from facing the camera."""
    right, down = np.radians(towards)
    facing = rotation_from_vector([0, right, 0]) @ rotation_from_vector([-down, 0, 0])
    T = pose(
        facing @ rotation_from_vector(np.radians(turn)), facing @ [0.0, 0.0, 500.0]
    )
    at = on_plane(CORNERS) @ T[:3, :3].T + T[:3, 3]
    view = SimpleNamespace(points=CORNERS, pixels=400 * at[:, :2] / at[:, 2:])
    return SimpleNamespace(T_camera_grid=T), view


@pytest.mark.parametrize(
    ("name", "first", "second"),
    [
        ("tilted much and little", (0, 0, 40), (0, 25, 0)),
        ("tilted much and little", (0, 0, 0), (25, 0, 0)),
        # About x the board is looked at from above or below, so y of the sight grows.
        ("tilted about one side of the board and the other", (25, 0, 0), (0, 25, 0)),
        ("tilted about one diagonal of the board and the other", (9, 9, 0), (9, -9, 0)),
        ("turned in the image", (0, 0, 0), (0, 0, 90)),
        ("leaning to the left and to the right", (0, -30, 0), (0, 30, 0)),
        ("leaning up and down", (30, 0, 0), (-30, 0, 0)),
    ],
)
def test_halves_by_orientation(name, first, second):
    """Wherever in the image they are: a board far aside is no tilted one."""
    aside = [(-20, 12), (-16, -20), (18, 15), (22, -14)]
    pairs = [seen(at, turn) for at in aside for turn in (first, second)]
    if name.startswith("lean"):  # relative to the camera's axis
        pairs = [seen((0, 0), turn) for _ in aside for turn in (first, second)]
    np.testing.assert_array_equal(dict(halves_of(pairs))[name], 4 * [True, False])


def test_halves_by_position():
    corners = [(-20, -12), (20, -14), (-22, 15), (21, 13)]
    ways = dict(halves_of([seen(at, (0, 0, 0)) for at in corners]))
    np.testing.assert_array_equal(ways["left and right in the image"], [1, 0, 1, 0])
    np.testing.assert_array_equal(ways["top and bottom in the image"], [1, 1, 0, 0])
    np.testing.assert_array_equal(ways["every other image"], [1, 0, 1, 0])
    np.testing.assert_array_equal(ways["order of the images"], [1, 1, 0, 0])
