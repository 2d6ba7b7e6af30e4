"""By how much windows and blur shift phases that bend, and noise those that do not."""

import numpy as np
from scipy.ndimage import gaussian_filter1d, uniform_filter1d

from raxel.features.active_grid.bias import OF_SIGMA, squared_bias
from raxel.features.active_grid.coding import read_coding
from raxel.features.active_grid.layout import SQUARE
from raxel.features.active_grid.undoing import no_ripple
from raxel.sets import patterns_of, plan_of_cells
from tests.active_grids import drawn

BLUR, WINDOW = 2.0, 7


def test_a_phase_that_bends_where_light_grows_is_shifted_so_far():
    """To the picture's border, by light that is blurred and a mean of 7 pixels."""
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
    middles = np.arange(SQUARE // 2, 320, SQUARE)
    due = OF_SIGMA * np.abs(shift[40:360])[middles]
    seen = np.sqrt(found[0][:, middles])
    np.testing.assert_allclose(seen, np.tile(due, (5, 1)), rtol=0.004)


def test_noise_bends_flat_phases_by_no_more_than_it_does_once_in_three_times():
    """Of a normal law a third is beyond 1 / OF_SIGMA of its standard deviation."""
    flat = {"tilt": 0.0, "vignetting": 0.0, "share": 1.2}
    one = drawn(size=(320, 240), steps=3, noise=3.0, **flat)
    codes = read_coding(one.patterns, one.grid.monitor_px)
    found = squared_bias(one.images, codes, 4.0, 0.0, 3.0, 2 * [no_ripple()])
    # Of 80 squares; those at the border go on as others do.
    inner = found[:, 1:-1, SQUARE:-SQUARE:SQUARE]
    assert 0.2 < np.mean(inner > 0) < 0.5
