"""Multi-frequency phase unwrapping, without a Gray code."""

from dataclasses import replace
from types import SimpleNamespace

import numpy as np
import pytest

from raxel.errors import InputError
from raxel.features.active_grid import decode
from raxel.features.active_grid.checks.diagnostics import examine
from raxel.features.active_grid.coding import (
    UNKNOWN,
    phase_separation,
    phase_weights,
    read_coding,
)
from raxel.features.active_grid.errors import Noise
from raxel.features.active_grid.phase_unwrapping import (
    Phases,
    _cells,
    _phases,
    fitted_periods,
)
from tests.active_grids import drawn, sines
from tests.raxel.features.active_grid.test_active_grid_checks import facets

USUAL = {"size": (240, 180), "blur": 1.0, "seed": 2}


def scene(periods, steps=4, **changes):
    return drawn(patterns=sines(periods, steps), **{**USUAL, "noise": 2.0, **changes})


def decoded_without_gray(one, patterns=None, images=None):
    images = one.images if images is None else images
    patterns = patterns or one.patterns
    found = decode(images, patterns, one.grid)
    return examine(images, patterns, one.grid, found).diagnostics


@pytest.mark.parametrize(
    ("periods", "steps"),
    [((8, 9), 4), ((1, 12), 3), ((5.3, 8.7), 5), ((1, 4, 20), 4), ((12.5, 0.9), 4)],
)
def test_unwrapped_positions_match_sigma(periods, steps):
    one = scene(periods, steps, noise=4.0)
    found = decode(one.images, one.patterns, one.grid)
    on = np.isfinite(one.true[..., 0])
    assert not found.mask[~on].any()
    assert np.mean(found.mask[on]) > 0.8
    ratio = np.abs((found.location - one.true)[found.mask] / found.sigma[found.mask])
    assert ratio.max() < 6
    assert 0.62 < np.mean(ratio < 1) < 0.74
    assert examine(one.images, one.patterns, one.grid, found).diagnostics == []


@pytest.mark.parametrize("smooth", [True, False])
def test_periods_are_correct_at_jumps_and_borders(smooth):
    one = scene((8, 9), place=facets)
    found = decode(one.images, one.patterns, one.grid, smooth=smooth)
    ratio = np.abs((found.location - one.true)[found.mask])
    assert found.mask.mean() > 0.5
    assert np.nanmax(ratio) < 3.0  # mm; a period is 33 mm


def test_ambiguous_periods_are_not_decoded():
    """The chance of a wrong period is below one in a million, or there is no place."""
    one = scene((11, 12), noise=9.0, vignetting=1.9)
    found = decode(one.images, one.patterns, one.grid, smooth=False, margin_px=0)
    on = np.isfinite(one.true[..., 0])
    assert found.counts()["the code cannot be read"] > 0.1 * on.sum()
    assert np.nanmax(np.abs((found.location - one.true)[found.mask]), initial=0) < 12


def test_beat_period_must_exceed_monitor():
    patterns = sines((8, 10))
    with pytest.raises(InputError) as fault:
        read_coding(patterns, (200, 144))
    text = str(fault.value)
    assert text.startswith(
        "patterns: axis x: sines of 25 px and 20 px repeat after 100 px of 200 px "
        "(sine-x-8-0.png to sine-x-10-3.png); add sines"
    )
    np.testing.assert_allclose(phase_separation(np.array([10.0, 8.0]))[4], 0, atol=1e-6)
    read_coding(sines((8, 10, 1)), (200, 144))


def exchanged(one, names, others):
    """Return the images, some of them exchanged."""
    every, images = [p.image for p in one.patterns], one.images.copy()
    own = [every.index(name) for name in (*names, *others)]
    images[own] = images[own[len(names) :] + own[: len(names)]]
    return images


def steps_of(axis, periods, count):
    return [f"sine-{axis}-{periods}-{k}.png" for k in range(count)]


@pytest.mark.parametrize(
    ("periods", "noise", "wrong", "names", "others"),
    [
        ((1, 60), 12.0, {}, [], []),
        ((8, 9), 2.0, {"periods": 7.0}, [], []),
        ((8, 9), 2.0, {"offset": 0.3}, [], []),
        ((8, 9), 2.0, {}, ["sine-y-8-1.png"], ["sine-y-8-3.png"]),
        ((8, 9), 2.0, {}, ["sine-y-9-1.png"], ["sine-y-9-3.png"]),
        ((8, 9), 2.0, {}, steps_of("x", 8, 4), steps_of("x", 9, 4)),
        ((1, 16), 2.0, {}, steps_of("x", 1, 4), steps_of("x", 16, 4)),
    ],
)
def test_undetermined_periods_are_reported(periods, noise, wrong, names, others):
    """By noise, a wrong length or offset, or exchanged images."""
    one = scene(periods, noise=noise)
    patterns = [replace(p, **wrong) if p.periods == 8 else p for p in one.patterns]
    diagnostic = decoded_without_gray(one, patterns, exchanged(one, names, others))[0]
    assert (diagnostic.code, diagnostic.invalidates) == ("periods-unknown", True)
    axis = "y" if names and names[0].startswith("sine-y") else "x"
    for count in periods:
        assert (
            f"sine-{axis}-{count}-0.png to sine-{axis}-{count}-3.png" in diagnostic.text
        )


@pytest.mark.parametrize("offset", [0.05, -1 / 12])
def test_common_offset_is_measured(offset):
    """It passed as sines that a response spoils, and shifted all places."""
    one = drawn(patterns=sines((8, 9), 6, offset), noise=2.0, **USUAL)
    begun_at_0 = [replace(pattern, offset=0.0) for pattern in one.patterns]
    diagnostics = decoded_without_gray(one, begun_at_0)
    assert len(diagnostics) == 2
    for diagnostic in diagnostics:
        assert diagnostic.invalidates
        given = float(
            diagnostic.text.split("give offset: ")[1].split(" ")[0].rstrip(",")
        )
        assert given == pytest.approx(offset % 1, abs=0.002)


def test_fine_sines_give_no_diagnostic():
    """Of windows that hold a period and a half the mean is turned round."""
    one = scene((1, 6, 40), 4, size=(200, 150), blur=0.4)
    assert not any(diagnostic.invalidates for diagnostic in decoded_without_gray(one))


@pytest.mark.parametrize("periods", [(8, 9), (3, 20), (1, 5, 14)])
def test_misfit_has_expected_degrees_of_freedom(periods):
    """Sums of squares in variances, of sines of unlike noise: one for each but one."""
    rng, periods = np.random.default_rng(8), np.float32(periods)
    sd = 0.002 * np.arange(1, len(periods) + 1)[::-1, None, None]
    place = rng.uniform(0.2, 0.8, (40, 50))
    turns = place * periods[:, None, None] + sd * rng.normal(size=(len(sd), 40, 50))
    variances = np.broadcast_to(sd**2, turns.shape)
    phases = Phases(
        np.float32(turns % 1), np.float32(variances), np.ones(place.shape, bool)
    )
    found = fitted_periods(phases, periods)
    assert found.misfit.mean() == pytest.approx(len(periods) - 1, rel=0.1)
    np.testing.assert_allclose(found.position / periods[0], place, atol=0.03)


def test_window_phase_variance_is_49_times_smaller():
    """Variances of phases by propagation: 2 / N of a grey value's, over amplitude^2."""
    shift = 2 * np.pi * np.arange(4) / 4
    images = [np.full((20, 30), 100 + 40 * np.sin(1.2 + s), np.float32) for s in shift]
    sines = SimpleNamespace(steps=range(4), weights=phase_weights(4))
    own, means = _phases(images, [sines], 0, Noise(6.0))
    for phases, pixels in ((own, 1), (means, 49)):
        variance = 2 / 4 * 6.0 / pixels / 40**2 / (2 * np.pi) ** 2
        np.testing.assert_allclose(phases.variances, variance, rtol=1e-4)
        np.testing.assert_allclose(phases.turns, 1.2 / (2 * np.pi), rtol=1e-5)


def test_phase_comparison_wraps_around():
    """Its own phase is just before it, or far off what its window sees."""
    periods = np.float32([8, 9])
    of_window = np.array([[3.004, 5.5, 5.5]])
    own = of_window - [[0.008, 0.008, 0.3]]
    seen = [
        Phases(
            np.float32([place % 1, place * 9 / 8 % 1]),
            np.full((2, 1, 3), np.float32(1e-6)),
            np.ones((1, 3), bool),
        )
        for place in (own, of_window)
    ]
    np.testing.assert_array_equal(_cells(*seen, periods, 1.0), [[12, 22, UNKNOWN]])
