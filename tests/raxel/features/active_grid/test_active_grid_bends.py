"""Sigma includes the bias of windows and blur where a surface bends sharply."""

import numpy as np
import pytest

from raxel.features.active_grid import decode
from raxel.features.active_grid.coding import plan_arrays, read_coding
from raxel.features.active_grid.errors import BIAS_TO_SIGMA, widen_at_bends
from tests.active_grids import drawn

SCENE = {"size": (320, 240), "monitor": (800, 600), "steps": 6, "blur": 1.0}


def ball(u, v, monitor):
    """Reflection in a ball: positions diverge towards its edge."""
    r = np.hypot(u, v) + 1e-9
    scale = 0.12 * np.tan(3.0 * r) / r
    return monitor[0] * (0.5 + scale * u), monitor[1] * 0.5 + monitor[0] * scale * v


def ripples(u, v, monitor):
    x, y = (0.5 + 0.8 * u) * monitor[0], 0.5 * monitor[1] + 0.8 * v * monitor[0]
    wave = 0.012 * monitor[0]
    return x + wave * np.sin(30 * u + 4 * v), y + wave * np.cos(30 * v)


def within(one, **options):
    found = decode(one.images, one.patterns, one.grid, **options)
    inner = np.s_[24:-24, 24:-24]
    ratio = np.abs(found.location - one.true)[inner] / found.sigma[inner]
    ratio = ratio[np.isfinite(ratio)]
    assert len(ratio) > 0.5 * one.images[0].size
    return [float(np.mean(ratio < k)) for k in (1, 2, 3)]


@pytest.mark.parametrize("place", [ball, ripples])
@pytest.mark.parametrize("noise", [1.0, 3.0])
def test_sigma_covers_errors_on_curved_mirror(place, noise):
    shares = within(drawn(**SCENE, place=place, noise=noise, seed=5))
    assert 0.65 < shares[0] < 0.85
    assert shares[1] > 0.95
    assert shares[2] > 0.97


def test_sigma_is_unchanged_on_plane():
    one = drawn(**SCENE, noise=3.0, share=1.3, seed=5)
    assert within(one)[0] == pytest.approx(0.683, abs=0.02)


@pytest.mark.parametrize("shape", [(128, 400), (30, 40)])
def test_bend_bias_extends_to_border(shape):
    """Next to pixels that are not decoded, and along the image's border."""
    y, x = np.indices(shape, np.float32)
    place = (0.01 * x * x - 0.02 * y * y)[None]
    place[0, :, : shape[1] // 3] = np.nan
    sigma = np.full_like(place, 1e-3)
    plan = plan_arrays(read_coding(drawn().patterns, (200, 144)), (200, 144), (1, 1))
    bias = np.zeros((1, 4, shape[1]), np.float32)
    widen_at_bends(place, sigma, bias, plan, 10.0, 0, shape[0])
    due = BIAS_TO_SIGMA * 10.0 * 0.02
    assert sigma[np.isfinite(place)] == pytest.approx(due, rel=0.02)
