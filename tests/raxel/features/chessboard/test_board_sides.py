"""Truncated, shaded or unequal boards are not counted as complete."""

import numpy as np
import pytest

from raxel.features import find_board
from raxel.features.chessboard.grids import Grid
from raxel.features.chessboard.sides import dark_side, unequal_pitch
from tests.chessboards import Board, facing
from tests.raxel.features.chessboard.test_find_board import drawn, seen, soft_and_noisy

BOARD = Board(9, 6, facing(9, 6, 40))


def without_margin(image, ground):
    """The image of BOARD with `ground` instead of its white margin."""
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
    """The image with a shadow between columns of pixels."""
    shade = np.ones(image.shape[1])
    shade[max(round(left), 0) : max(round(right), 0)] = light
    return soft_and_noisy(image * shade)


@pytest.mark.parametrize("light", [0.05, 0.3])
@pytest.mark.parametrize("beyond", [0.5, 0.75])
def test_side_truncated_by_shadow_is_rejected(light, beyond):
    """Two columns are in the shadow, whose edge cuts the squares of the third."""
    image = shaded(BOARD.image(), 0, column(2) - beyond * 40, light)
    found = find_board(image)
    assert "give columns and rows" in found.reason


@pytest.mark.parametrize(("beyond", "side"), [(140, "left side"), (20, "")])
def test_shadow_detection_requires_two_white_margins(beyond, side):
    """With the image border in the top and bottom squares, only the right is left."""
    points = BOARD.corners().reshape(6, 9, 2)
    top, bottom = (round(v) for v in (points[0, 0, 1], points[-1, 0, 1]))
    image = shaded(BOARD.image(), 0, column(0) - 40, 0.03)
    grid = Grid(points - [0, top - beyond], *np.ones((4, 6, 9)))
    assert dark_side(grid, image[top - beyond : bottom + beyond]) == side


def test_occluded_side_is_rejected():
    image = seen(BOARD)
    image[:, round(column(6)) + 16 :] = 150
    assert "appear truncated" in find_board(image).reason
    assert not find_board(image, 9, 6).found


def test_narrow_squares_on_both_sides_are_accepted():
    image = BOARD.image()
    image[:, : round(column(0)) - 20] = 210
    image[:, round(column(8)) + 20 :] = 210
    found = find_board(soft_and_noisy(image))
    assert (found.columns, found.rows) == (9, 6)


def stretched(image, low, high):
    """The image with the rows of pixels from low to high repeated."""
    return np.concatenate([image[:high], image[low:high], image[high:]])


@pytest.mark.parametrize("size", [(9, 6), (None, None)])
def test_row_of_double_height_is_rejected(size):
    corners = BOARD.corners().reshape(6, 9, 2)
    low, high = (round(corners[k, 0, 1] + 0.5) for k in (2, 3))
    image = stretched(BOARD.image(), low, high)
    found = find_board(soft_and_noisy(image), *size)
    line = "between row 3 from its top and row 3 from its bottom are 2.0 times longer"
    assert f"its squares are unequal: those {line} than" in found.reason


@pytest.mark.parametrize("name", ["tilted", "bent", "strongly bent"])
def test_bent_board_has_equal_pitch(name):
    board = drawn(name)
    points = board.corners().reshape(board.rows, board.columns, 2)
    ones = np.ones(points.shape[:2])
    assert unequal_pitch(Grid(points, ones, ones, ones, ones)) == ""


@pytest.mark.parametrize(
    ("off", "side"), [((260, 0), "right side"), ((0, 150), "bottom")]
)
def test_board_cut_by_image_border_is_rejected(off, side):
    centre = 319.5 + off[0], 239.5 + off[1]
    image = seen(Board(9, 6, facing(9, 6, 40, centre=centre)))
    found = find_board(image, 9, 6)
    assert f"but the board may continue beyond its {side}" in found.reason
    assert found.reason.endswith("outside the image; check columns and rows")


def covered(image, light, from_, slant=0):
    """The image with a sheet of one grey right of a column of pixels `from_`."""
    v, u = np.mgrid[0 : image.shape[0], 0 : image.shape[1]]
    return np.where(u > from_ + slant * (v - 240), light, image)


@pytest.mark.parametrize(
    ("light", "beyond", "slant"), [(70, 1, 0), (235, 1, 0), (235, 0, 0.02)]
)
def test_sheet_edge_on_squares_is_rejected(light, beyond, slant):
    """The sheet hides a column and truncates no square; its edge extends farther."""
    image = covered(BOARD.image(), light, column(8) + beyond, slant)
    found = find_board(soft_and_noisy(image))
    assert "the edge at its right side extends beyond the board" in found.reason


def test_obliquely_truncated_squares_are_rejected():
    """Tiles behind an opening: no side of it shows complete squares."""
    tiles = Board(16, 14, facing(16, 14, 48, turn=0.05)).image()
    v, u = np.mgrid[0:480, 0:640]
    opening = (u > 130) & (u < 510) & (v > 90) & (v < 390)
    found = find_board(soft_and_noisy(np.where(opening, tiles, 120)))
    assert "squares at its top appear truncated" in found.reason


def test_complete_side_is_not_named():
    """The board is complete, and the given size has one column more."""
    image = seen(Board(8, 6, facing(8, 6, 40, centre=(319.5, 130))))
    assert "beyond its top, outside" in find_board(image).reason
    assert find_board(image, 9, 6).reason.endswith(
        "8 x 6 corners found; check columns and rows"
    )


def test_area_outside_image_is_not_shadow():
    """The image border cuts the top squares obliquely.

    Some of the next corners are inside, but little of the squares behind them.
    """
    homography = facing(5, 4, 105, turn=0.1, centre=(319.5, 268))
    found = find_board(seen(Board(5, 4, homography, height=600)))
    assert "may continue beyond its top, outside the image" in found.reason


def test_cut_board_is_not_in_shadow():
    """White paper is visible behind three of seven corners of the top.

    The squares of the others are cut by the image border.
    """
    board = Board(7, 6, facing(7, 6, 60, turn=0.25, centre=(319.5, 204)))
    found = find_board(seen(board))
    assert (found.columns, found.rows) == (7, 6)


def test_locally_occluded_side_is_rejected():
    """An occluder at the centre of the side: the other squares are complete."""
    image = BOARD.image()
    v = BOARD.corners().reshape(6, 9, 2)[:, 8, 1]
    image[round(v[1]) + 5 : round(v[4]) - 5, round(column(7)) + 15 :] = 150
    image[:, round(column(8)) - 1 :] = np.where(
        image[:, round(column(8)) - 1 :] < 150, 210, image[:, round(column(8)) - 1 :]
    )
    found = find_board(soft_and_noisy(image))
    assert "squares at its right side appear truncated" in found.reason


def test_squares_in_shadow_are_detected():
    """No side has a white margin: only the squares in the shadow indicate it."""
    image = without_margin(BOARD.image(), 30.0)
    found = find_board(soft_and_noisy(image))
    assert (found.columns, found.rows) == (9, 6)
    found = find_board(shaded(image, 0, column(0), 0.2))
    assert "more squares are in a shadow beyond its left side" in found.reason


def test_sheet_on_dark_stripes_is_rejected():
    """The stripes extend beyond the sheet's edge, in places as dark as the sheet."""
    v, u = np.mgrid[0:480, 0:640]
    ground = 28 + 15 * (1 + np.sin(2 * np.pi * (0.5 * u + v) / 60))
    image = covered(without_margin(BOARD.image(), ground), 28, column(8) + 1)
    found = find_board(soft_and_noisy(image, noise=0.3))
    assert "the edge at its right side extends beyond" in found.reason
