"""Boards with missing corners, drifting lattices, and the reasons of rejections."""

import re

import cv2
import numpy as np
import pytest

from raxel.features import Detection, find_board
from raxel.features.boards import detect_boards, read_boards, write_boards
from raxel.features.chessboard.grids import Grid, is_nearly_complete, mask_corners
from raxel.features.chessboard.verdict import judge_grid
from raxel.features.lattice import (
    lattice_fault,
    misfit,
    orders,
    standard_order,
    symmetries,
)
from raxel.sets import load_set
from tests.chessboards import Board, facing
from tests.image_sets import COLUMNS, ROWS, write_drawn_set
from tests.raxel.features.chessboard.test_corner_precision import errors
from tests.raxel.features.chessboard.test_find_board import drawn, seen

INNER, ON_SIDE = 22, 4  # of the 9 x 6 corners of `drawn("straight")`


def covered(board, *numbers, size=13):
    """The image with a grey disc on some corners."""
    image = seen(board)
    for u, v in np.rint(board.corners()[list(numbers)]).astype(int).tolist():
        cv2.circle(image, (u, v), size, 128, -1)
    return image


@pytest.mark.parametrize("number", [INNER, ON_SIDE, 0])
def test_occluded_corner_is_missing(number):
    board = drawn("straight")
    found = find_board(covered(board, number), 9, 6)
    assert found.missing == 1
    truth = board.corners()
    lacks = np.isnan(found.corners[:, 0])
    # Of the two orders that keep the first cell's colour, the one that is meant.
    order = min(
        (o for o, size in symmetries(truth, 9, 6) if size == (9, 6)),
        key=lambda o: np.nansum(np.abs(o - found.corners)),
    )
    assert np.array_equal(order[lacks], truth[[number]])
    assert np.linalg.norm(order - found.corners, axis=1)[~lacks].max() < 0.2
    assert np.array_equal(np.isnan(found.sd), lacks)


def test_unknown_size_allows_hole_but_no_incomplete_side():
    board = drawn("straight")
    found = find_board(covered(board, INNER))
    assert (found.columns, found.rows, found.missing) == (9, 6, 1)
    found = find_board(covered(board, ON_SIDE))
    assert not found.found
    place = r"\((\d+), (\d+)\)"
    match = re.fullmatch(
        rf"53 of 54 corners of a 9 x 6 lattice detected \(missing near {place}\), 1 of "
        r"9 missing in row 1 from its top \(without a known size every side must be "
        r"complete\); give columns and rows",
        found.reason,
    )
    assert np.abs(np.array(match.groups(), float) - board.corners()[ON_SIDE]).max() < 2


@pytest.mark.parametrize(("gone", "whole"), [(3, True), (4, False)])
def test_nearly_complete_allows_third_of_row_missing(gone, whole):
    points = drawn("straight").corners().reshape(6, 9, 2)
    points[2, :gone] = np.nan
    assert is_nearly_complete(grid(points)) == whole


def test_half_occluded_side_is_rejected():
    board = drawn("straight")
    image = covered(board, 0, 1, 2, 3, 4)
    rejection = find_board(image, 9, 6)
    rule = "5 of 9 missing in row 1 from its top (at most a third of a row or"
    assert rule in rejection.reason
    turned = find_board(np.ascontiguousarray(image.T), 9, 6)
    assert "5 of 9 missing in column 1 from its left side" in turned.reason


def test_known_size_allows_half_of_a_side_missing():
    board = drawn("straight")
    image = covered(board, 0, 1, 2, 3)
    found = find_board(image, 9, 6)
    assert np.count_nonzero(np.isnan(found.corners[:, 0])) == 4
    assert np.nanmax(errors(found, board.corners())[0]) < 0.2
    assert not find_board(image, 9, 5).found


def test_known_size_counts_missing_corners_of_whole_board():
    gap = grid(drawn("straight").corners().reshape(6, 9, 2))
    gap.points[2, :7] = np.nan
    assert is_nearly_complete(gap, known_size=True)
    gap.points[0, 1:6] = np.nan  # chance corners may be the ends of an empty row
    assert not is_nearly_complete(gap, known_size=True)


@pytest.mark.parametrize("columns", [4, 9])
def test_strip_of_squares_is_rejected(columns):
    board = Board(columns, 1, facing(columns, 1, 40))
    for size in ((None, None), (columns, 3)):
        found = find_board(seen(board), *size)
        assert "is too small" in found.reason or "no lattice" in found.reason


def grid(points, sd=0.05, misfit=0.1):
    ones = np.ones(points.shape[:2])
    return Grid(points, sd * ones, misfit * ones, ones, ones)


def test_uncertain_corner_is_missing_or_named():
    board = drawn("straight")
    points = board.corners().reshape(6, 9, 2)
    unsure = grid(points)
    unsure.sd[2, 4] = np.inf
    verdict = judge_grid(unsure, board.image(), known_size=True)
    assert not verdict.fault
    assert np.argwhere(~verdict.certain.known).tolist() == [[2, 4]]
    unsure.sd[:2, :] = np.inf
    u, v = points[0, 0]
    fault = judge_grid(unsure, board.image(), known_size=True).fault
    assert fault.startswith(
        "19 of 54 corners are disturbed (occluder, edge of a shadow or reflection, or "
        "blur) (near "
        f"({u:.0f}, {v:.0f})"
    )
    unsure.sd[:3, :] = 0.41
    unsure.sd[2, 4] = 0.05
    fault = judge_grid(unsure, board.image(), known_size=True).fault
    assert "26 of 54 corners are uncertain by up to 0.41 px, limit 0.33 px" in fault
    assert "inf" not in fault


@pytest.mark.parametrize("seed", range(4))
def test_lattice_with_holes_has_same_order(seed):
    rng = np.random.default_rng(seed)
    board = drawn("bent" if seed % 2 else "turned")
    size, image = (board.columns, board.rows), board.image()
    whole = board.corners()
    holes = whole.copy()
    holes[rng.choice(len(whole), 6, replace=False)] = np.nan
    for index, order_size in orders(*size):
        if order_size == size:
            straight = index[standard_order(whole[index], *size, image)]
            with_holes = index[standard_order(holes[index], *size, image)]
            assert np.array_equal(straight, with_holes)
    assert lattice_fault(holes, *size, image) == ""
    known = np.isfinite(misfit(holes, *size)[0])
    apart = misfit(holes, *size)[1] - whole
    assert known.any()
    assert np.linalg.norm(apart[known], axis=1).max() < 3.0


def test_missing_corners_round_trip(tmp_path):
    drawn_set = write_drawn_set(tmp_path / "set")
    image_set = load_set(tmp_path / "set")
    corners = drawn_set[0].corners()
    corners[3] = np.nan
    sd = np.where(np.isnan(corners[:, 0]), np.nan, 0.1)
    board = detect_boards(image_set, views=image_set.views[:1])[0]._replace(
        detection=Detection(True, corners, COLUMNS, ROWS, sd=sd)
    )
    write_boards(tmp_path / "corners.json", image_set, "raxel", [board])
    again = read_boards(tmp_path / "corners.json", image_set)[0].detection
    assert again.missing == 1
    np.testing.assert_allclose(again.corners, corners, atol=1e-6)
    assert np.array_equal(np.isnan(again.sd), np.isnan(sd))


def test_mask_corners_removes_only_masked():
    full = [np.random.default_rng(k).random((4, 5)) for k in range(len(Grid._fields))]
    full[Grid._fields.index("points")] = np.dstack(full[:2])
    grid, gone = Grid(*full), np.zeros((4, 5), bool)
    gone[1, 2] = gone[3, 4] = True
    left = mask_corners(grid, gone)
    for before, after in zip(grid, left, strict=True):
        assert np.isnan(after[gone]).all()
        np.testing.assert_array_equal(after[~gone], before[~gone])
        assert not np.isnan(before).any()
