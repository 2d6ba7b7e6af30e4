"""The page on extraction without clicks: its boards, its scores, its exercise."""

import numpy as np
import pytest

from chapters.ch03_planar_grids.ext_without_clicks.experiment import (
    ANIMALS,
    scored,
    zoo_board,
)
from raxel.features import Detection, find_board

CORNERS = np.stack(np.meshgrid(np.arange(9), np.arange(6)), axis=-1).reshape(-1, 2)
CORNERS = 20.0 * CORNERS + 30.0


def test_score_separates_correct_and_wrong_detections():
    near = Detection(True, CORNERS[::-1] + 0.3, 9, 6)
    assert scored(near, CORNERS, 9, 6)["right"]
    far = near._replace(corners=CORNERS + [1.1, 0])
    assert scored(far, CORNERS, 9, 6)["wrong"]
    smaller = Detection(True, CORNERS[:45], 9, 5)
    assert scored(smaller, CORNERS, 9, 6)["wrong"]


@pytest.mark.parametrize("name", ["equidistance", "hyperboloid mirror"])
def test_zoo_boards_are_complete_and_detected(name):
    assert name in ANIMALS
    board = zoo_board(name, np.random.default_rng(3))
    again = zoo_board(name, np.random.default_rng(3))
    assert np.array_equal(board.image, again.image)
    height, width = board.image.shape
    assert np.all((board.corners > 0) & (board.corners < [width, height]))
    found = find_board(board.image, board.columns, board.rows)
    assert found.found, found.reason
    assert scored(found, board.corners, board.columns, board.rows)["right"]
