"""Photographs of one set agree on the size of its board, or say that they do not."""

import cv2
import numpy as np
import pytest

from raxel.errors import InputError
from raxel.features import find_board
from raxel.features.boards import Board as Looked
from raxel.features.boards import agreed, detect_boards
from raxel.features.detector import Detection, refused
from raxel.sets import load_set
from tests.chessboards import Board, facing
from tests.image_sets import HEIGHT, WIDTH, description, write_description

UNKNOWN = {"kind": "chessboard", "columns": None, "rows": None, "pitch_mm": 20.0}


def photograph(columns, rows, square=22, centre=(159.5, 119.5)):
    board = Board(columns, rows, facing(columns, rows, square, centre=centre))
    board = Board(columns, rows, board.homography, WIDTH, HEIGHT)
    return cv2.GaussianBlur(board.image(), (0, 0), 0.7)


def two_boards(size, other):
    left = photograph(*size, 13, (75, 119.5))
    right = photograph(*other, 13, (240, 119.5))
    return np.hstack([left[:, :155], right[:, 155:]])


def cut(image, columns=7):
    """The picture of a 7 x 5 board without its left column of squares."""
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
    return agreed(image_set, detect_boards(image_set), "raxel")


def test_a_photograph_that_counts_too_few_is_outvoted(tmp_path):
    whole = photograph(7, 5)
    image_set = written(tmp_path / "set", cut(whole.copy()), whole, whole, whole)
    boards, vote = voted(image_set)
    assert vote.votes == {
        (7, 5): ["view1.png", "view2.png", "view3.png"],
        (6, 5): ["view0.png"],
    }
    assert vote.again == ["view0.png"]
    assert vote.found == []
    assert [board.detection.found for board in boards] == [False, True, True, True]
    assert boards[0].detection.reason.startswith(
        "it shows 6 x 5 corners, where 3 other photographs show 7 x 5: "
    )


def test_refused_photographs_are_looked_at_again(tmp_path):
    """One lacks a corner of a side, one shows a second board."""
    whole = photograph(7, 5)
    lacks = whole.copy()
    u, v = np.rint(Board(7, 5, facing(7, 5, 22)).corners()[3] - [160, 120]).astype(int)
    cv2.circle(lacks, (int(u), int(v)), 7, 125, -1)
    both = two_boards((7, 5), (5, 4))
    assert set(find_board(both).complete) == {(7, 5), (5, 4)}
    image_set = written(tmp_path / "set", lacks, both, whole, whole)
    boards, vote = voted(image_set)
    assert vote.size == (7, 5)
    assert vote.found == vote.again == ["view0.png", "view1.png"]
    assert all(board.detection.found for board in boards)
    assert [board.detection.missing for board in boards] == [1, 0, 0, 0]
    assert "5 x 4 by 1 (view1.png); 2 looked at again" in vote.line()


@pytest.mark.parametrize("counts", [(1, 1), (3, 2)])
def test_photographs_of_two_boards_are_refused_in_one_line(tmp_path, counts):
    images = [photograph(7, 5)] * counts[0] + [photograph(6, 4)] * counts[1]
    image_set = written(tmp_path / "set", *images)
    with pytest.raises(InputError) as fault:
        voted(image_set)
    told = str(fault.value)
    assert "\n" not in told
    assert "do not agree on the board's size: 7 x 5 in" in told
    assert "6 x 4 in" in told
    assert told.endswith("give columns and rows, or make a set for each board")


def test_photographs_without_a_board_vote_for_none(tmp_path, monkeypatch):
    """Most of them: of those that show one, all agree."""

    def looked(image_set, detector, views, say=None):
        return [Looked(view, refused(7, 5, "none"), None) for view in views]

    monkeypatch.setattr("raxel.features.boards.detect_boards", looked)
    empty = np.full((HEIGHT, WIDTH), 120, np.uint8)
    image_set = written(tmp_path / "set", *4 * [empty])
    first, *others = looked(image_set, "raxel", image_set.views)
    first = first._replace(detection=Detection(True, np.zeros((35, 2)), 7, 5))
    boards, vote = agreed(image_set, [first, *others], "raxel")
    assert vote.votes == {(7, 5): ["view0.png"]}
    assert vote.again == ["view1.png", "view2.png", "view3.png"]
    assert [board.detection.found for board in boards] == [True, False, False, False]
