"""The search terminates, and finds the true extent of lattices."""

import cv2
import numpy as np
import pytest

from raxel.features import find_board
from raxel.features.chessboard import search
from raxel.features.chessboard.grids import Grid, grid_of
from raxel.features.chessboard.saddles import Nodes, levels_of, noise_sd
from tests.chessboards import Board, facing
from tests.raxel.features.chessboard.test_find_board import distance

BOARD = Board(9, 6, facing(9, 6, 40))


def noded(lattice):
    """Nodes at the points (rows, columns, 2) of a lattice, and their links."""
    rows, columns = lattice.shape[:2]
    count = rows * columns
    number = np.arange(count).reshape(rows, columns)
    links = np.full((count, 4, 2), -1)
    for k, (dx, dy) in enumerate(((1, 0), (0, 1), (-1, 0), (0, -1))):
        for y, x in np.ndindex(rows, columns):
            if 0 <= y + dy < rows and 0 <= x + dx < columns:
                links[number[y, x], k] = number[y + dy, x + dx], (k + 2) % 4
    angles = np.tile([0, np.pi / 2, np.pi, -np.pi / 2], (count, 1))
    nodes = Nodes(
        lattice.reshape(-1, 2).astype(float),
        angles,
        np.tile([1, -1, 1, -1], (count, 1)),
        np.ones(count),
        np.zeros(count, int),
    )
    return nodes, links


@pytest.mark.parametrize("seed", range(20))
def test_grids_of_terminates_for_drifting_grids(seed, monkeypatch):
    rng = np.random.default_rng(seed)
    rows, columns = rng.integers(3, 9, 2)
    lattice = 12.0 * np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), axis=-1)
    nodes, links = noded(lattice + 20)
    cut = rng.random(links.shape[:2]) < rng.uniform(0, 0.3)
    links[cut] = -1
    passes, share = [], (0.5, 0.9, 1.0)[seed % 3]

    def moved(start, _nodes, _level):
        passes.append(np.isfinite(start[..., 0]).sum())
        assert len(passes) <= len(nodes.points)
        away = rng.random(start.shape[:2]) < share
        points = start + 30 * away[..., None]
        return Grid(points, *(np.ones(start.shape[:2]) for _ in range(4)))

    monkeypatch.setattr(search, "grid_of", moved)
    levels = levels_of(np.zeros((64, 64), np.float32), 1.0)
    grids = search.grids_of(nodes, links, levels)
    assert len(grids) == len(passes) > 0


@pytest.mark.parametrize("rows", [1, 2])
def test_too_narrow_lattice_is_rejected(rows, monkeypatch):
    image = BOARD.image()

    def narrow(start, nodes, level):
        return Grid(*(a[:rows] for a in grid_of(start, nodes, level)))

    monkeypatch.setattr(search, "grid_of", narrow)
    for size in ((9, 6), (None, None)):
        found = find_board(image, *size)
        assert f"9 x {rows} corners is too small" in found.reason


def with_more_squares(count):
    """The board with dark squares in its border, `count` chance corners below it."""
    image = BOARD.image()
    corners = BOARD.corners().reshape(6, 9, 2)
    low = round(corners[-1, 0, 1]) + 40
    for j in range(0, count + 1):
        left = round(corners[0, 0, 0]) + 40 * (j - 1)
        if (j + 6) % 2 == 0:
            image[low : low + 40, left : left + 40] = image[low - 20, left - 20]
    return cv2.GaussianBlur(image, (0, 0), 0.8)


@pytest.mark.parametrize("count", [2, 4])
def test_chance_corners_in_border_keep_known_size_board(count):
    found = find_board(with_more_squares(count), 9, 6)
    assert distance(found, BOARD.corners(), 9, 6) < 0.2


@pytest.mark.parametrize("sd", [0.5, 3.0, 12.0])
def test_noise_sd_is_robust_to_edges(sd):
    rng = np.random.default_rng(9)
    squares = 60 + 120 * ((np.indices((400, 500)) // 40).sum(axis=0) % 2)
    image = squares + sd * rng.normal(size=squares.shape)
    assert noise_sd(image.astype(np.float32)) == pytest.approx(sd, rel=0.06)


@pytest.mark.parametrize("size", [(9, 6), None])
def test_known_size_is_passed_to_board_end_detection(monkeypatch, size):
    asked, ended = [], search.trim_paper_edges
    monkeypatch.setattr(
        search,
        "trim_paper_edges",
        lambda grid, level, known_size: (
            asked.append(known_size) or ended(grid, level, known_size)
        ),
    )
    search.search_image(BOARD.image(), size)
    assert set(asked) == {size is not None}
