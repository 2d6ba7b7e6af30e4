"""Pixel to board point inside the lattice of detected corners."""

import numpy as np
import pytest

from raxel.calibration.views.correspondence import (
    BoardView,
    board_cells,
    locate_pixels,
    pixel_runs,
    pixels_on_board,
)
from raxel.errors import InputError
from raxel.geometry.homography import apply_homography

COLUMNS, ROWS = 7, 5
BOARD = np.stack(np.meshgrid(np.arange(COLUMNS), np.arange(ROWS)), -1).reshape(-1, 2)
BOARD = 20.0 * BOARD
TO_PIXEL = np.array([[2.0, 0.3, 40.0], [-0.2, 1.8, 60.0], [1e-3, 5e-4, 1.0]])


def bent(points):
    """A smooth map that is no homography, as a strong lens gives."""
    pixels = apply_homography(TO_PIXEL, points) - [150.0, 110.0]
    r = np.linalg.norm(pixels, axis=1, keepdims=True)
    return pixels * np.arctan(r / 120.0) / (r / 120.0 + 1e-300) + [150.0, 110.0]


def view(mapping=bent):
    return BoardView(mapping(BOARD), BOARD, COLUMNS, ROWS, "left.png")


def test_cell_maps_reproduce_homography():
    truth = np.random.default_rng(0).uniform([0, 0], BOARD.max(axis=0), (2000, 2))
    pixels = apply_homography(TO_PIXEL, truth)
    points, inside = locate_pixels(
        pixels, view(lambda p: apply_homography(TO_PIXEL, p))
    )
    assert inside.all()
    assert np.abs(points - truth).max() < 1e-9


def test_interpolation_is_exact_at_corners():
    truth = np.random.default_rng(1).uniform([0, 0], BOARD.max(axis=0), (2000, 2))
    points, inside = locate_pixels(bent(truth), view())
    # The rim of the lattice is curved, its cells are straight: a few fall outside.
    assert inside.mean() > 0.97
    # Interpolation error of 20 mm cells under this distortion.
    assert np.linalg.norm(points - truth, axis=1)[inside].max() < 0.8
    points, inside = locate_pixels(bent(BOARD), view())
    assert inside.all()
    assert np.abs(points - BOARD).max() < 1e-9


def test_locate_pixels_agrees_with_brute_force():
    pixels = np.random.default_rng(2).uniform(-20, 330, (20000, 2))
    cells = board_cells(view())
    gap = np.einsum("kec,mc->mke", cells.edges[..., :2], pixels) + cells.edges[..., 2]
    expected = np.all(gap >= 0, axis=2).any(axis=1)
    points, inside = locate_pixels(pixels, view())
    assert np.array_equal(inside, expected)
    assert np.array_equal(np.isfinite(points).all(axis=1), inside)


@pytest.mark.parametrize("order", [slice(None, None, -1), None])
def test_locate_pixels_ignores_lattice_orientation(order):
    lattice = view().pixels.reshape(ROWS, COLUMNS, 2)
    board = BOARD.reshape(ROWS, COLUMNS, 2)
    if order is None:
        lattice, board = lattice[:, ::-1], board[:, ::-1]
    else:
        lattice, board = lattice[order], board[order]
    other = BoardView(lattice.reshape(-1, 2), board.reshape(-1, 2), COLUMNS, ROWS)
    pixels = np.random.default_rng(4).uniform(0, 300, (500, 2))
    a, inside_a = locate_pixels(pixels, view())
    b, inside_b = locate_pixels(pixels, other)
    assert np.array_equal(inside_a, inside_b)
    assert np.allclose(a, b, atol=1e-9, equal_nan=True)


def test_missing_corner_removes_four_cells():
    missing = view()
    missing.pixels[8] = np.nan
    assert len(board_cells(missing).corners) == (COLUMNS - 1) * (ROWS - 1) - 4
    points, inside = locate_pixels(bent(BOARD + 3.0), missing)
    whole, inside_whole = locate_pixels(bent(BOARD + 3.0), view())
    assert np.count_nonzero(inside_whole) - np.count_nonzero(inside) == 4
    assert np.array_equal(points[inside], whole[inside])


def test_pixels_on_board_lists_whole_pixels():
    pixels, points = pixels_on_board(view(), 200, 180, step=3)
    assert np.all(pixels % 3 == 0)
    assert pixels.min() >= 0
    assert np.all(pixels.max(axis=0) < [200, 180])
    every = np.stack(np.meshgrid(np.arange(0, 200, 3), np.arange(0, 180, 3)), -1)
    expected, inside = locate_pixels(every.reshape(-1, 2), view())
    assert np.array_equal(points, expected[inside])
    assert np.array_equal(pixels, every.reshape(-1, 2)[inside])


@pytest.mark.parametrize("turn", [0.0, 0.7, 3.3])
@pytest.mark.parametrize("step", [1, 3])
def test_pixel_runs_cover_cells(turn, step):
    rotation = np.array([[np.cos(turn), -np.sin(turn)], [np.sin(turn), np.cos(turn)]])
    turned = (bent(BOARD) - [150, 110]) @ rotation.T + [150, 110]
    cells = board_cells(view()._replace(pixels=turned))
    # The image ends inside the board, on the right and below.
    width, height = 180, 150
    runs = pixel_runs(cells, width, height, step)
    number = np.full((height, width), -1)
    for v, first, stop, cell in zip(*runs, strict=True):
        assert (number[v, first:stop:step] == -1).all()
        number[v, first:stop:step] = cell
    u, v = np.meshgrid(np.arange(0, width, step), np.arange(0, height, step))
    lines = cells.edges[:, :, :, None, None]
    gap = lines[:, :, 0] * u + lines[:, :, 1] * v + lines[:, :, 2]
    inside = np.all(gap >= 0, axis=1)
    assert inside.sum(axis=0).max() == 1
    expected = np.where(inside.any(axis=0), inside.argmax(axis=0), -1)
    assert np.array_equal(number[::step, ::step], expected)
    assert np.count_nonzero(number >= 0) == np.count_nonzero(expected >= 0)


def test_view_counts_and_values_are_checked():
    good = view()
    with pytest.raises(InputError, match=r"left\.png: corners.*7 x 4"):
        locate_pixels(np.zeros((1, 2)), good._replace(rows=4))
    good.pixels[3, 0] = np.nan
    with pytest.raises(InputError, match=r"left\.png"):
        locate_pixels(np.zeros((1, 2)), good)


def test_view_without_cells_covers_no_pixel():
    empty = view()
    empty.pixels[:] = np.nan
    _, inside = locate_pixels(np.zeros((3, 2)), empty)
    assert not inside.any()


def test_covered_pixels_surround_board_centre():
    """Over shifts by parts of a pixel, their mean is that of the board's outline."""
    off = []
    for shift in np.stack(np.meshgrid(*2 * [np.arange(10) / 10]), -1).reshape(-1, 2):
        corners = np.array([[20, 30], [60, 30], [20, 80], [60, 80]]) + shift
        board = BoardView(corners, np.array([[0, 0], [1, 0], [0, 1], [1, 1.0]]), 2, 2)
        v, u = np.nonzero(board.covered(100, 120))
        off.append([u.mean(), v.mean()] - corners.mean(axis=0))
    assert np.abs(np.mean(off, axis=0)).max() < 0.1


@pytest.mark.parametrize("hand", [1.0, -1.0])
def test_covered_cells_ignore_orientation(hand):
    """Six by four cells of 20 x 20; a corner that is missing takes four along."""
    stretch = np.array([[1.5, 0.4], [-0.3 * hand, 0.8 * hand]])
    seen = view(lambda points: points @ stretch.T)
    cell = 400 * abs(np.linalg.det(stretch))
    assert seen.area() == pytest.approx(24 * cell)
    seen.pixels[COLUMNS + 1] = np.nan
    assert seen.area() == pytest.approx(20 * cell)
