"""A board that is cut, shaded or of unequal squares is not counted as a whole one."""

import numpy as np
import pytest

from raxel.features import find_board
from raxel.features.chessboard.grids import Grid
from raxel.features.chessboard.sides import dark_side, unequal_pitch
from tests.chessboards import Board, facing
from tests.raxel.features.test_find import drawn, seen, soft_and_noisy

BOARD = Board(9, 6, facing(9, 6, 40))


def without_margin(image, ground):
    """The picture of BOARD with `ground` in place of its white margin."""
    (left, top), (right, bottom) = BOARD.corners()[[0, -1]]
    v, u = np.mgrid[0 : image.shape[0], 0 : image.shape[1]]
    on_board = (np.abs(u - (left + right) / 2) < (right - left) / 2 + 40) & (
        np.abs(v - (top + bottom) / 2) < (bottom - top) / 2 + 40
    )
    return np.where(on_board, image, ground)


def column(number):
    """u of a column of corners of BOARD, which faces the camera."""
    return BOARD.corners().reshape(6, 9, 2)[0, number, 0]


def shaded(image, left, right, light):
    """The picture in the shadow of something between columns of pixels."""
    shade = np.ones(image.shape[1])
    shade[max(round(left), 0) : max(round(right), 0)] = light
    return soft_and_noisy(image * shade)


@pytest.mark.parametrize("light", [0.05, 0.3])
@pytest.mark.parametrize("beyond", [0.5, 0.75])
def test_a_side_cut_by_a_shadow_does_not_end_the_board(light, beyond):
    """Two columns lie in the shadow, whose edge cuts the squares beyond the third."""
    image = shaded(BOARD.image(), 0, column(2) - beyond * 40, light)
    found = find_board(image)
    assert not found.found
    assert "give columns and rows" in found.reason


@pytest.mark.parametrize(("beyond", "side"), [(140, "left side"), (20, "")])
def test_a_shadow_is_told_by_white_paper_behind_two_other_sides(beyond, side):
    """With the picture's rim in the squares above and below, only the right is left."""
    points = BOARD.corners().reshape(6, 9, 2)
    top, bottom = (round(v) for v in (points[0, 0, 1], points[-1, 0, 1]))
    image = shaded(BOARD.image(), 0, column(0) - 40, 0.03)
    grid = Grid(points - [0, top - beyond], *np.ones((4, 6, 9)))
    assert dark_side(grid, image[top - beyond : bottom + beyond]) == side


def test_what_stands_before_a_side_does_not_end_the_board():
    image = seen(BOARD)
    image[:, round(column(6)) + 16 :] = 150
    assert "look cut short" in find_board(image).reason
    assert not find_board(image, 9, 6).found


def test_squares_that_are_narrower_on_both_sides_are_a_board():
    image = BOARD.image()
    image[:, : round(column(0)) - 20] = 210
    image[:, round(column(8)) + 20 :] = 210
    found = find_board(soft_and_noisy(image))
    assert (found.columns, found.rows) == (9, 6)


def stretched(image, low, high):
    """The picture with the rows of pixels from low to high twice."""
    return np.concatenate([image[:high], image[low:high], image[high:]])


@pytest.mark.parametrize("size", [(9, 6), (None, None)])
def test_a_row_of_double_height_is_noticed(size):
    corners = BOARD.corners().reshape(6, 9, 2)
    low, high = (round(corners[k, 0, 1] + 0.5) for k in (2, 3))
    image = stretched(BOARD.image(), low, high)
    found = find_board(soft_and_noisy(image), *size)
    assert not found.found
    line = "between row 3 from its top and row 3 from its bottom are 2.0 times longer"
    assert f"its squares are not equal: those {line} than" in found.reason


@pytest.mark.parametrize("name", ["tilted", "bent", "strongly bent"])
def test_a_bent_board_has_equal_squares(name):
    board = drawn(name)
    points = board.corners().reshape(board.rows, board.columns, 2)
    ones = np.ones(points.shape[:2])
    assert unequal_pitch(Grid(points, ones, ones, ones, ones)) == ""


@pytest.mark.parametrize(
    ("off", "side"), [((260, 0), "right side"), ((0, 150), "bottom")]
)
def test_a_board_that_runs_out_of_the_picture_is_no_smaller_board(off, side):
    centre = 319.5 + off[0], 239.5 + off[1]
    image = seen(Board(9, 6, facing(9, 6, 40, centre=centre)))
    found = find_board(image, 9, 6)
    assert not found.found
    assert f"but the board may go on beyond its {side}" in found.reason
    assert found.reason.endswith("outside the image; check columns and rows")


def covered(image, light, from_, slant=0):
    """The picture with a sheet of one grey right of a column of pixels `from_`."""
    v, u = np.mgrid[0 : image.shape[0], 0 : image.shape[1]]
    return np.where(u > from_ + slant * (v - 240), light, image)


@pytest.mark.parametrize("light", [70, 235])
def test_a_sheet_whose_edge_is_that_of_squares_does_not_end_the_board(light):
    """It hides a column and shows no cut square: its edge runs on beyond the board."""
    image = covered(BOARD.image(), light, column(8) + 1)
    found = find_board(soft_and_noisy(image))
    assert not found.found
    assert "the edge at its right side runs straight on beyond" in found.reason


def test_squares_cut_aslant_are_no_side_of_a_board():
    """Tiles seen through an opening: no side of it shows whole squares."""
    tiles = Board(16, 14, facing(16, 14, 48, turn=0.05)).image()
    v, u = np.mgrid[0:480, 0:640]
    opening = (u > 130) & (u < 510) & (v > 90) & (v < 390)
    found = find_board(soft_and_noisy(np.where(opening, tiles, 120)))
    assert not found.found
    assert "squares at its top look cut short" in found.reason


def test_a_side_that_lacks_nothing_is_not_blamed():
    """The board is whole, and asked for with a column more; its rim is near its top."""
    image = seen(Board(8, 6, facing(8, 6, 40, centre=(319.5, 130))))
    assert "beyond its top, outside" in find_board(image).reason
    assert find_board(image, 9, 6).reason.endswith(
        "8 x 6 corners found; check columns and rows"
    )


def test_what_lies_outside_the_image_is_no_shadow():
    """The picture ends in the top squares: aslant, some of the next corners are in it,
    but next to nothing of the fields behind them."""
    homography = facing(5, 4, 105, turn=0.1, centre=(319.5, 268))
    found = find_board(seen(Board(5, 4, homography, height=600)))
    assert "may go on beyond its top, outside the image" in found.reason


def test_a_board_of_which_squares_run_out_lies_in_no_shadow():
    """White paper is seen behind three of seven corners of its top; squares of the
    others end at the picture's rim."""
    board = Board(7, 6, facing(7, 6, 60, turn=0.25, centre=(319.5, 204)))
    found = find_board(seen(board))
    assert (found.columns, found.rows) == (7, 6)


def test_what_covers_a_few_squares_of_a_side_may_hide_a_column():
    """A hand in the middle of the side: the squares beside it end as they should."""
    image = BOARD.image()
    v = BOARD.corners().reshape(6, 9, 2)[:, 8, 1]
    image[round(v[1]) + 5 : round(v[4]) - 5, round(column(7)) + 15 :] = 150
    image[:, round(column(8)) - 1 :] = np.where(
        image[:, round(column(8)) - 1 :] < 150, 210, image[:, round(column(8)) - 1 :]
    )
    found = find_board(soft_and_noisy(image))
    assert not found.found
    assert "squares at its right side look cut short" in found.reason


def test_a_slanting_sheet_does_not_end_the_board():
    image = covered(BOARD.image(), 235, column(8), slant=0.02)
    found = find_board(soft_and_noisy(image))
    assert not found.found
    assert "runs straight on beyond the board" in found.reason


def test_squares_in_a_shadow_beyond_a_side_are_seen():
    """No side has white paper behind it: only the squares tell that they are some."""
    image = without_margin(BOARD.image(), 30.0)
    found = find_board(soft_and_noisy(image))
    assert (found.columns, found.rows) == (9, 6)
    found = find_board(shaded(image, 0, column(0), 0.2))
    assert not found.found
    assert "more squares stand in a shadow beyond its left side" in found.reason


def test_a_sheet_on_dark_stripes_does_not_end_the_board():
    """The stripes run on beyond the sheet's edge nearly as dark as it is in places."""
    v, u = np.mgrid[0:480, 0:640]
    ground = 28 + 15 * (1 + np.sin(2 * np.pi * (0.5 * u + v) / 60))
    image = covered(without_margin(BOARD.image(), ground), 28, column(8) + 1)
    found = find_board(soft_and_noisy(image, noise=0.3))
    assert not found.found
    assert "the edge at its right side runs straight on beyond" in found.reason
