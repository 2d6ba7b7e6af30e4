"""Pinhole calibration with a board that is not flat."""

import numpy as np
import pytest

from raxel.calibration.parametric.lens_formula import calibrate_pinhole
from raxel.calibration.views.correspondence import BoardShape
from raxel.cameras import PerspectiveCamera
from tests.board_scenes import BOARD, HEIGHT, WIDTH, board_poses, views_of

K = np.array([[150.0, 0, 118], [0, 138, 92], [0, 0, 1]])


def test_pinhole_estimates_bent_board():
    bent = BoardShape(
        BOARD.mean(axis=0), np.ptp(BOARD, axis=0) / 2, np.array([3.0, -2, 0, 0])
    )
    views = views_of(
        board_poses(3, 7), PerspectiveCamera(K, [], WIDTH, HEIGHT), noise=0.03,
        seed=4, solid=bent.points(BOARD),
    )  # fmt: skip
    found = calibrate_pinhole(views, WIDTH, HEIGHT)
    assert found.board.used == found.formula.board != ()
    sd = np.sqrt(np.diag(found.covariance))[:4]
    true = np.array([K[0, 0], K[1, 1], *K[:2, 2]])
    assert np.abs((found.values[:4] - true) / sd).max() < 4
    reported = found.camera.K
    np.testing.assert_allclose(
        [reported[0, 0], reported[1, 1], *reported[:2, 2]], found.values[:4], rtol=1e-12
    )
    assert sd.max() < 0.5


@pytest.mark.parametrize(("together_px", "low", "high"), [(0.0, 0.8, 1.3), (0.3, 2, 9)])
def test_pinhole_covariance_includes_common_errors(together_px, low, high):
    """A wave over each image, with its own height, as of a bent sheet."""
    camera, rng = PerspectiveCamera(K, [], WIDTH, HEIGHT), np.random.default_rng(6)
    wave = np.sin(BOARD @ [0.04, 0.03])[:, None]
    views = [
        view._replace(pixels=view.pixels + together_px * rng.normal(size=2) * wave)
        for view in views_of(board_poses(5, 12), camera, noise=0.03, seed=6)
    ]
    assert low < calibrate_pinhole(views, WIDTH, HEIGHT).error_factor < high
