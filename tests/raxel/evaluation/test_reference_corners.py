"""Detected boards compared with reference corners: errors and correctness."""

import json
from types import SimpleNamespace

import numpy as np
import pytest

from raxel.evaluation.cross_validation import corner_errors, is_right
from raxel.features.detector import Detection, rejected
from raxel.sets import Chessboard, ReferenceCorners, load_reference

COLUMNS, ROWS = 5, 4
CORNERS = Chessboard(COLUMNS, ROWS, 20.0).points() + (100, 80)
ALL = np.ones(len(CORNERS), bool)


def detected(corners, columns=COLUMNS, rows=ROWS):
    return Detection(True, corners, columns, rows)


def reference(corners=CORNERS, certain=ALL, tolerance_px=1.0):
    return ReferenceCorners(corners, certain, COLUMNS, ROWS, tolerance_px)


def turned(corners):
    return corners[::-1], COLUMNS, ROWS


def mirrored(corners):
    return corners.reshape(ROWS, COLUMNS, 2)[:, ::-1].reshape(-1, 2), COLUMNS, ROWS


def transposed(corners):
    lattice = corners.reshape(ROWS, COLUMNS, 2).transpose(1, 0, 2)
    return lattice.reshape(-1, 2), ROWS, COLUMNS


@pytest.mark.parametrize("order", [turned, mirrored, transposed])
def test_corner_errors_are_independent_of_order(order):
    off = np.random.default_rng(3).normal(0, 0.4, CORNERS.shape)
    errors = corner_errors(detected(*order(CORNERS + off)), reference())
    np.testing.assert_allclose(errors, np.linalg.norm(off, axis=1), atol=1e-12)


def test_uncertain_corners_do_not_count():
    corners, certain = CORNERS.copy(), ALL.copy()
    corners[3], certain[3] = np.nan, False
    found = CORNERS + (0.3, 0.4)
    found[3] += 50
    errors = corner_errors(detected(found), reference(corners, certain))
    np.testing.assert_allclose(errors, np.full(len(CORNERS) - 1, 0.5))


def test_board_is_correct_within_the_tolerance():
    errors = corner_errors(detected(CORNERS + (3, 4)), reference())
    assert is_right(errors, reference(tolerance_px=5.0))
    assert not is_right(errors, reference(tolerance_px=4.99))


def test_one_wrong_corner_makes_the_board_wrong():
    found = CORNERS.copy()
    found[7] += (0, 1.5)
    errors = corner_errors(detected(found), reference())
    assert errors.max() == pytest.approx(1.5)
    assert np.count_nonzero(errors) == 1
    assert not is_right(errors, reference())


def test_missing_boards_and_other_sizes_are_wrong():
    smaller = detected(CORNERS[:-COLUMNS], COLUMNS, ROWS - 1)
    for detection in (smaller, rejected(None, None, "nothing there")):
        errors = corner_errors(detection, reference())
        assert errors is None
        assert not is_right(errors, reference())


@pytest.mark.parametrize(
    ("spread_px", "tolerance_px"),
    [(None, 1), (0.4, 1), (0.5, 1), (0.7, 1.4), (1, 2), (1.2, 1)],
)
def test_tolerance_is_twice_the_spread_of_references(tmp_path, spread_px, tolerance_px):
    entry = {"corners": CORNERS.tolist(), "spread_max_px": spread_px}
    data = {"columns": COLUMNS, "rows": ROWS, "images": {"a.png": entry}}
    (tmp_path / "corners.json").write_text(json.dumps(data), "utf-8")
    described = SimpleNamespace(folder=tmp_path, reference="corners.json")
    found = load_reference(described)["a.png"]
    assert found.tolerance_px == pytest.approx(tolerance_px)


@pytest.mark.parametrize("key", ["uncertain", "missing"])
def test_listed_corners_are_not_certain(key, tmp_path):
    entry = {"corners": CORNERS.tolist(), key: [3, 11]}
    data = {"columns": COLUMNS, "rows": ROWS, "images": {"a.png": entry}}
    (tmp_path / "reference.json").write_text(json.dumps(data))
    given = SimpleNamespace(folder=tmp_path, reference="reference.json")
    found = load_reference(given)["a.png"]
    np.testing.assert_array_equal(np.flatnonzero(~found.certain), [3, 11])
    assert found.tolerance_px == 1.0
