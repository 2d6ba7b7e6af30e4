"""Positions behind a monitor with a gamma and a camera with a tone curve."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import numpy as np
import pytest

from raxel.features.active_grid import decode
from raxel.features.active_grid import response as harmonics
from raxel.features.active_grid.errors import Noise
from raxel.features.active_grid.lines import Ripple, basis_of, corrected_waves
from raxel.features.active_grid.response import (
    _covariance,
    _of_fit,
    _of_pieces,
    bound_of_shares,
    harmonics_of_powers,
    response_warnings,
)
from tests.active_grids import drawn

SIZE = 480, 360


def shown(gamma, steps, camera=lambda light: light, noise=1.5, **options):
    """A Scene whose light, 0 to 1, goes through a gamma and a camera's curve."""
    options = {"tilt": 0.25, "vignetting": 0.6, "seed": 3, "size": SIZE} | options
    scene = drawn(steps=steps, dtype=np.uint16, **options)
    rng = np.random.default_rng(steps)
    light = camera(np.clip((scene.images / 257.0 - 20) / 180, 0, None) ** gamma)
    images = 20 + 200 * light / light.max() + rng.normal(0, noise, light.shape)
    return replace(scene, images=np.clip(np.rint(images), 0, 255).astype(np.uint8))


@cache
def decoded(gamma, steps, linear=False, **options):
    scene = shown(gamma, steps, **options)
    found = decode(scene.images, scene.patterns, scene.grid, linear=linear)
    error = np.abs(found.location - scene.true)[found.mask] / found.sigma[found.mask]
    return found, [np.mean(error < k) for k in (1, 2, 3)]


def shares(psi, steps, waves):
    """Phases seen and true of harmonics {order: share of the first} in N steps."""
    k = 2 * np.pi * np.arange(steps)[:, None] / steps
    light = np.cos(psi + k) + sum(a * np.cos(m * (psi + k)) for m, a in waves.items())
    return 2 / steps * np.sum(light * np.exp(-1j * k), axis=0)


@pytest.mark.parametrize("offset", [0.0, 0.25, 0.1])
@pytest.mark.parametrize(
    ("steps", "waves", "terms"),
    [
        (3, {2: 0.28}, [0.28, 0, 0, 0]),
        (3, {2: 0.2, 5: 0.01, 8: 0.004}, [0.2, 0, 0.01, 0.004]),
        (4, {3: 0.05, 7: -0.01}, [0.05, 0, -0.01, 0]),
        (8, {7: -0.02}, [-0.02, 0, 0, 0]),
    ],
)
def test_ripple_correction_inverts_harmonics(steps, waves, terms, offset):
    """psi is 90 degrees behind the phase of a sine that begins with the offset."""
    psi = np.linspace(0.01, 2 * np.pi - 0.01, 500)
    begin = 1j * np.exp(-2j * np.pi * offset)
    wave = 0.7 * begin * shares(psi, steps, waves)
    share = np.float32([terms[0], 0, 0, 0, 0, 0])
    ripple = Ripple(steps, offset, 6, share, np.float32(terms[1:]))
    found = corrected_waves(ripple, wave, np.zeros(500), np.zeros(500))
    np.testing.assert_allclose(found, 0.7 * begin * np.exp(1j * psi), atol=3e-6)


def test_ripple_share_varies_over_image():
    psi, x = np.full(3, 1.0), np.array([-1.0, 0.0, 0.5])
    ripple = Ripple(
        4, 0.0, 6, np.float32([0.02, 0.03, 0, 0.01, 0, 0]), np.zeros(3, "f4")
    )
    for k, share in enumerate((0.0, 0.02, 0.0375)):
        wave = 1j * shares(psi, 4, {3: share})
        found = corrected_waves(ripple, wave, x, np.zeros(3))
        assert np.angle(found[k] / 1j) == pytest.approx(1.0, abs=3e-6)


@pytest.mark.parametrize("steps", [3, 4, 5, 6, 8])
def test_sigma_is_correct_behind_gamma(steps):
    found, within = decoded(2.2, steps)
    assert 0.65 < within[0] < 0.71
    assert 0.94 < within[1] < 0.97
    assert within[2] > 0.99
    assert found.counts()["at a break of the surface"] == 0
    usual = np.median(found.sigma[found.mask], axis=0)
    assert all(
        own.remaining < 0.3 * sd for own, sd in zip(found.response, usual, strict=True)
    )


@pytest.mark.parametrize("steps", [3, 4])
def test_uncorrected_gamma_shifts_positions(steps):
    """The fault, and by how much: dark is 10 of 180 grey levels of a Scene."""
    found, _ = decoded(2.2, steps)
    plain, within = decoded(2.2, steps, linear=True)
    assert within[0] < 0.45
    psi = 2 * np.pi * np.arange(64) / 64
    waves = np.fft.rfft(((10 + 85 * (1 + np.cos(psi))) / 180) ** 2.2)
    e = np.angle(1 + (waves[steps - 1] / waves[1]).real * np.exp(-1j * psi))
    error = np.sqrt(np.mean(e**2)) / (2 * np.pi)
    size = [own.size for own in found.response]
    assert size == pytest.approx([300 / 8 * error, 180 / 8 * error], rel=0.05)
    assert all(own.size is None for own in plain.response)


def test_linear_response_is_not_corrected():
    found, _ = decoded(1.0, 4)
    plain, _ = decoded(1.0, 4, linear=True)
    assert [own.ripple.steps for own in found.response] == [0, 0]
    np.testing.assert_array_equal(found.location, plain.location)
    np.testing.assert_array_equal(found.status, plain.status)
    assert np.nanmax(found.sigma / plain.sigma) < 1.05


def filling(light):
    """A camera that fills up."""
    return 1 - np.exp(-1.5 * light)


@pytest.mark.parametrize("steps", [3, 4])
def test_correction_varies_with_saturation(steps):
    """Its harmonics fall with the light towards the corners."""
    options = {"camera": filling, "noise": 1.0, "vignetting": 1.2}
    found, within = decoded(1.6, steps, **options)
    assert 0.63 < within[0] < 0.72
    assert np.abs(found.response[0].ripple.share[[3, 5]]).max() > 0.002


def like_an_s(steepness):
    """(light, 0 to 1) -> signal, with a toe and a shoulder."""
    most = np.tanh(steepness / 2)
    return lambda light: (np.tanh(steepness * (light - 0.5)) / most + 1) / 2


SOFT, HARD = like_an_s(2.0), like_an_s(4.0)


@pytest.mark.parametrize("camera", [None, SOFT, HARD])
@pytest.mark.parametrize("steps", [3, 4, 5])
def test_ripple_of_three_pixels_is_measured(steps, camera):
    """Means of seven pixels hold more than one of them."""
    gamma, curve = (1.0, camera) if camera else (2.2, lambda light: light)
    fine = {"size": (240, 180), "cells": int(65 / steps), "noise": 1.0}
    found, within = decoded(gamma, steps, camera=curve, **fine)
    assert not any(own.bound or own.remaining is None for own in found.response)
    assert within[0] > 0.65
    assert within[1] > 0.945
    assert within[2] > 0.985
    assert not response_warnings(found, False)


FINEST = {"cells": 36, "noise": 1.0, "size": (280, 210)}


def test_fine_stripes_give_response_bound():
    found, within = decoded(2.2, 4, **FINEST)
    assert [own.ripple.steps for own in found.response] == [0, 0]
    assert within[1] > 0.95
    (line, _) = response_warnings(found, False)
    assert line.startswith("axis x: positions may be shifted by up to ")
    assert "take six steps" in line
    linear, _ = decoded(1.0, 4, **FINEST)
    for own, other in zip(linear.response, found.response, strict=True):
        assert own.remaining < 0.1 * other.remaining


@pytest.mark.parametrize("blur", [0.0, 0.7])
@pytest.mark.parametrize("steps", [4, 5])
def test_response_bound_covers_s_curves(steps, blur):
    found, within = decoded(1.0, steps, camera=HARD, blur=blur, **FINEST)
    assert [own.bound for own in found.response] == [True, True]
    assert within[1] > 0.94
    assert response_warnings(found, False)


@pytest.mark.parametrize("cells", [8, 12])
def test_response_bound_ignores_dark_pixels(cells):
    """Its noise is larger than that of the light, and a pixel of it turns anyhow."""
    scene = shown(1.0, 4, **FINEST | {"cells": cells, "share": 0.2})
    dark = ~np.isfinite(scene.true[..., 0])
    noise = np.random.default_rng(5).normal(0, 3, (len(scene.images), dark.sum()))
    scene.images[:, dark] = np.clip(np.rint(scene.images[:, dark] + noise), 0, 255)
    found = decode(scene.images, scene.patterns, scene.grid)
    assert [own.bound for own in found.response] == [True, True]
    assert max(own.remaining for own in found.response) < 0.01


def answered(curve, dark=0.02):
    """(512,) harmonics of a response, in shares of the first."""
    psi = 2 * np.pi * np.arange(1024) / 1024
    waves = np.fft.rfft(curve(dark + (1 - dark) * (1 + np.cos(psi)) / 2)).real
    return waves / waves[1]


def test_response_bound_is_rms_of_sine(monkeypatch):
    """Phases that a response shifts by a sine of 0.03 rad, in the mean over all."""
    psi = np.linspace(0, 60, 600) + np.linspace(0, 9, 40)[:, None]
    steps = 2 * np.pi * np.arange(6) / 6
    images = [100 + 50 * np.cos(psi + step) for step in steps]
    monkeypatch.setattr(harmonics, "bound_of_shares", lambda *_: 0.03)
    found = harmonics.shift_bound(
        SimpleNamespace(shape=psi.shape, images=images),
        SimpleNamespace(steps=range(6), bits=()), Noise(1.0), 0.0,
    )  # fmt: skip
    due = np.sqrt(np.mean((0.03 * np.sin(6 * psi)) ** 2)) / (2 * np.pi)
    assert found == pytest.approx(due, rel=0.01)


def test_harmonics_of_powers_match_fourier_series():
    for power in (0.7, 1.8, 2.2):
        found = harmonics_of_powers([power], 8)[0, 1:]
        due = answered(lambda light, power=power: light**power, 0)[1:9]
        np.testing.assert_allclose(found, due, atol=3e-4)


@pytest.mark.parametrize("steps", [4, 5, 6, 8])
def test_response_bounds_are_valid_and_tight(steps):
    """In shares of a_1 that matter: 0.001 are less than 0.0002 of a period."""
    for power in (0.45, 0.7, 1.2, 1.8, 2.0, 2.2, 2.4):
        waves = answered(lambda light, power=power: light**power)
        error = abs(waves[steps - 1] - waves[steps + 1])
        bound = bound_of_shares(np.r_[0, waves[1 : steps - 1]], steps)
        assert error < bound + 1e-5
        assert bound < 20 * max(error, 0.0015)


def test_oblique_stripes_are_excluded():
    """From side to side of it, the phase of a period of 5.4 px seems to stand still."""
    found, within = decoded(2.2, 4, cells=36, noise=1.0, size=(240, 180))
    assert not any(own.ripple.steps for own in found.response)
    assert within[1] > 0.95


def test_blur_is_not_an_s_curve():
    """Of four steps, whose coarsest bit it leaves as it is. What is not known of it is
    a part of what it takes: the variance of the blur by half the slope's square."""
    psi = np.linspace(0, 40, 600) + np.linspace(0, 4, 40)[:, None]
    slope = np.hypot(40 / 599, 4 / 39)
    kept = np.exp(-((1.5 * slope) ** 2) / 2)
    steps = 2 * np.pi * np.arange(4) / 4
    found = harmonics.shift_bound(
        SimpleNamespace(
            shape=psi.shape,
            images=[100 + 50 * kept * np.cos(psi + step) for step in steps],
            difference=lambda _, at: np.full(len(at[0]), 100.0),
        ),
        SimpleNamespace(steps=range(4), bits=((0, 1),)), Noise(1.0), 1.5,
    )  # fmt: skip
    due = harmonics.BLUR_UNCERTAINTY * (1.5 * slope) ** 2 / 2
    assert found == pytest.approx(due / np.sqrt(2) / (2 * np.pi), rel=0.02)


def test_fit_covariance_propagates_to_phases():
    """Drawn from their covariance, at places all over the image and all phases."""
    rng, used = np.random.default_rng(6), np.array([0, 1, 4, 6, 7])
    root = 1e-3 * rng.normal(size=(5, 5))
    values = np.zeros((20_000, 9))
    values[:, used] = rng.normal(size=(20_000, 5)) @ root.T
    basis = basis_of(*rng.uniform(-1, 1, (2, 20_000)))
    one = np.exp(-1j * rng.uniform(0, 2 * np.pi, 20_000))
    share = np.sum(values[:, :6] * basis, axis=1) + 1j * values[:, 6]
    f = 1 + share * one + values[:, 7] * one**2 + values[:, 8] * one**3
    due = np.mean((np.angle(f) / (2 * np.pi)) ** 2)
    assert _of_fit(root @ root.T, used, basis) == pytest.approx(due, rel=0.06)


@pytest.mark.parametrize("spread", [0.0, 0.5])
def test_inconsistent_pieces_increase_covariance(spread):
    """Their coefficients scatter by so much in addition to noise of 1."""
    rng, usual = np.random.default_rng(7), np.full(2, 1e3)
    slopes, weights = rng.normal(size=(40, 32, 2)), np.ones(40)
    moment = np.linalg.inv(np.einsum("skp,skq->pq", slopes, slopes))
    found, stated = [], []
    for _ in range(200):
        own = spread * rng.normal(size=(40, 2, 1))
        rest = (slopes @ own)[..., 0] + rng.normal(size=(40, 32))
        found.append(moment @ np.einsum("skp,sk->p", slopes, rest))
        remaining = rest - slopes @ found[-1]
        stated.append(np.trace(_covariance(usual, remaining, slopes, weights)))
    assert np.mean(stated) == pytest.approx(
        np.trace(np.cov(np.transpose(found))), rel=0.3
    )


def test_residual_ripple_above_noise_is_measured():
    rng = np.random.default_rng(5)
    phase = rng.uniform(0, 2 * np.pi, (2000, 1)) + np.pi / 4 * np.arange(32)
    slopes = np.stack([np.sin(phase), np.cos(phase)], axis=2)
    weights = rng.uniform(50, 200, 2000)

    def kept(size):
        noise = rng.normal(0, 1, phase.shape) / np.sqrt(weights)[:, None]
        own = rng.normal(0, size, (2000, 2, 1))
        return _of_pieces((slopes @ own)[..., 0] + noise, slopes, weights)

    # Of two standard deviations, one in forty is beyond by chance.
    assert np.count_nonzero([kept(0.0) for _ in range(40)]) <= 4
    for size in (0.02, 0.05):
        assert np.sqrt(kept(size)) * 2 * np.pi == pytest.approx(size, rel=0.1)
