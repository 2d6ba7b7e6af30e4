"""The clicks of set.yaml determine the order of detected corners."""

import cv2
import numpy as np
import pytest

from raxel.features.boards import detect_boards
from raxel.sets import load_set
from tests.image_sets import (
    COLUMNS,
    ROWS,
    description,
    write_description,
    write_drawn_set,
)

LAST = COLUMNS * ROWS - 1
OUTER = [0, COLUMNS - 1, LAST, LAST - COLUMNS + 1]


def detected(folder, *clicks):
    """The detections of a set whose views have these clicks, each (4, 2)."""
    views = [
        {"image": f"view{i}.png", "outer_corners": np.asarray(four).tolist()}
        for i, four in enumerate(clicks)
    ]
    write_description(folder, description(len(views), views=views))
    return [board.detection for board in detect_boards(load_set(folder))]


@pytest.mark.parametrize("late", [1, 3])
def test_clicks_in_other_order_are_rejected(tmp_path, late):
    """The order nearest to the clicks would show the board reversed."""
    first, second = write_drawn_set(tmp_path, tilts=((0, 0), (25, 0)))
    good = first.corners()[OUTER]
    begun_late = np.roll(second.corners()[OUTER], late, axis=0)
    right, wrong = detected(tmp_path, good, begun_late)
    assert np.abs(right.corners - first.corners()).max() < 0.1
    assert wrong.reason.startswith("outer_corners: the clicks do not fit the 7 x 5")


def test_clicks_outside_board_are_rejected(tmp_path):
    write_drawn_set(tmp_path, tilts=((0, 0),))
    (found,) = detected(tmp_path, [[5, 5], [15, 5], [15, 15], [5, 15]])
    assert not found.found


def test_clicks_reorder_standard_deviations(tmp_path):
    (board,) = write_drawn_set(tmp_path, tilts=((25, 0),))
    path = str(tmp_path / "view0.png")
    image = cv2.imread(path, cv2.IMREAD_GRAYSCALE)
    noise = np.random.default_rng(7).normal(0, 2, image.shape)
    cv2.imwrite(path, np.clip(image + noise, 0, 255).astype(np.uint8))
    outer = board.corners()[OUTER]
    (begun_first,) = detected(tmp_path, outer)
    (begun_last,) = detected(tmp_path, np.roll(outer, 2, axis=0))
    assert np.array_equal(begun_last.corners, begun_first.corners[::-1])
    assert np.array_equal(begun_last.sd, begun_first.sd[::-1])
    assert np.unique(begun_first.sd).size > 1
