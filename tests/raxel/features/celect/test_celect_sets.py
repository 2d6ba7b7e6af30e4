"""CELECT on image sets: clicks and contours by hand from set.yaml."""

import cv2
import numpy as np
import pytest

from raxel.errors import InputError
from raxel.features.boards import detect_boards
from raxel.features.celect.algorithm import find_celect
from raxel.sets import Chessboard, ImageSet, View, load_set, write_set
from tests.raxel.features.celect.test_celect import CLICKS, COLUMNS, IMAGE, ROWS, TRUTH

HIDDEN = np.hypot(*(np.indices(IMAGE.shape)[::-1] - TRUTH[2, 3][:, None, None])) < 22
COVERED = np.where(HIDDEN, 128, IMAGE).astype(np.uint8)


def as_points(array):
    return tuple(tuple(map(float, point)) for point in array)


def set_of(folder, *views, image=IMAGE):
    for view in views:
        cv2.imwrite(str(folder / view.image), image)
    height, width = image.shape
    target = Chessboard(COLUMNS, ROWS, 10.0)
    write_set(ImageSet("clicked", width, height, target, views, folder))
    return load_set(folder)


def test_set_clicks_give_refined_ordered_corners(tmp_path):
    clicks = as_points(np.roll(CLICKS, -2, axis=0))
    image_set = set_of(tmp_path, View("a.png", outer_corners=clicks), View("b.png"))
    found, without = (b.detection for b in detect_boards(image_set, "celect"))
    assert found.found
    expected = TRUTH[::-1, ::-1].reshape(-1, 2)
    assert np.linalg.norm(found.corners - expected, axis=1).max() < 0.3
    assert "outer_corners" in without.reason


def test_rejected_celect_board_has_contour_and_part():
    found = find_celect(COVERED, COLUMNS, ROWS, CLICKS)
    assert found.reason.startswith("column 4: ")
    assert len(found.partial.corners) == COLUMNS * ROWS - (ROWS - 2)
    truth = TRUTH[tuple(found.partial.indices.T)]
    assert np.linalg.norm(found.partial.corners - truth, axis=1).max() < 4


@pytest.mark.parametrize("late", [1, 3])
def test_celect_rotated_clicks_are_explained(late):
    found = find_celect(IMAGE, COLUMNS, ROWS, np.roll(CLICKS, late, axis=0))
    assert f"{ROWS} corners along the trace, expected {COLUMNS}" in found.reason
    assert found.reason.endswith("at the other end of the first row")


def test_set_contour_by_hand_is_used(tmp_path):
    by_hand = (("column 4", as_points(TRUTH[:, 3])),)
    view = View("a.png", outer_corners=as_points(CLICKS), contours=by_hand)
    image_set = set_of(tmp_path, view, image=COVERED)
    assert image_set.views[0] == view
    (board,) = detect_boards(image_set, "celect")
    assert not board.detection.reason.startswith("column 4: ")


@pytest.mark.parametrize(
    ("contours", "message"),
    [
        ({"row 1": [[1, 1], [2, 2]]}, "name a contour"),
        ({"side 1": [[1, 1]]}, "give the contour's corners"),
        ({"side 1": [[1, 1], [2]]}, "give a point"),
        ({"side 1": [[1, 1], [2, "a"]]}, "give a number"),
    ],
)
def test_set_rejects_invalid_contours(tmp_path, contours, message):
    import yaml

    set_of(tmp_path, View("a.png", outer_corners=as_points(CLICKS)))
    path = tmp_path / "set.yaml"
    data = yaml.safe_load(path.read_text())
    data["views"][0]["contours"] = contours
    path.write_text(yaml.safe_dump(data))
    with pytest.raises(InputError, match=rf"^.*views\[0\]\.contours.*{message}.*\Z"):
        load_set(tmp_path)
