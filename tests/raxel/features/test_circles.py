"""Grids of circles are named; chessboards rejected for other reasons are not."""

import cv2
import numpy as np
import pytest

from raxel.features.circles import circle_lattice
from tests.charuco_boards import TILTS_DEG, board_image

SQUARE_GRID = [(60 * x, 60 * y) for y in range(6) for x in range(8)]
STAGGERED_GRID = [(60 * x + 30 * (y % 2), 30 * y) for y in range(11) for x in range(7)]
HEXAGONAL_GRID = [(44 * x, 51 * y + 25 * (x % 2)) for x in range(10) for y in range(7)]


def sheet(centres, draw):
    """The print (height, width) uint8 with a mark at each of the centres (x, y)."""
    print_ = np.full((440, 560), 255, np.uint8)
    for x, y in centres:
        draw(print_, (x + 60, y + 60))
    return print_


def disc(print_, centre):
    cv2.circle(print_, centre, 18, 0, -1)


def square(print_, centre):
    x, y = centre
    print_[y - 28 : y + 28, x - 28 : x + 28] = 0


@pytest.mark.parametrize("inverse", [False, True])
@pytest.mark.parametrize("centres", [SQUARE_GRID, STAGGERED_GRID, HEXAGONAL_GRID])
def test_circle_grid_is_named(centres, inverse):
    print_ = sheet(centres, disc)
    image, _ = board_image(TILTS_DEG[0], print_=255 - print_ if inverse else print_)
    assert circle_lattice(image) is not None


@pytest.mark.parametrize("blur", [0.5, 2, 4, 8])
def test_blurred_squares_are_not_circles(blur):
    """Ink or light leaves gaps between the dark squares of a board."""
    board = [(56 * x, 56 * y) for y in range(6) for x in range(8) if (x + y) % 2]
    image, _ = board_image(TILTS_DEG[0], print_=sheet(board, square))
    assert circle_lattice(cv2.GaussianBlur(image, (0, 0), blur)) is None
