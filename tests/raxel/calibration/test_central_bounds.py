"""How far rays pass from one point: its bounds, and what noise alone makes of it."""

from types import SimpleNamespace

import numpy as np
import pytest

from raxel.calibration.generic import central_test
from raxel.calibration.generic import central_test as central_views
from raxel.calibration.generic.central_test import _judged, _squared_distance
from raxel.calibration.views.correspondence import BoardView
from raxel.geometry.poses import tangent_bases


def test_centrality_bounds_cover_scatter():
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
def test_centrality_bounds_cover_pose_errors(apart, shared):
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
    square, reach = (
        np.sum(left**2) / count,
        central_test.NORMAL_QUANTILE_95 * deviations,
    )
    assert np.mean(squares - reach > square) < 0.05
    assert np.mean(squares + reach < square) < 0.05


def test_centrality_test_uses_one_pixel_per_cell(monkeypatch):
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


def test_pose_noise_is_no_distance():
    """Lines through one point, off by their own noise and by that of six numbers."""
    rng, count, squares = np.random.default_rng(1), 60, []
    u = rng.normal(size=(count, 3))
    follows = rng.normal(size=(count, 2, 6))
    lines = SimpleNamespace(
        used=np.ones(count, bool),
        offset_covariance=np.broadcast_to(np.eye(2), (count, 2, 2)),
        offset_of_poses=follows,
        covariance=0.25 * np.eye(6),
        axes=tangent_bases(u / np.linalg.norm(u, axis=1)[:, None]),
    )
    for _ in range(300):
        lines.offsets = rng.normal(size=(count, 2)) + follows @ rng.normal(0, 0.5, 6)
        squares.append(_squared_distance(None, lines, 1.0)[0])
    # 2 of the lines and 3 of the poses are noise; the point takes a twentieth of the 2.
    assert np.mean(squares) == pytest.approx(-0.1, abs=0.25)


def test_centrality_test_counts_independent_errors(monkeypatch):
    """Noise alone, each of its numbers six times over: all that it is judged by is as
    large by chance as it says; bounds hold for 95 % each."""
    rng, alike, square = np.random.default_rng(50), 6, 4.0
    judged, above, below = [], [], []
    for _ in range(1000):
        left, taken = alike * rng.chisquare([20, 5])
        central = SimpleNamespace(
            cost=left + taken, degrees_of_freedom=25 * alike, centre=None
        )
        lines = SimpleNamespace(
            cost=left, degrees_of_freedom=20 * alike, noise=1.0, used=np.ones(3, bool)
        )
        found = square + 0.5 * rng.standard_normal()
        monkeypatch.setattr(
            central_test, "_squared_distance", lambda *_, s=found: (s, 0.5)
        )
        judged.append(_judged(central, lines, alike, stated=True))
        above.append(judged[-1].at_least_mm ** 2 > square)
        below.append(judged[-1].at_most_mm ** 2 < square)
    # Of a thousand, uniform numbers' mean is known to 0.009, a twentieth to 0.007.
    for name in ("p_value", "p_of_noise"):
        values = [getattr(one, name) for one in judged]
        assert np.mean(values) == pytest.approx(0.5, abs=0.04)
        assert np.mean(np.less(values, 0.1)) == pytest.approx(0.1, abs=0.04)
    assert np.mean(above) == pytest.approx(0.05, abs=0.03)
    assert np.mean(below) == pytest.approx(0.05, abs=0.03)
