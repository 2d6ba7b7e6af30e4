"""Folds: positions continue, their steps change, and sigma includes the bias."""

import numpy as np
import pytest

from raxel.features.active_grid import decode
from raxel.features.active_grid.errors import position_scatter, share_at_folds
from tests.active_grids import drawn

SCENE = {"size": (320, 240), "monitor": (800, 600), "steps": 6}


def facets(u, v, monitor):
    """Steps that change at four edges; `ridge` says where."""
    x, y = (0.5 + 0.9 * u) * monitor[0], 0.5 * monitor[1] + 0.9 * v * monitor[0]
    return x + 0.09 * monitor[0] * ridge(u, v), y


def ridge(u, v):
    turn = 2 * u + v
    return np.abs(turn - np.round(turn))


def caustic(u, v, monitor):
    """Positions reverse along two lines."""
    return (0.5 + 0.3 * np.sin(6 * u)) * monitor[0], (0.5 + 0.9 * v) * monitor[1]


def near_folds(one, found):
    """(N,) errors in standard deviations along x, within 4 px of a fold."""
    v, u = (np.indices(found.status.shape) - [[[120]], [[160]]]) / 320
    away = 320 / np.hypot(2, 1) * np.minimum(ridge(u, v), 0.5 - ridge(u, v))
    ratio = np.abs(found.location - one.true)[..., 0] / found.sigma[..., 0]
    ratio[:24] = ratio[-24:] = np.nan
    ratio[:, :24] = ratio[:, -24:] = np.nan
    return ratio[(away < 4) & np.isfinite(ratio)], ratio[
        (away > 12) & np.isfinite(ratio)
    ]


@pytest.mark.parametrize(("blur", "noise"), [(0.7, 1.0), (0.7, 3.0), (2.0, 1.0)])
def test_sigma_includes_fold_bias(blur, noise):
    one = drawn(**SCENE, place=facets, blur=blur, noise=noise, seed=3)
    near, far = near_folds(one, decode(one.images, one.patterns, one.grid))
    assert len(near) > 2000
    assert np.mean(near < 1) > 0.6
    assert np.mean(near < 3) > 0.96
    assert np.mean(far < 1) < 0.82


def test_sigma_includes_caustic_bias():
    one = drawn(**SCENE, place=caustic, blur=1.0, noise=2.0, seed=3)
    found = decode(one.images, one.patterns, one.grid)
    inner = np.s_[24:-24, 24:-24]
    ratio = np.abs(found.location - one.true)[inner] / found.sigma[inner]
    assert np.nanmean(ratio < 1) == pytest.approx(0.72, abs=0.07)
    assert np.nanmean(ratio < 3) > 0.985


def test_fold_bias_matches_formula():
    """Of a window of 7 x 7 pixels it is 6/7 of the change of step; less 8 px away."""
    ratio = np.mean(np.abs(np.arange(-3, 4))) / 2
    assert share_at_folds(4.0) == pytest.approx(ratio / (8 - 2 * ratio), rel=0.1)


@pytest.mark.parametrize("times", [0.5, 1.0, 3.0])
def test_scatter_above_sigma_is_measured(times):
    """Smaller scatter is ignored, and so is an axis without phases."""
    noise = np.random.default_rng(4).normal(0, 0.2 * times, (2, 64, 400))
    sigma = np.full((2, 64, 400), 0.2, np.float32)
    found = position_scatter(noise.astype(np.float32), sigma, np.array([1, 0]))
    np.testing.assert_allclose(found, [max(times, 1.0), 1.0], rtol=0.06)


def test_fold_bias_grows_with_blur():
    """Also where it reaches farther than the difference that tells the fold."""
    shares = [share_at_folds(variance) for variance in (1, 4, 25, 100, 625)]
    assert (np.diff([0, *shares]) > 0).all()
