"""By how much windows and blur shift phases that bend, and noise those that do not."""

import numpy as np
import pytest
from scipy.ndimage import gaussian_filter1d, uniform_filter1d

from raxel.features.active_grid.coding import BLOCK_PX, read_coding
from raxel.features.active_grid.errors import (
    BIAS_TO_SIGMA,
    WINDOW_VARIANCE,
    squared_bias,
)
from raxel.features.active_grid.lines import no_ripple
from raxel.sets import patterns_of, plan_of_cells
from tests.active_grids import drawn

BLUR, WINDOW = 2.0, 7
LINEAR = (no_ripple(), no_ripple())


def test_blur_bias_matches_prediction():
    """To the image's border, by light that is blurred and a mean of 7 pixels."""
    x = np.arange(-40, 360)
    turns = 0.1 + 0.0005 * x + 0.7e-5 * x**2
    wave = np.exp(0.002 * x + 2j * np.pi * turns)
    blurred = gaussian_filter1d(wave.real, BLUR) + 1j * gaussian_filter1d(
        wave.imag, BLUR
    )
    unit = blurred / np.abs(blurred)
    mean = uniform_filter1d(unit.real, WINDOW) + 1j * uniform_filter1d(
        unit.imag, WINDOW
    )
    shift = np.angle(mean * np.exp(-2j * np.pi * turns)) / (2 * np.pi)
    patterns = patterns_of(plan_of_cells((200, 144), 1, 4))
    patterns = [p for p in patterns if p.axis == "x"]
    step = np.exp(2j * np.pi * np.arange(4) / 4)
    light = (200 + 20 * (wave * step[:, None]).imag)[:, 40:360]
    images = [np.tile(np.float32(row), (160, 1)) for row in light]
    codes = read_coding(patterns, (200, 144))
    found = squared_bias(images, codes, 4.0, BLUR, 1e-9, [no_ripple()])
    middles = np.arange(BLOCK_PX // 2, 320, BLOCK_PX)
    expected = BIAS_TO_SIGMA * np.abs(shift[40:360])[middles]
    measured = np.sqrt(found[0][:, middles])
    np.testing.assert_allclose(measured, np.tile(expected, (5, 1)), rtol=0.004)


def test_noise_adds_little_bias_on_plane():
    """Of a normal law a third is beyond 1 / BIAS_TO_SIGMA of its standard deviation."""
    flat = {"tilt": 0.0, "vignetting": 0.0, "share": 1.2}
    one = drawn(size=(320, 240), steps=3, noise=3.0, **flat)
    codes = read_coding(one.patterns, one.grid.monitor_px)
    found = squared_bias(one.images, codes, 4.0, 0.0, 3.0, 2 * [no_ripple()])
    # Of 80 squares; those at the border go on as others do.
    assert 0.2 < np.mean(found[:, 1:-1, BLOCK_PX:-BLOCK_PX:BLOCK_PX] > 0) < 0.5


def test_window_bias_matches_curvature():
    """Second derivatives 1.2 and 0.4 of the monitor's width on 400 px."""

    def bent(u, v, monitor):
        x = 0.5 + 0.7 * u + 0.6 * u * u + 0.2 * v * v
        return x * monitor[0], (0.5 + 0.8 * v) * monitor[1]

    scene = drawn(size=(400, 300), place=bent, dtype=np.uint16)
    codes = read_coding(scene.patterns, scene.grid.monitor_px)
    squared = squared_bias(scene.images, codes, WINDOW_VARIANCE, 0.0, 0.1, LINEAR)
    found = np.sqrt(squared)[:, 1:-1]
    expected = BIAS_TO_SIGMA * WINDOW_VARIANCE / 2 * (1.2 + 0.4) * 8 / 400**2
    assert found[0, :, 32:-32] == pytest.approx(expected, rel=0.02)
    assert found[1].max() < 0.02 * expected


def test_facets_have_no_bias():
    """Their places jump by up to a third of a period, along x alone."""

    def facets(u, v, monitor):
        i, j = np.floor(u * 400 / 29), np.floor(v * 400 / 29)
        x = 0.5 + 0.7 * u + 0.014 * ((3 * i + 5 * j) % 4)
        return x * monitor[0], (0.5 + 0.8 * v + 0.2 * u * u) * monitor[1]

    scene = drawn(size=(400, 300), place=facets, dtype=np.uint16)
    codes = read_coding(scene.patterns, scene.grid.monitor_px)
    found = squared_bias(scene.images, codes, WINDOW_VARIANCE, 0.0, 0.1, LINEAR)
    assert np.quantile(found, 0.9) < 1e-8  # square of 1e-4 periods
