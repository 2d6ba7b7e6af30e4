"""Corners of a board compared with the truth: position and order."""

import numpy as np
import pytest

from raxel.evaluation.cross_validation import in_order_of, in_place

COLUMNS, ROWS = 5, 4
LATTICE = np.stack(
    np.meshgrid(100.0 + 30 * np.arange(COLUMNS), 60.0 + 30 * np.arange(ROWS)), axis=-1
)
TRUTH = LATTICE.reshape(-1, 2)


def test_in_place_requires_order_and_reach():
    assert in_place(TRUTH + [5, 5], TRUTH, 8.0)
    assert not in_place(TRUTH + [6, 6], TRUTH, 8.0)
    assert in_place(TRUTH + [6, 6], TRUTH, 9.0)
    assert not in_place(TRUTH[::-1], TRUTH, 8.0)
    assert not in_place(TRUTH[:-1], TRUTH, 8.0)
    hole = TRUTH.copy()
    hole[3] = np.nan
    assert not in_place(hole, TRUTH, 8.0)


def test_in_place_rejects_corners_nearer_to_another():
    close = TRUTH / 5
    assert in_place(close + [2.5, 0], close, 8.0)
    assert not in_place(close + [3.5, 0], close, 8.0)


@pytest.mark.parametrize("down", [1, -1])
@pytest.mark.parametrize("across", [1, -1])
def test_in_order_of_accepts_any_first_corner(down, across):
    turned = LATTICE[::down, ::across].reshape(-1, 2)
    np.testing.assert_array_equal(in_order_of(TRUTH, turned, COLUMNS, ROWS), TRUTH)


def test_in_order_of_keeps_rows_of_square_boards():
    square = LATTICE[:, :ROWS]
    turned = square.transpose(1, 0, 2).reshape(-1, 2)
    best = in_order_of(square.reshape(-1, 2), turned, ROWS, ROWS).reshape(square.shape)
    across = np.diff(best, axis=1)
    np.testing.assert_array_equal(across[..., 0], 0)
