"""The page on extraction without clicks: its boards, its scores, its exercise."""

import numpy as np
import pytest

from chapters.ch03_planar_grids.ext_without_clicks.trials import requests as trials
from chapters.ch03_planar_grids.ext_without_clicks.trials.zoo_boards import (
    ANIMALS,
    zoo_board,
)
from raxel.features import Detection, Partial, find_board

CORNERS = np.stack(np.meshgrid(np.arange(9), np.arange(6)), axis=-1).reshape(-1, 2)
CORNERS = 20.0 * CORNERS + 30.0
SHAPE = (200, 260)


def part(rows, columns, turned=False):
    """A Partial of these rows and columns of CORNERS."""
    i, j = (a.ravel() for a in np.meshgrid(rows, columns, indexing="ij"))
    indices = np.column_stack([i, j]) - [min(rows), min(columns)]
    if turned:
        indices = indices[:, ::-1] * [1, -1] + [0, max(rows)]
    return Partial(CORNERS[9 * i + j], indices)


@pytest.mark.parametrize("turned", [False, True])
def test_a_part_in_order_counts_whatever_its_first_corner_is(turned):
    seen = part(range(6), range(1, 9), turned)
    share = trials.share_in_order(seen, CORNERS, (9, 6), SHAPE)
    assert share == pytest.approx(48 / 54)


def test_corners_out_of_order_do_not_count():
    seen = part(range(6), range(9))
    seen.indices[:9] += [0, 3]
    share = trials.share_in_order(seen, CORNERS, (9, 6), SHAPE)
    assert share == pytest.approx(45 / 54)
    assert trials.share_in_order(None, CORNERS, (9, 6), SHAPE) == 0


def test_scores_tell_right_from_wrong():
    near = Detection(True, CORNERS[::-1] + 0.3, 9, 6)
    assert trials.scored(near, CORNERS, 9, 6)["right"]
    far = near._replace(corners=CORNERS + [1.1, 0])
    assert trials.scored(far, CORNERS, 9, 6)["wrong"]
    smaller = Detection(True, CORNERS[:45], 9, 5)
    assert trials.scored(smaller, CORNERS, 9, 6)["wrong"]


@pytest.mark.parametrize("name", ["equidistance", "hyperboloid mirror"])
def test_boards_of_the_zoo_are_drawn_whole_and_found(name):
    assert name in ANIMALS
    board = zoo_board(name, np.random.default_rng(3))
    again = zoo_board(name, np.random.default_rng(3))
    assert np.array_equal(board.image, again.image)
    height, width = board.image.shape
    assert np.all((board.corners > 0) & (board.corners < [width, height]))
    found = find_board(board.image, board.columns, board.rows)
    assert found.found, found.reason
    assert trials.scored(found, board.corners, board.columns, board.rows)["right"]


def test_the_exercise():
    assert trials.least_in_order() == 46
