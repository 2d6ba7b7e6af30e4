"""Detectors on rendered boards: accuracy, order, and rejection of other images."""

import cv2
import numpy as np
import pytest

from raxel.features import DETECTORS
from raxel.features import detector as opencv
from raxel.features.detector import chessboard_corners_sb, refine, verified
from raxel.features.lattice import (
    lattice_fault,
    misfit,
    order_of_clicks,
    spacing,
    standard_order,
    symmetries,
)
from tests.chessboards import Board, facing
from tests.raxel.features.chessboard.test_find_board import distance, seen

EVERY = pytest.mark.parametrize("detector", list(DETECTORS))
COUNTING = pytest.mark.parametrize("detector", ["raxel", "opencv-sb"])
POSES = {
    "straight": (facing(9, 6, 40), 0.0),
    "turned": (facing(9, 6, 34, turn=0.7), 0.0),
    "tilted": (facing(9, 6, 42, tilt=(0.05, -0.03), turn=-0.3), 0.0),
    "bent": (facing(9, 6, 48, turn=0.2), 0.6),
    "bent and tilted": (facing(9, 6, 44, tilt=(-0.03, 0.04), turn=3.0), 1.0),
}


def drawn(name, columns=9, rows=6):
    homography, bend = POSES[name]
    return Board(columns, rows, homography, bend=bend)


@EVERY
@pytest.mark.parametrize("name", POSES)
def test_detector_corners_are_accurate(detector, name):
    board = drawn(name)
    found = DETECTORS[detector](seen(board, 0.7, 0.0), 9, 6)
    assert (found.columns, found.rows) == (9, 6)
    assert distance(found, board.corners(), 9, 6) < 0.1


@EVERY
def test_detector_accepts_16_bit_images(detector):
    image = drawn("turned").image()
    deep = image.astype(np.uint16) * 16 + 3000
    shallow = DETECTORS[detector](image, 9, 6)
    found = DETECTORS[detector](deep, 9, 6)
    assert found.found
    # The stretch to 8 bit rounds differently; both are refined on the full depth.
    assert np.abs(found.corners - shallow.corners).max() < 0.02


@EVERY
@pytest.mark.parametrize("quarters", [1, 2])
def test_first_corner_is_stable_under_rotation(detector, quarters):
    board = drawn("tilted")
    image = board.image()
    expected = DETECTORS[detector](image, 9, 6).corners
    turned = np.ascontiguousarray(np.rot90(image, quarters))
    corners = DETECTORS[detector](turned, 9, 6).corners
    height, width = image.shape
    for _ in range(quarters):
        # np.rot90 takes (u, v) of a (height, width) image to (v, width - 1 - u).
        expected = np.column_stack((expected[:, 1], width - 1 - expected[:, 0]))
        height, width = width, height
    assert np.abs(corners - expected).max() < 0.05


@EVERY
def test_detector_without_board_gives_reason(detector):
    blank = np.random.default_rng(2).integers(0, 255, (240, 320), dtype=np.uint8)
    found = DETECTORS[detector](blank, 9, 6)
    assert not found.found
    assert found.corners.shape == (0, 2)
    assert "9 x 6" in found.reason


def test_opencv_detector_requires_size():
    rejection = DETECTORS["opencv"](drawn("straight").image(), None, None)
    assert not rejection.found
    assert "opencv-sb" in rejection.reason


@COUNTING
def test_upright_board_has_longer_side_as_columns(detector):
    image = np.ascontiguousarray(np.rot90(drawn("straight").image()))
    found = DETECTORS[detector](image, None, None)
    assert (found.columns, found.rows) == (9, 6)


def test_refine_corrects_outlier_corner():
    board = drawn("bent")
    image = seen(board, 0.7, 2.0, 4)
    start = board.corners()
    start[22] += (17.0, 6.0)
    start[0] -= (14.0, 10.0)
    assert (
        np.linalg.norm(refine(image, start, 9, 6) - board.corners(), axis=1).max() < 0.2
    )


BENT = drawn("bent")
CORNERS = BENT.corners()
HALF_ASIDE = 0.35 * spacing(CORNERS, 9, 6)[24]


@pytest.mark.parametrize("order", range(4))
def test_lattice_symmetries_are_valid(order):
    same_size = [o for o, size in symmetries(CORNERS, 9, 6) if size == (9, 6)]
    assert lattice_fault(same_size[order], 9, 6, BENT.image()) == ""
    assert verified(CORNERS, 9, 6, BENT.image()).found


@pytest.mark.parametrize(
    ("changed", "values", "fault"),
    [
        (7, (np.nan, 0), "not finite"),
        (0, (-0.6, 30), "outside"),
        (10, CORNERS[11], "less than a pixel apart"),
        ([10, 11], CORNERS[[11, 10]], "folded"),
        (24, CORNERS[24] + HALF_ASIDE, "out of line"),
    ],
)
def test_verified_rejects_faulty_lattice(changed, values, fault):
    broken = CORNERS.copy()
    broken[changed] = values
    rejection = verified(broken, 9, 6, BENT.image())
    assert fault in rejection.reason
    assert not rejection.found
    assert rejection.corners.shape == (0, 2)


def test_lattice_off_the_squares_is_rejected():
    flat = np.full_like(BENT.image(), 90)
    assert "dark and bright" in lattice_fault(drawn("straight").corners(), 9, 6, flat)
    whole = Board(10, 6, facing(10, 6, 40))
    lattice = whole.corners().reshape(6, 10, 2)
    skipping = np.delete(lattice, 4, axis=1).reshape(-1, 2)
    assert lattice_fault(skipping, 9, 6, whole.image()) != ""


def test_misfit_measures_outlier():
    board = drawn("tilted")
    assert misfit(board.corners(), 9, 6)[0].max() < 0.01
    moved = board.corners()
    step = spacing(moved, 9, 6)[30]
    moved[30] += (0.5 * step, 0)
    size, prediction = misfit(moved, 9, 6)
    assert np.argmax(size) == 30
    assert size[30] == pytest.approx(0.5, rel=0.15)
    assert np.linalg.norm(prediction[30] - board.corners()[30]) < 0.01 * step


@pytest.mark.parametrize("size", [(9, 6), (8, 6), (7, 7), (6, 6), (7, 5)])
def test_standard_order_is_independent_of_input_order(size):
    board = Board(*size, facing(*size, 36, tilt=(0.03, 0.02), turn=0.4))
    image = board.image()
    results = [
        order[standard_order(order, *size, image)]
        for order, order_size in symmetries(board.corners(), *size)
        if order_size == size
    ]
    assert len(results) == (8 if size[0] == size[1] else 4)
    for result in results:
        assert np.array_equal(result, results[0])


@pytest.mark.parametrize("turn", np.linspace(-3, 3, 7))
def test_asymmetric_board_keeps_first_corner(turn):
    board = Board(9, 6, facing(9, 6, 30, turn=turn))
    turned = board.corners()[::-1]
    order = standard_order(turned, 9, 6, board.image())
    assert np.array_equal(turned[order], board.corners())


def test_clicks_determine_first_corner():
    board = Board(8, 6, facing(8, 6, 40))
    lattice = board.corners()
    for order, size in symmetries(lattice, 8, 6):
        if size == (8, 6):
            clicks = order[[0, 7, 47, 40]] + 1.5
            assert np.array_equal(
                lattice[order_of_clicks(lattice, 8, 6, clicks)], order
            )


def test_sector_detector_is_independent_of_earlier_calls():
    """OpenCV's k-means uses a random generator shared by all calls."""
    image = drawn("tilted").image()
    after = []
    for calls in (1, 3):
        for _ in range(calls):
            chessboard_corners_sb(image, 9, 6)
        after.append(cv2.randu(np.zeros((1, 4)), 0, 1))
    assert np.array_equal(*after)


def test_refine_keeps_corner_if_restart_is_worse(monkeypatch):
    lattice = 20.0 * np.stack(np.meshgrid(np.arange(6), np.arange(5)), -1) + 30
    once = lattice.reshape(-1, 2)
    once[14] += [4, 0]  # a fifth of a step
    again = once.copy()
    again[14] += [5, 3]
    ends = iter([once, *3 * [again]])
    monkeypatch.setattr(opencv, "_at_saddles", lambda *_: next(ends).copy())
    found = opencv.refine(np.zeros((150, 180), np.uint8), once, 6, 5)
    np.testing.assert_array_equal(found, once)
    better = lattice.reshape(-1, 2) - np.where(np.arange(30) == 14, 3, 0)[:, None]
    ends = iter([once, *3 * [better]])
    found = opencv.refine(np.zeros((150, 180), np.uint8), once, 6, 5)
    np.testing.assert_array_equal(found[14], better[14])
