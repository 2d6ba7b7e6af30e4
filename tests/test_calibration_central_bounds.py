"""How far rays pass from one point: its bounds, and what noise alone makes of it."""

from types import SimpleNamespace

import numpy as np
import pytest

from raxel.calibration.generic import central_test, central_views
from raxel.calibration.generic.central_test import _squared_distance
from raxel.calibration.views.correspondence import BoardView
from raxel.geometry.poses import tangent_bases


def test_the_bounds_of_a_distance_are_as_wide_as_it_scatters():
    """Lines that pass a point by some three standard deviations of their own."""
    rng, count, found = np.random.default_rng(0), 60, []
    u = rng.normal(size=(count, 3))
    axes = tangent_bases(u / np.linalg.norm(u, axis=1)[:, None])
    true = rng.normal(0, 3, (count, 2))
    lines = SimpleNamespace(
        used=np.ones(count, bool),
        offset_covariance=np.broadcast_to(np.eye(2), (count, 2, 2)),
        offset_of_poses=np.zeros((count, 2, 6)),
        covariance=np.zeros((6, 6)),
        axes=axes,
    )
    for _ in range(300):
        lines.offsets = true + rng.normal(size=true.shape)
        found.append(_squared_distance(None, lines, 1.0))
    squares, deviations = np.transpose(found)
    assert np.mean(deviations) == pytest.approx(np.std(squares), rel=0.15)


@pytest.mark.parametrize(("apart", "shared"), [(0.0, 1.0), (3.0, 0.7)])
def test_bounds_of_a_distance_hold_where_lines_share_the_errors_of_poses(apart, shared):
    """Lines that pass a point by `apart`, off by their own noise and six numbers'."""
    rng, count, found = np.random.default_rng(3), 60, []
    u = rng.normal(size=(count, 3))
    follows, true = rng.normal(size=(count, 2, 6)), rng.normal(0, apart, (count, 2))
    follows[:, 0] += 0.5
    lines = SimpleNamespace(
        used=np.ones(count, bool),
        offset_covariance=np.broadcast_to(np.eye(2), (count, 2, 2)),
        offset_of_poses=follows,
        covariance=shared**2 * np.eye(6),
        axes=tangent_bases(u / np.linalg.norm(u, axis=1)[:, None]),
    )
    for _ in range(300):
        noise = rng.normal(size=(count, 2)) + follows @ rng.normal(0, shared, 6)
        lines.offsets = true + noise
        found.append(_squared_distance(None, lines, 1.0))
    squares, deviations = np.transpose(found)
    axes = np.swapaxes(lines.axes, 1, 2).reshape(-1, 3)
    left = true.ravel() - axes @ np.linalg.lstsq(axes, true.ravel())[0]
    square, reach = np.sum(left**2) / count, central_test.QUANTILE * deviations
    assert np.mean(squares - reach > square) < 0.05
    assert np.mean(squares + reach < square) < 0.05


def test_a_camera_is_tested_by_as_many_pixels_as_boards_have_cells(monkeypatch):
    """Errors of two pixels in one cell are alike: more of them would tell no more."""
    monkeypatch.setattr(
        central_views, "centrality_test", lambda points, seen, *_, **__: seen.sum()
    )
    columns, rows, cell = 12, 9, 40.0
    board = np.stack(np.meshgrid(np.arange(columns), np.arange(rows)), -1)
    board = board.reshape(-1, 2)
    views = [
        BoardView(cell * board + [60 + 10 * k, 50], 20.0 * board, columns, rows)
        for k in range(3)
    ]
    T = np.broadcast_to(np.eye(4), (3, 4, 4))
    found = central_views.centrality_of_views(views, 640, 480, T)
    assert found == pytest.approx(3 * (columns - 1) * (rows - 1), rel=0.15)
