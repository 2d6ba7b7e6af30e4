"""Sign, norm and bounds of errors."""

from types import SimpleNamespace

import numpy as np
import pytest

from raxel.calibration.views.correspondence import BoardView
from raxel.evaluation import comparison as back_projection
from raxel.evaluation.board_corners import BoardCorners
from raxel.evaluation.coverage import beyond_boards
from raxel.evaluation.misfit import CorrectionFields, misfit
from raxel.evaluation.split_half import _difference
from raxel.geometry import on_plane, pose, transform
from tests.made_sets import BOARD, COLUMNS, PINHOLE, ROWS


def test_back_projection_error_is_hit_minus_corner(monkeypatch):
    points = BOARD.points()
    T = pose(np.eye(3), [-80.0, -60.0, 420.0])
    off = np.zeros(points.shape)
    off[5], off[20] = [2.0, 0.0], [0.0, -1.0]
    pixels = PINHOLE.project(transform(T, on_plane(points + off))).pixels
    monkeypatch.setattr(
        back_projection,
        "pose_from_non_central_rays",
        lambda rays, points: SimpleNamespace(T_camera_grid=T),
    )
    view = BoardView(pixels, points, COLUMNS, ROWS, "one")
    found = back_projection.back_projection(PINHOLE, view)
    np.testing.assert_allclose(found.errors_mm, off, atol=1e-6)


def test_board_corners_rms_is_a_distance_in_space():
    offsets = np.array([[3.0, 4.0, 0.0], [0.0, 0.0, 12.0]])
    found = BoardCorners(offsets, np.zeros((2, 3)), 1e-9, 0.3, 2)
    assert found.rms == pytest.approx(np.sqrt((25 + 144) / 2))


def test_largest_sd_is_outside_the_boards():
    pixels = np.column_stack([10.0 * np.arange(10), np.full(10, 5.0)])
    shapes = np.zeros((10, 2, 1))
    shapes[:, 0, 0] = 0.1
    shapes[2, 0, 0], shapes[7, 0, 0] = 0.8, 0.4
    fields = CorrectionFields(pixels, shapes, np.zeros((10, 2, 3)), np.eye(1))
    corners = np.array([[-1.0, 0], [45, 0], [45, 10], [-1, 10]])
    views = [BoardView(corners, corners, 2, 2)]
    own, seen = np.full(10, np.nan), pixels[:, 0] < 45
    found = beyond_boards(fields, np.eye(1), views, seen, own)
    assert (found.share, found.largest_px) == (0.5, pytest.approx(0.4))
    # The camera's own errors count, too: what is printed of both does not contradict.
    found = beyond_boards(fields, np.eye(1), views, seen, np.full(10, 0.6))
    assert (found.largest_px, found.under_px) == pytest.approx((0.6, 0.6))


@pytest.mark.parametrize("along", ["rows", "columns"])
def test_scatter_counts_rows_and_columns(along):
    """Residuals that go to and fro along one side of the lattice, and no other way."""
    j, i = np.mgrid[:9, :7]
    off = np.zeros((63, 2))
    off[:, 0] = 0.1 * (-1.0) ** (i if along == "rows" else j).ravel()
    score = SimpleNamespace(name="one", residuals_px=off, rms_px=0.1)
    found = misfit([score], [SimpleNamespace(rows=9, columns=7, sd=None)])
    # A second difference of these is four of their lengths, of the root of six.
    n, m = (9 * 5, 7 * 7) if along == "rows" else (7 * 7, 9 * 5)
    expected = 0.1 * 4 / np.sqrt(6) * np.sqrt(n / (n + m))
    assert found.scatter_px == pytest.approx(expected)


def test_difference_has_the_variance_within_parts():
    """Images that each require a value of one number, all as certain: 1, -1, 1, -1, 8.

    The squares of four about their mean are 4, of three ways, and 0.8 of the square of
    8 is what the fifth lies off, of one.
    """
    values = np.array([1.0, -1, 1, -1, 8])
    fifth = np.arange(5) == 4
    _, x, within, _ = _difference(np.ones((5, 1, 1)), values[:, None], fifth, 0.01)
    assert x**2 == pytest.approx(0.8 * 64)
    assert within == pytest.approx(4 / 3)
