"""A board cut along its squares and laid on squares: found where its size is given."""

import numpy as np
import pytest

from raxel.features import find_board
from raxel.features.chessboard.ends import _ends, _shown
from raxel.features.chessboard.saddles import Level
from tests.chessboards import Board, facing
from tests.raxel.features.test_find import distance, soft_and_noisy

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
def test_a_board_on_tiles_of_its_own_size_is_found_by_their_tones(tiles, shift):
    """Whether its squares go on in step with the tiles or not."""
    found = find_board(on_tiles(*tiles, shift), 6, 4)
    assert found.found, found.reason
    assert distance(found, BOARD.corners(), 6, 4) < 0.3


def test_tiles_that_look_like_the_board_are_named():
    image = on_tiles(50, 190)
    told, counted = find_board(image, 6, 4), find_board(image)
    assert not told.found
    assert not counted.found
    for reason in (told.reason, counted.reason):
        assert "squares go on about the board" in reason
        assert "white margin" in reason
    assert "no part of this size differs from the rest" in told.reason


def test_a_column_of_fainter_paint_does_not_end_a_board():
    """The board is whole; with a column too few given, no part of it is one."""
    image = BOARD.image()
    edge = round(BOARD.corners().reshape(4, 6, 2)[:, 5, 0].mean())
    image[:, edge:] = 120 + (image[:, edge:].astype(float) - 120) * 0.6
    assert not find_board(soft_and_noisy(image), 5, 4).found
    assert find_board(soft_and_noisy(image), 6, 4).found


@pytest.mark.parametrize(("width", "ends"), [(200, True), (104, False)])
def test_rows_that_run_out_of_the_picture_do_not_end_a_board(width, ends):
    """A column beyond a part of a lattice is empty: nothing of it is in the picture, or
    nothing of a board. Its squares tell nothing."""
    points = np.stack(np.meshgrid(20.0 * np.arange(1, 7), 20.0 * np.arange(1, 6)), -1)
    points[:, 5] = np.nan
    level = Level(np.zeros((200, width), np.float32), 1, 1.0, None)
    steps = [np.stack([-np.ones((5, 6)), np.ones((5, 6))], -1)] * 2
    room = slice(0, 5), slice(0, 5)
    assert _ends(points, _shown(points, level), steps, room) == ends
