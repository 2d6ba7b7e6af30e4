"""Correlated noise and drift of the light, measured from the phase steps."""

import cv2
import numpy as np
import pytest

from raxel.features.active_grid import decode
from raxel.features.active_grid.checks.diagnostics import examine
from raxel.features.active_grid.checks.redundancy import step_scatter
from tests.active_grids import drawn

SCENE = {"size": (320, 240), "monitor": (800, 600), "blur": 1.0, "share": 1.3}


def windows_of_sines(count, noise, gains, seed=0):
    """(N, P) light of 300 windows, harmonics (C, P), as `step_scatter` has them."""
    rng = np.random.default_rng(seed)
    shape = 300, 7, 21
    phase = rng.uniform(0, 40, 300)[:, None, None] + 0.1 * np.indices(shape)[2]
    steps = 2 * np.pi * np.arange(count) / count
    light = 100 + 60 * np.sin(phase + steps[:, None, None, None])
    light = gains[:, None, None, None] * light + noise(rng, (count, *shape))
    second = 60 * np.exp(2j * phase)
    return light.reshape(count, -1), np.array([second.real, second.imag]).reshape(2, -1)


def white(rng, shape):
    return rng.normal(0, 2, shape)


def no_noise(rng, shape):
    return rng.uniform(size=1) * 0


def shared(rng, shape):
    """Each of 7 pixels in a row has the same noise."""
    return np.repeat(rng.normal(0, 2, (*shape[:-1], 3)), 7, axis=-1)


@pytest.mark.parametrize("count", [4, 5, 6, 8])
@pytest.mark.parametrize(("noise", "of_windows"), [(white, 1.0), (shared, 7.0)])
def test_window_scatter_measures_correlated_noise(count, noise, of_windows):
    light, harmonics = windows_of_sines(count, noise, np.ones(count))
    found = step_scatter(light, harmonics, np.full(light.shape[1], 4.0))
    assert found.of_windows == pytest.approx(of_windows, rel=0.3)
    assert found.of_one == pytest.approx(1.0, rel=0.1)
    np.testing.assert_allclose(found.drift, 0, atol=0.002)


@pytest.mark.parametrize("count", [4, 5, 6, 8])
def test_drift_of_each_step_is_estimated(count):
    gains = 1 + np.linspace(-0.02, 0.03, count)
    light, harmonics = windows_of_sines(count, white, gains)
    found = step_scatter(light, harmonics, np.full(light.shape[1], 4.0))
    np.testing.assert_allclose(found.drift, gains / gains.mean() - 1, atol=0.002)
    assert found.of_windows == pytest.approx(1.0, rel=0.3)
    waves = np.exp(-2j * np.pi * np.arange(count) / count)
    clean = [windows_of_sines(count, no_noise, g)[0] for g in (gains, np.ones(count))]
    ratio = np.angle((waves @ clean[0]) * np.conj(waves @ clean[1])) / (2 * np.pi)
    assert found.periods == pytest.approx(np.sqrt(np.mean(ratio**2)), rel=0.1)


@pytest.mark.parametrize("steps", [4, 6])
@pytest.mark.parametrize("what", ["jpeg", "drift"])
def test_sigma_includes_correlated_noise_and_drift(steps, what):
    one = drawn(**SCENE, steps=steps, noise=2.0, seed=steps)
    if what == "jpeg":
        files = [cv2.imencode(".jpg", image, [1, 90])[1] for image in one.images]
        images = np.array([cv2.imdecode(file, 0) for file in files])
    else:
        light = 1 + 0.1 * np.linspace(-0.5, 0.5, len(one.images))
        images = np.rint(one.images * light[:, None, None]).astype(np.uint8)
    found = decode(images, one.patterns, one.grid)
    checked = examine(images, one.patterns, one.grid, found)
    shared = decode(images, one.patterns, one.grid, shared=checked.factors)
    np.testing.assert_array_equal(shared.mask, found.mask)
    inner = np.s_[20:-20, 20:-20]
    ratio = (
        np.abs(found.location - one.true)[inner] / checked.widened(shared.sigma)[inner]
    )
    ratio = ratio[np.isfinite(ratio)]
    assert 0.62 < np.mean(ratio < 1) < 0.83
    assert np.mean(ratio < 2) > 0.93
    assert not any(diagnostic.invalidates for diagnostic in checked.diagnostics)
    assert (
        checked.diagnostics[0].code
        == {"jpeg": "correlated-noise", "drift": "drift"}[what]
    )
    as_stated = np.abs(found.location - one.true)[inner] / found.sigma[inner]
    assert np.nanmean(as_stated < 1) < 0.55


def test_noise_factor_is_per_axis():
    """On a plane, where sigma holds nothing but noise; pixels keep their places."""
    one = drawn(noise=3.0, tilt=0.0, vignetting=0.0)
    how = {"linear": True, "blur_px": 0.0, "smooth": False}
    found = decode(one.images, one.patterns, one.grid, **how)
    shared = decode(one.images, one.patterns, one.grid, **how, shared=(2.0, 3.0))
    times = (shared.sigma / found.sigma)[found.mask]
    np.testing.assert_allclose(np.median(times, axis=0), [2, 3], rtol=1e-3)


def test_s_curve_is_not_correlated_noise():
    """A tilted monitor: its harmonics are finer, and weaker, on one side."""
    one = drawn(**SCENE | {"blur": 0.0}, steps=5, tilt=0.4)
    light = np.tanh(2.5 * ((one.images / 255.0 - 0.1) / 0.7 - 0.5))
    light = np.array([cv2.GaussianBlur(own, (0, 0), 2.0) for own in light])
    light = 120 + 90 * light + np.random.default_rng(3).normal(0, 1, light.shape)
    images = np.rint(light).astype(np.uint8)
    found = decode(images, one.patterns, one.grid)
    checked = examine(images, one.patterns, one.grid, found)
    assert checked.factors.max() < 1.25
    assert not any(
        diagnostic.code == "correlated-noise" for diagnostic in checked.diagnostics
    )


def test_white_noise_does_not_change_sigma():
    for steps in (4, 5, 6):
        one = drawn(**SCENE, steps=steps, noise=3.0, seed=steps)
        found = decode(one.images, one.patterns, one.grid)
        checked = examine(one.images, one.patterns, one.grid, found)
        np.testing.assert_array_equal(checked.factors, 1)
        np.testing.assert_array_equal(checked.widened(found.sigma), found.sigma)
