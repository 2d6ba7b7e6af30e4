"""A board without a margin on other squares is found where its size is known."""

import numpy as np
import pytest

from raxel.features import find_board
from raxel.features.chessboard.ends import _ends_at_all_sides, _inside_image
from raxel.features.chessboard.saddles import Level
from tests.chessboards import Board, facing
from tests.raxel.features.chessboard.test_find_board import distance, soft_and_noisy

BOARD = Board(6, 4, facing(6, 4, 40, turn=0.35), width=520, height=400)


def on_tiles(dark, bright, shift=(0.0, 0.0)):
    """BOARD without a margin on checked tiles as large as its squares."""
    v, u = np.mgrid[0 : BOARD.height, 0 : BOARD.width].astype(float)
    x, y = BOARD._board(u, v)
    on_board = (x > -1) & (x < 6) & (y > -1) & (y < 4)
    board = np.where((np.floor(x) + np.floor(y)) % 2 == 0, 35, 210)
    odd = (np.floor(x + shift[0]) + np.floor(y + shift[1])) % 2 == 0
    image = np.where(on_board, board, np.where(odd, dark, bright)).astype(float)
    return soft_and_noisy(image)


@pytest.mark.parametrize("shift", [(0, 0), (1, 0)])
@pytest.mark.parametrize("tiles", [(60, 180), (180, 90)])
def test_board_on_equal_tiles_is_found_by_contrast(tiles, shift):
    """Whether or not its squares are in phase with the tiles."""
    found = find_board(on_tiles(*tiles, shift), 6, 4)
    assert found.found, found.reason
    assert distance(found, BOARD.corners(), 6, 4) < 0.3


def test_indistinguishable_tiles_are_rejected():
    image = on_tiles(50, 190)
    known, counted = find_board(image, 6, 4), find_board(image)
    assert not known.found
    assert not counted.found
    for reason in (known.reason, counted.reason):
        assert "squares continue around the board" in reason
        assert "white margin" in reason
    assert "no part of this size differs from the rest" in known.reason


def test_column_of_lower_contrast_is_kept():
    """The board is complete; with one column less given, no part of it is a board."""
    image = BOARD.image()
    edge = round(BOARD.corners().reshape(4, 6, 2)[:, 5, 0].mean())
    image[:, edge:] = 120 + (image[:, edge:].astype(float) - 120) * 0.6
    assert not find_board(soft_and_noisy(image), 5, 4).found
    assert find_board(soft_and_noisy(image), 6, 4).found


@pytest.mark.parametrize(("width", "ends"), [(200, True), (104, False)])
def test_rows_outside_image_do_not_end_board(width, ends):
    """A column outside a part of a lattice is empty, or not a part of a board.

    Its squares then do not distinguish it.
    """
    points = np.stack(np.meshgrid(20.0 * np.arange(1, 7), 20.0 * np.arange(1, 6)), -1)
    points[:, 5] = np.nan
    level = Level(np.zeros((200, width), np.float32), 1, 1.0, None)
    steps = [np.stack([-np.ones((5, 6)), np.ones((5, 6))], -1)] * 2
    room = slice(0, 5), slice(0, 5)
    assert _ends_at_all_sides(points, _inside_image(points, level), steps, room) == ends
