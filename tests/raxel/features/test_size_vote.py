"""The images of a set agree on the size of its board, or are rejected."""

import cv2
import numpy as np
import pytest

from raxel.errors import InputError
from raxel.features import find_board
from raxel.features.boards import Board as Looked
from raxel.features.boards import agree_on_size, detect_boards
from raxel.features.detector import Detection, rejected
from raxel.sets import load_set
from tests.chessboards import Board, facing
from tests.image_sets import HEIGHT, WIDTH, description, write_description

UNKNOWN = {"kind": "chessboard", "columns": None, "rows": None, "pitch_mm": 20.0}


def board_image(columns, rows, square=22, centre=(159.5, 119.5)):
    board = Board(columns, rows, facing(columns, rows, square, centre=centre))
    board = Board(columns, rows, board.homography, WIDTH, HEIGHT)
    return cv2.GaussianBlur(board.image(), (0, 0), 0.7)


def two_boards(size, other):
    left = board_image(*size, 13, (75, 119.5))
    right = board_image(*other, 13, (240, 119.5))
    return np.hstack([left[:, :155], right[:, 155:]])


def cut(image, columns=7):
    """The image of a 7 x 5 board without its left column of squares."""
    board = Board(columns, 5, facing(columns, 5, 22, centre=(159.5, 119.5)))
    image[:, : round(board.corners()[0, 0])] = 210
    return image


def written(folder, *images):
    folder.mkdir()
    for number, image in enumerate(images):
        cv2.imwrite(str(folder / f"view{number}.png"), image)
    write_description(folder, description(len(images), target=UNKNOWN))
    return load_set(folder)


def voted(image_set):
    return agree_on_size(image_set, detect_boards(image_set), "raxel")


def test_size_vote_overrules_smaller_board(tmp_path):
    whole = board_image(7, 5)
    image_set = written(tmp_path / "set", cut(whole.copy()), whole, whole, whole)
    boards, vote = voted(image_set)
    assert vote.votes == {
        (7, 5): ["view1.png", "view2.png", "view3.png"],
        (6, 5): ["view0.png"],
    }
    assert vote.retried == ["view0.png"]
    assert vote.found == []
    assert [board.detection.found for board in boards] == [False, True, True, True]
    assert boards[0].detection.reason.startswith(
        "it shows 6 x 5 corners, but 3 other images show 7 x 5: "
    )


def test_rejected_images_are_searched_again(tmp_path):
    """One lacks a corner of a side, one shows a second board."""
    whole = board_image(7, 5)
    lacks = whole.copy()
    u, v = np.rint(Board(7, 5, facing(7, 5, 22)).corners()[3] - [160, 120]).astype(int)
    cv2.circle(lacks, (int(u), int(v)), 7, 125, -1)
    both = two_boards((7, 5), (5, 4))
    assert set(find_board(both).complete) == {(7, 5), (5, 4)}
    image_set = written(tmp_path / "set", lacks, both, whole, whole)
    boards, vote = voted(image_set)
    assert vote.size == (7, 5)
    assert vote.found == vote.retried == ["view0.png", "view1.png"]
    assert all(board.detection.found for board in boards)
    assert [board.detection.missing for board in boards] == [1, 0, 0, 0]
    assert "5 x 4 in 1 (view1.png); 2 searched again" in vote.line()


@pytest.mark.parametrize("counts", [(1, 1), (3, 2)])
def test_images_of_two_boards_are_rejected(tmp_path, counts):
    images = [board_image(7, 5)] * counts[0] + [board_image(6, 4)] * counts[1]
    image_set = written(tmp_path / "set", *images)
    message = r"^.*boards of different sizes \(7 x 5 in .*6 x 4 in .*split the set\Z"
    with pytest.raises(InputError, match=message):
        voted(image_set)


def test_images_without_board_do_not_vote(tmp_path, monkeypatch):
    """Most images show no board; those that do agree."""

    def looked(image_set, detector, views, say=None):
        return [Looked(view, rejected(7, 5, "none"), None) for view in views]

    monkeypatch.setattr("raxel.features.boards.detect_boards", looked)
    empty = np.full((HEIGHT, WIDTH), 120, np.uint8)
    image_set = written(tmp_path / "set", *4 * [empty])
    first, *others = looked(image_set, "raxel", image_set.views)
    first = first._replace(detection=Detection(True, np.zeros((35, 2)), 7, 5))
    boards, vote = agree_on_size(image_set, [first, *others], "raxel")
    assert vote.votes == {(7, 5): ["view0.png"]}
    assert vote.retried == ["view1.png", "view2.png", "view3.png"]
    assert [board.detection.found for board in boards] == [True, False, False, False]
