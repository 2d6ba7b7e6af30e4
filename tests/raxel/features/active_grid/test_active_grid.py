"""Decoder of active grids: positions, standard deviations, cells at edges, masks."""

import tracemalloc
from dataclasses import replace
from functools import cache

import numpy as np
import pytest

from raxel.features.active_grid import decode
from raxel.features.active_grid.errors import estimate_noise
from raxel.features.active_grid.phases import turns
from raxel.sets import ActiveGrid, Pattern, PatternPlan
from tests.active_grids import drawn
from tests.raised import raises_line


def decoded(scene, **options):
    return decode(scene.images, scene.patterns, scene.grid, **options)


@cache
def with_noise(noise):
    """One image for each noise: tilt 0.3 of the depth, 40 % less light at corners."""
    size = (560, 420)
    return drawn(size=size, noise=noise, tilt=0.3, vignetting=1.2, seed=1)


def share_of_lit(scene, found):
    return found.mask[np.isfinite(scene.true[..., 0])].mean()


def errors(scene, found):
    """(N, 2) mm over the pixels with a location."""
    return (found.location - scene.true)[found.mask]


@pytest.mark.parametrize("steps", [3, 4, 5, 6, 8])
@pytest.mark.parametrize("cells", [8, 1, (13, 4)])
def test_decode_without_noise_is_exact(steps, cells):
    """Cells beyond the power of two, codes longer than the monitor, 16 bit."""
    scene = drawn(cells=cells, steps=steps, dtype=np.uint16, monitor=(203, 151))
    found = decoded(scene, smooth=False, margin_px=0)
    on = np.isfinite(scene.true[..., 0])
    error = np.abs(errors(scene, found))
    assert np.mean(found.mask[on]) > 0.99
    assert not found.mask[~on].any()
    # 16 bit of 170 / 256 of their range leave this much of a cell to rounding.
    assert error.max() < 2e-5 * 300 / np.min(cells)


def test_location_unit_is_mm_or_px():
    scene = drawn(noise=1.0)
    in_px = decode(scene.images, scene.patterns, ActiveGrid(scene.grid.monitor_px))
    in_mm = decoded(scene)
    assert (in_px.unit, in_mm.unit) == ("px", "mm")
    assert in_mm.location.dtype == in_mm.sigma.dtype == np.float32
    pixel = np.divide(scene.grid.monitor_mm, scene.grid.monitor_px)
    good = in_mm.mask & in_px.mask
    # Second differences of rounded positions contribute to sigma.
    for name, rounding in (("location", 1e-5), ("sigma", 1e-3)):
        mm, px = getattr(in_mm, name)[good], getattr(in_px, name)[good]
        np.testing.assert_allclose(mm, px * pixel, rtol=rounding)


@pytest.mark.parametrize("options", [{}, {"smooth": False}, {"neighbours": True}])
@pytest.mark.parametrize("noise", [1.0, 3.0, 8.0])
def test_sigma_covers_two_thirds_of_errors(noise, options):
    """With tilt and vignetting, over the whole mask, noise from the images."""
    scene = with_noise(noise)
    found = decoded(scene, **options)
    assert_covered(scene, found)
    least = 0.7 if options == {"smooth": False} else 0.9
    assert share_of_lit(scene, found) > least


def assert_covered(scene, found):
    within = np.abs(errors(scene, found)) < found.sigma[found.mask]
    assert 0.66 < within.mean(axis=0).min() <= within.mean(axis=0).max() < 0.70


@pytest.mark.parametrize("cells", [8, 32])
@pytest.mark.parametrize("share", [1.0, 1.05, 1.3])
def test_pixels_outside_monitor_are_not_decoded(share, cells):
    """The monitor's border leaves the image, so that a wedge beyond it is narrow."""
    kind = {"tilt": 0.3, "share": share, "seed": 3}
    scene = drawn(size=(400, 300), cells=cells, noise=4.0, blur=2.0, **kind)
    found = decoded(scene)
    assert not found.mask[np.isnan(scene.true[..., 0])].any()
    assert np.abs(errors(scene, found)).max() < 0.2 * 300 / cells
    assert share_of_lit(scene, found) > 0.85


@pytest.mark.parametrize("shift", [0.0, 0.02, -0.02])
def test_cells_are_correct_at_blurred_edges(shift):
    """200 000 pixels, blur 2 px, noise 4; sines and code may be slightly shifted."""
    scene = drawn(size=(540, 405), noise=4.0, blur=2.0, shift=shift, seed=2)
    for options in ({}, {"smooth": False}):
        found = decoded(scene, margin_px=9, **options)
        assert np.abs(errors(scene, found)).max() < 0.15 * 300 / 8
    assert found.mask.size > 200_000
    assert share_of_lit(scene, decoded(scene, margin_px=9)) > 0.9


def test_gray_code_alone_gives_cell_centres():
    scene = drawn(size=(240, 180), plan=PatternPlan((5, 6), True), noise=2.0, blur=0.7)
    found = decoded(scene)
    cell = np.divide(scene.grid.monitor_mm, (32, 64))
    error = np.abs(errors(scene, found))
    assert np.quantile(error, 0.95, axis=0) == pytest.approx(0.475 * cell, rel=0.05)
    assert np.all(error.max(axis=0) < 1.1 * cell)
    sigma = found.sigma[found.mask]
    np.testing.assert_allclose(sigma, np.tile(cell / 12**0.5, (len(sigma), 1)), 1e-4)
    assert share_of_lit(scene, found) > 0.8


def test_single_axis_leaves_other_axis_nan():
    scene = drawn(noise=2.0)
    both = decoded(scene, noise=2.0)
    for axis, name in enumerate("xy"):
        own = [k for k, p in enumerate(scene.patterns) if p.axis == name]
        found = decode(
            scene.images[own], [scene.patterns[k] for k in own], scene.grid, noise=2.0
        )
        assert np.isnan(found.location[..., 1 - axis]).all()
        good = both.mask & found.mask
        assert good.mean() > 0.4
        np.testing.assert_array_equal(
            found.location[good, axis], both.location[good, axis]
        )


def test_strips_do_not_change_result():
    scene = drawn(size=(2500, 32), monitor=(1920, 1440), noise=2.0)
    found = decoded(scene)
    assert share_of_lit(scene, found) > 0.5
    assert np.abs(errors(scene, found) / found.sigma[found.mask]).max() < 6.5
    assert found.mask[16][1150:1350].all()


@pytest.mark.parametrize("with_white", [True, False])
def test_bits_without_inverse_use_mean_level(with_white):
    scene = drawn(size=(240, 180), noise=3.0, blur=1.0)
    own = [k for k, p in enumerate(scene.patterns) if not p.inverse]
    levels = {"white": scene.white, "black": scene.black} if with_white else {}
    found = decode(
        scene.images[own], [scene.patterns[k] for k in own], scene.grid, **levels
    )
    assert share_of_lit(scene, found) > 0.8
    assert np.abs(errors(scene, found)).max() < 0.1 * 300 / 8


def test_smoothing_stops_at_jumps():
    """Two halves that view distant positions, without a gap between them."""

    def halves(u, v, monitor):
        x = np.where(u < 0, 0.7 + 0.5 * u, 0.4 + 0.5 * u) * monitor[0]
        return x, (0.5 + 0.6 * v) * monitor[1]

    scene = drawn(size=(240, 180), place=halves, noise=2.0)
    found = decoded(scene, neighbours=True, fill=True, margin_px=0)
    assert np.nanmax(np.abs(found.location - scene.true) / found.sigma) < 6.5
    raw = decoded(scene, smooth=False, margin_px=0).sigma
    ratio = found.sigma[90, :, 1] / raw[90, :, 1]
    assert np.all(ratio[119:121] > 0.8)
    assert np.nanmin(ratio[117:123]) > 0.32
    assert np.all(ratio[20:110] < 0.2)


def test_noise_is_estimated_from_images():
    scene = drawn(size=(320, 240), noise=3.0)
    found = decoded(scene).noise
    level = np.array([60.0, 120.0, 180.0])
    np.testing.assert_allclose(found.floor + found.slope * level, 9 + 1 / 12, rtol=0.06)
    rng = np.random.default_rng(0)
    clean = drawn(size=(320, 240))
    photons = rng.normal(clean.images, np.sqrt(1 + 0.05 * clean.images.astype(float)))
    photons = np.clip(np.rint(photons), 0, 255).astype(np.uint8)
    found = decode(photons, clean.patterns, clean.grid).noise
    np.testing.assert_allclose(
        found.floor + found.slope * level, 1 + 0.05 * level, rtol=0.1
    )


def test_noise_estimate_ignores_overexposed_pixels():
    """They are all equal, whatever the scatter of their light."""
    rng = np.random.default_rng(1)
    images = rng.normal(np.linspace(40, 340, 400)[None, :], 4.0, (4, 300, 400))
    images = np.clip(np.rint(images), 0, 250).astype(np.uint8)
    found = estimate_noise(list(images), 250)
    level = np.array([60.0, 140.0, 220.0])
    np.testing.assert_allclose(found.at(level), 16 + 1 / 12, rtol=0.06)


def test_masked_pixels_are_counted_by_reason():
    scene = drawn(size=(240, 180), noise=2.0, share=0.7)
    images = scene.images.copy()
    images[:, 60:80, 100:130] = 255
    images[:, 100:101, 50:51] = 30
    found = decode(images, scene.patterns, scene.grid)
    counts = found.counts()
    assert sum(counts.values()) == found.mask.size
    assert counts["overexposed"] + counts["too little contrast"] > 600
    assert not found.mask[~np.isfinite(scene.true[..., 0])].any()
    assert counts["at the rim of the lit area"] > 1000
    assert not found.mask[100, 50]
    filled = decode(images, scene.patterns, scene.grid, fill=True)
    assert filled.mask[100, 50]
    error = filled.location[100, 50] - scene.true[100, 50]
    assert np.abs(error).max() < 6 * filled.sigma[100, 50].max()
    assert np.isnan(filled.location[70, 115]).all()


def without(scene, *numbers):
    keep = [k for k in range(len(scene.patterns)) if k not in numbers]
    return scene.images[keep], [scene.patterns[k] for k in keep]


@pytest.mark.parametrize(
    ("spoil", "message"),
    [
        (lambda s: (s.images[1:], s.patterns), "found 19 for 20 patterns"),
        (lambda s: without(s, 2, 3), "axis x: .* bit 1"),
        (lambda s: without(s, 13), "axis x: phase step 1 of 4"),
        (lambda s: without(s, *range(6)), "axis x: ambiguous periods"),
        (lambda s: ([*s.images, s.images[0]], [*s.patterns, s.patterns[0]]), "bit 0 "),
        (
            lambda s: ([*s.images[:-1], s.images[0][:-1]], s.patterns),
            r"phase-y-3.png: \(119, 160\)",
        ),
        (lambda s: (s.images.astype(float), s.patterns), "float64"),
        (lambda s: (s.images[:1], [Pattern("", "x", "gray", 3, bit=0)]), "axis x: "),
        (lambda s: ([], []), "found 0 for 0 patterns"),
    ],
)
def test_inconsistent_images_are_rejected(spoil, message):
    scene = drawn()
    images, patterns = spoil(scene)
    with raises_line(message):
        decode(images, patterns, scene.grid)


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_sigma_is_correct_with_black_level(dtype):
    """Shot noise only, above a black level: the variance is zero far above level 0."""
    depth = {np.uint8: 1, np.uint16: 257}[dtype]
    exact = drawn(size=(560, 420), vignetting=1.2, seed=1, dtype=np.uint16)
    light = exact.images / 257 - 20
    spread = np.sqrt(0.02 + 0.06 * np.maximum(light, 0))
    noisy = 20 + light + np.random.default_rng(2).normal(0, spread)
    images = np.rint(depth * noisy).clip(0, np.iinfo(dtype).max).astype(dtype)
    scene = replace(exact, images=images)
    for smooth in (False, True):
        assert_covered(scene, decoded(scene, smooth=smooth))


def test_code_longer_than_monitor_is_decoded():
    """Cells of a stated width: a code of ten bits on a monitor that needs eight."""
    plan = PatternPlan((10, 0), True, cell_px=(1.0, 0.0))
    scene = drawn(size=(160, 120), plan=plan, noise=1.0, share=0.2)
    found = decoded(scene)
    assert np.abs(errors(scene, found)[:, 0]).max() < 1.5 * 1.1
    assert found.cells[found.mask, 0].max() < 200
    assert replace(scene.patterns[0], cell_px=None) != scene.patterns[0]


def test_decoder_memory_is_bounded():
    """24 bytes a pixel, the result included; 3.6 Mpx are larger than a block."""
    scene = drawn()
    images = np.full((20, 5100, 700), 90, np.uint8)
    decode(scene.images, scene.patterns, scene.grid, threads=1)
    tracemalloc.start()
    found = decode(images, scene.patterns, scene.grid, threads=1)
    peak = tracemalloc.get_traced_memory()[1]
    tracemalloc.stop()
    assert found.counts()["too little contrast"] == 3_570_000
    assert peak / 3_570_000 < 24


def test_noise_estimate_ignores_dark_texture():
    """Noise is constant, from the rest, where dark areas scatter most."""
    rng = np.random.default_rng(3)
    ramp = np.linspace(30, 230, 400)[None, :] + np.zeros((4, 300, 1))
    sd = np.where(ramp < 50, 9.0, 2.0)
    images = np.clip(np.rint(rng.normal(ramp, sd)), 0, 255).astype(np.uint8)
    found = estimate_noise(list(images), 250)
    assert (found.slope, found.floor) == (0, pytest.approx(4 + 1 / 12, rel=0.15))


def test_turns_match_arctan2():
    angle = np.linspace(0, 1, 20001)[:-1]
    for x in angle[::7]:
        s, c = np.float32(np.sin(2 * np.pi * x)), np.float32(np.cos(2 * np.pi * x))
        error = abs(turns(s, c) - x)
        assert min(error, 1 - error) < 2e-7
    assert turns(np.float32(-1e-12), np.float32(1)) in (0, np.float32(1 - 2**-24))


def test_image_order_and_threads_do_not_change_result():
    scene = drawn(size=(150, 301), noise=3.0)
    order = np.random.default_rng(0).permutation(len(scene.patterns))
    first = decode(scene.images, scene.patterns, scene.grid, threads=1)
    other = decode(
        [scene.images[k] for k in order],
        [scene.patterns[k] for k in order],
        scene.grid,
        noise=first.noise,
        threads=3,
    )
    for name in ("location", "sigma", "cells", "status"):
        np.testing.assert_array_equal(getattr(first, name), getattr(other, name))


@pytest.mark.parametrize("noise", [1.0, 2.0])
def test_sigma_includes_window_bias(noise):
    """A curved surface, on which means over 7 x 7 have an error of up to a sigma.

    Some 2400 windows do not overlap, so that shares are known to 1 % only.
    """

    def bent(u, v, monitor):
        x = 0.5 + 0.7 * u + 0.6 * u * u + 0.2 * v * v
        return x * monitor[0], (0.5 + 0.8 * v + 0.3 * u * v) * monitor[1]

    scene = drawn(size=(400, 300), place=bent, noise=noise, seed=4)
    found = decoded(scene)
    error = errors(scene, found)[:, 0]
    sigma = found.sigma[found.mask][:, 0]
    assert np.median(error) > 0.25 * np.median(sigma)
    assert 0.65 < np.mean(np.abs(error) < sigma) < 0.71


def test_finest_bits_are_optional_for_long_periods():
    """Cells are then as wide as those of the finest available bit."""
    scene = drawn(size=(240, 180), plan=PatternPlan((5, 5), True, 4, (8.0, 8.0)))
    own = [k for k, p in enumerate(scene.patterns) if p.kind == "phase" or p.bit < 3]
    assert len(own) == len(scene.patterns) - 8
    patterns = [scene.patterns[k] for k in own]
    found = decode(scene.images[own], patterns, scene.grid, smooth=False)
    assert np.abs(errors(scene, found)).max() < 0.02 * 300 / 8
    assert share_of_lit(scene, found) > 0.8
