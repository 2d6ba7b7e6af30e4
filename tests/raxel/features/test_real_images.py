"""Detectors on real images with reference corners.

Only where RAXEL_RECORDED names the folder of the recorded sets.
"""

import functools
import os
from pathlib import Path

import pytest

from raxel.evaluation.cross_validation import corner_errors, is_right
from raxel.features import DETECTORS, detect_boards, find_board
from raxel.sets import load_reference, load_set, read_image

RECORDED = Path(os.environ.get("RAXEL_RECORDED", "nowhere"))
SETS = [
    "mirror-omnidir",
    "fisheye-urban1",
    "ordinary-opencv-left",
    "wide-omnidir-left",
    "fisheye-deltille",
]
# A board that is not found takes seconds; the exhaustive search always takes long.
FEW = {"fisheye-deltille": ("0145.png", "0249.png")}
EVERY = {"raxel": 3, "opencv": 1, "opencv-sb": 4}

pytestmark = pytest.mark.skipif(
    not RECORDED.is_dir(), reason="RAXEL_RECORDED names no folder"
)


@functools.cache
def found(name, detector):
    """Boards and reference corners of a recorded set."""
    image_set = load_set(RECORDED / name)
    views = image_set.views[:: EVERY[detector]]
    if name in FEW and detector != "raxel":
        views = [view for view in image_set.views if view.image in FEW[name]]
    return detect_boards(image_set, detector, views), load_reference(image_set)


@pytest.mark.parametrize("detector", DETECTORS)
@pytest.mark.parametrize("name", SETS)
def test_detected_corners_match_reference(name, detector, record_property):
    boards, reference = found(name, detector)
    taken = [board for board in boards if board.detection.found]
    record_property("found", f"{len(taken)} of {len(boards)}")
    for board in taken:
        corners = reference[board.view.image]
        errors = corner_errors(board.detection, corners)
        assert is_right(errors, corners), board.view.image


@pytest.mark.parametrize("name", SETS)
def test_find_board_misses_no_board(name):
    boards, reference = found(name, "raxel")
    assert all(board.detection.found for board in boards)
    image_set = load_set(RECORDED / name)
    for board in boards[::2]:
        image = read_image(image_set, board.view)
        counted = find_board(image)
        corners = reference[board.view.image]
        assert counted.found, counted.reason
        assert is_right(corner_errors(counted, corners), corners)


@pytest.mark.parametrize("name", SETS)
def test_wrong_size_gives_board_as_part(name):
    image_set = load_set(RECORDED / name)
    image = read_image(image_set, image_set.views[0])
    columns, rows = image_set.target.columns, image_set.target.rows
    for size in ((columns - 1, rows), (columns, rows - 1), (columns + 1, rows)):
        partial = find_board(image, *size).partial
        assert len(partial.corners) == columns * rows


@pytest.mark.parametrize("detector", ["opencv", "opencv-sb"])
def test_missed_board_has_reason(detector):
    boards, _ = found("fisheye-deltille", detector)
    missed = [board.detection for board in boards if not board.detection.found]
    assert missed
    assert all(detection.reason for detection in missed)


def test_ordinary_lens_misses_no_board():
    boards, _ = found("ordinary-opencv-left", "opencv")
    assert all(board.detection.found for board in boards)
