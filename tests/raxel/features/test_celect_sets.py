"""CELECT on image sets: clicks and contours by hand from set.yaml."""

import cv2
import numpy as np
import pytest

from raxel.errors import InputError
from raxel.features.boards import detect_boards
from raxel.features.celect.algorithm import find_celect
from raxel.sets import load_set, write_set
from raxel.sets.model import Chessboard, ImageSet, View
from tests.raxel.features.test_celect import CLICKS, COLUMNS, IMAGE, ROWS, TRUTH

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


def test_clicks_of_the_set_give_refined_corners_in_their_order(tmp_path):
    clicks = as_points(np.roll(CLICKS, -2, axis=0))
    image_set = set_of(tmp_path, View("a.png", outer_corners=clicks), View("b.png"))
    found, without = (b.detection for b in detect_boards(image_set, "celect"))
    assert found.found
    expected = TRUTH[::-1, ::-1].reshape(-1, 2)
    assert np.linalg.norm(found.corners - expected, axis=1).max() < 0.3
    assert not without.found
    assert "outer_corners" in without.reason


def test_a_refused_board_names_the_contour_and_has_its_ordered_part():
    found = find_celect(COVERED, COLUMNS, ROWS, CLICKS)
    assert not found.found
    assert found.reason.startswith("column 4: ")
    assert len(found.partial.corners) == COLUMNS * ROWS - (ROWS - 2)
    truth = TRUTH[tuple(found.partial.indices.T)]
    assert np.linalg.norm(found.partial.corners - truth, axis=1).max() < 4


@pytest.mark.parametrize("late", [1, 3])
def test_clicks_begun_at_another_corner_say_where_the_second_one_goes(late):
    found = find_celect(IMAGE, COLUMNS, ROWS, np.roll(CLICKS, late, axis=0))
    assert not found.found
    assert f"{ROWS} corners along the trace, {COLUMNS} are wanted" in found.reason
    assert found.reason.endswith("the second click is the other end of the first row")


def test_a_contour_by_hand_from_the_set(tmp_path):
    by_hand = (("column 4", as_points(TRUTH[:, 3])),)
    view = View("a.png", outer_corners=as_points(CLICKS), contours=by_hand)
    image_set = set_of(tmp_path, view, image=COVERED)
    assert image_set.views[0] == view
    (board,) = detect_boards(image_set, "celect")
    assert not board.detection.reason.startswith("column 4: ")


@pytest.mark.parametrize(
    ("contours", "said"),
    [
        ({"row 1": [[1, 1], [2, 2]]}, "name a contour"),
        ({"side 1": [[1, 1]]}, "give the contour's corners"),
        ({"side 1": [[1, 1], [2]]}, "give a point"),
        ({"side 1": [[1, 1], [2, "a"]]}, "give a number"),
    ],
)
def test_faulty_contours_are_one_line(tmp_path, contours, said):
    import yaml

    set_of(tmp_path, View("a.png", outer_corners=as_points(CLICKS)))
    path = tmp_path / "set.yaml"
    data = yaml.safe_load(path.read_text())
    data["views"][0]["contours"] = contours
    path.write_text(yaml.safe_dump(data))
    with pytest.raises(InputError) as caught:
        load_set(tmp_path)
    assert "views[0].contours" in str(caught.value)
    assert "\n" not in str(caught.value)
    assert said in str(caught.value)
