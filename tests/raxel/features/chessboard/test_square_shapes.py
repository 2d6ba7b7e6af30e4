"""Side rows that are the edge of the paper, and cells that are not squares."""

import cv2
import numpy as np
import pytest

from raxel.features import find_board
from raxel.features.chessboard import search
from raxel.features.chessboard.ends import examine_sides
from raxel.features.chessboard.verdict import (
    CIRCLE_BULGE_SQUARES,
    MAX_BULGE_SQUARES,
    bulge_of,
    other_tone,
)
from tests.chessboards import Board, facing
from tests.raxel.features.chessboard.test_find_board import (
    distance,
    drawn,
    seen,
    soft_and_noisy,
)

BOARD = Board(9, 6, facing(9, 6, 40))


def on_cloth(seed, cell=10):
    """The board cut along its squares, on a cloth of random patches."""
    rng = np.random.default_rng(seed)
    cloth = rng.uniform(20, 230, (480 // cell, 640 // cell))
    image = np.kron(cloth, np.ones((cell, cell)))
    low, high = (
        np.rint(f(BOARD.corners(), axis=0)).astype(int) for f in (np.min, np.max)
    )
    room = slice(low[1] - 40, high[1] + 40), slice(low[0] - 40, high[0] + 40)
    image[room] = BOARD.image()[room]
    return soft_and_noisy(image)


@pytest.mark.parametrize("seed", [0, 1, 3])
@pytest.mark.parametrize(("cell", "size"), [(14, (9, 6)), (10, (None, None))])
def test_corners_outside_paper_keep_board(seed, cell, size):
    """Two or three rows of chance corners with a known size, weak corners without."""
    found = find_board(on_cloth(seed, cell), *size)
    assert distance(found, BOARD.corners(), 9, 6) < 0.2


def test_possible_paper_edge_is_named():
    """Three corners of the row outside the top were found, one of them symmetric."""
    found = find_board(on_cloth(7, 14))
    what = "the last row of corners at its top may be the edge of the paper: 57 of 63"
    assert found.reason.startswith(what)
    assert "6 of 9 missing in row 1 from its top" in found.reason


def lattice_of(image):
    seen = search.search_image(image)
    return seen.grids[0], seen.levels[0]


@pytest.mark.parametrize("light", [0.5, 0.7, 1.0])
def test_row_in_shadow_is_kept(light):
    """The edge of the shadow is the outermost row: none of its corners is symmetric."""
    image = BOARD.image().astype(float)
    last = BOARD.corners()[:, 0].max()
    image[:, round(last) :] *= light
    grid, level = lattice_of(soft_and_noisy(image))
    assert sorted(grid.known.shape) == [6, 9]
    sides = examine_sides(grid, level)
    assert [side.is_row for side in sides] == [True] * 4
    assert not any(side.is_edge(known_size=True) for side in sides)
    assert [side.change for side in sides] == pytest.approx([1] * 4, abs=0.2)


@pytest.mark.parametrize("rows", [1, 2])
def test_mostly_occluded_row_is_kept(rows):
    image = seen(BOARD)
    lattice = BOARD.corners().reshape(6, 9, 2)
    u, v = np.rint(lattice[6 - rows, 8]).astype(int) - 15
    image[:v, u:] = 130
    found = find_board(image)
    assert "give columns and rows" in found.reason


def discs(radius, blur=0.8):
    """Dark discs at the dark squares of a board; radius in squares."""
    y, x = (np.mgrid[0:240, 0:320] - 30) / 20
    apart = np.full(x.shape, np.inf)
    for i, j in np.ndindex(12, 9):
        if (i + j) % 2 == 0:
            apart = np.minimum(apart, np.hypot(x - i - 0.5, y - j - 0.5))
    share = np.clip(20 * (radius - apart) + 0.5, 0, 1)
    return soft_and_noisy(210 - 170 * share, blur)


@pytest.mark.parametrize(("radius", "blur"), [(0.6, 3.0), (0.68, 0.8), (0.72, 1.5)])
def test_circle_grid_is_rejected(radius, blur):
    image = discs(radius, blur)
    for one in (image, 255 - image):
        found = find_board(one)
        assert "target.kind: circles" in found.reason
        grid, level = lattice_of(one)
        assert abs(bulge_of(grid, level)) > 1.2 * MAX_BULGE_SQUARES


@pytest.mark.parametrize("name", ["tilted", "strongly bent"])
@pytest.mark.parametrize(("blur", "gamma"), [(0.5, 1.0), (4.0, 1.0), (4.0, 0.45)])
def test_squares_have_no_bulge_under_blur_and_gamma(name, blur, gamma):
    grid, level = lattice_of(
        np.rint(255 * (seen(drawn(name), blur) / 255) ** gamma).astype(np.uint8)
    )
    assert abs(bulge_of(grid, level)) < 0.1 * CIRCLE_BULGE_SQUARES
    assert other_tone(grid, level) < 0.02


def test_filled_squares_are_rejected():
    image = BOARD.image()
    for u, v in np.rint(BOARD.corners() + 20).astype(int).tolist():
        cv2.circle(image, (u, v), 7, 200, -1)
    found = find_board(soft_and_noisy(image), 9, 6)
    assert "not of one tone" in found.reason
