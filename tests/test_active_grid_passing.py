"""A hand in some of the pictures takes its pixels with it, and no others."""

from functools import cache

import cv2
import numpy as np
import pytest

from raxel.features.active_grid import decode
from raxel.features.active_grid.checks import outliers
from raxel.features.active_grid.checks import passing as passing_module
from raxel.features.active_grid.checks.levels import mended_levels
from raxel.features.active_grid.checks.passing import passing, passing_warnings
from raxel.features.active_grid.coding import read_coding
from raxel.features.active_grid.layout import PASSED
from raxel.features.active_grid.view import decode_checked
from raxel.sets import patterns_of, plan_of_cells
from tests.active_grids import drawn

SIZE = 200, 150
INNER = np.s_[4:-4, 4:-4]  # where blur has no border of the picture to mirror


@cache
def scene(steps=6, **changes):
    return drawn(size=SIZE, noise=2.0, blur=1.0, share=0.9, steps=steps, **changes)


def hand():
    """(H, W): how much of each pixel it covers."""
    v, u = np.indices(SIZE[::-1])
    inside = ((u - 90) / 24) ** 2 + ((v - 80) / 19) ** 2 < 1
    return cv2.GaussianBlur(inside.astype(float), (0, 0), 1.0)


def covered(one, names, grey):
    """The pictures, some of them with a hand of this grey value."""
    share, images = hand(), one.images.astype(float)
    for k, pattern in enumerate(one.patterns):
        if pattern.image.removesuffix(".png") in names:
            images[k] += share * (grey - images[k])
    return np.rint(images).astype(np.uint8)


def asked(one, images):
    """Decoded before and what passed, without what pictures say as a whole."""
    found = decode(images, one.patterns, one.grid)
    codes = read_coding(one.patterns, one.grid.monitor_px)
    return found, passing(images, codes, found)


def told(one, passed):
    (line,) = passing_warnings(passed, one.patterns, np.count_nonzero(passed.mask))
    return f" {line}"


def off(one, found, left=True):
    """Errors of inner pixels that are left, in standard deviations."""
    errors = np.abs(found.location - one.true) / found.sigma
    return errors[INNER][(found.mask & left)[INNER]]


SINES = [
    (6, ["phase-x-1"], 60, " phase-x-1.png:"),
    (6, ["phase-x-1", "phase-x-2"], 25, " phase-x-1.png and phase-x-2.png:"),
    (4, ["phase-x-1", "phase-x-2"], 25, " some of phase-x-0.png to phase-x-3.png:"),
    (3, ["phase-y-0"], 120, " and some of phase-y-0.png to phase-y-2.png:"),
]


@pytest.mark.parametrize(("steps", "names", "grey", "words"), SINES)
def test_a_hand_in_pictures_of_a_sine(steps, names, grey, words):
    one = scene(steps)
    found, passed = asked(one, covered(one, names, grey))
    assert off(one, found).max() > 15
    left = off(one, found, ~passed.mask)
    assert left.max() < 6
    assert words in told(one, passed)
    near = cv2.dilate((hand() > 0.01).astype(np.uint8), np.ones((17, 17))) > 0
    assert not passed.mask[~near].any()


def test_a_hand_that_turns_bits_over():
    """Darker than the black of the monitor: a wrong bit is read well."""
    one = scene()
    found, passed = asked(one, covered(one, ["gray-x-01"], 5))
    assert passed.mask[hand() > 0.9].all()
    assert off(one, found).max() > 100
    assert " gray-x-01.png or gray-x-01-inverse.png:" in told(one, passed)
    assert off(one, found, ~passed.mask).max() < 6


def without_inverses(steps=4, cells=6, **changes):
    every = patterns_of(plan_of_cells((200, 144), cells, steps))
    kept = [p for p in every if not p.inverse]
    how = {"size": SIZE, "noise": 2.0, "blur": 1.0, "share": 0.9, "patterns": kept}
    return drawn(**how | changes)


@pytest.mark.parametrize(("steps", "name"), [(4, "gray-y-01"), (6, "gray-x-01")])
def test_a_hand_that_turns_bits_over_that_have_no_inverse(steps, name):
    """Dark as the monitor's black, and large: a wrong bit is read well all over it."""
    one = without_inverses(steps)
    v, u = np.indices(SIZE[::-1])
    share = (((u - 95) / 50) ** 2 + ((v - 75) / 40) ** 2 < 1).astype(float)
    images = one.images.copy()
    k = next(k for k, p in enumerate(one.patterns) if p.image == f"{name}.png")
    images[k][share > 0] = 28
    found, passed = asked(one, images)
    assert np.count_nonzero(off(one, found) > 100) > 300
    left = off(one, found, ~passed.mask)
    assert left.max() < 6
    axis = name[5]
    assert f" some of gray-{axis}-00.png to gray-{axis}-02.png:" in told(one, passed)
    # Half a period about it may go as well.
    far = cv2.dilate(share, np.ones((33, 33))) == 0
    assert not passed.mask[far].any()


@pytest.mark.parametrize(
    ("name", "grey", "power"), [("white", 20, 0.45), ("black", 200, 2.2)]
)
def test_a_hand_in_white_or_black_costs_no_pixel(name, grey, power):
    one = without_inverses(cells=8)
    images, white, black = (
        np.rint(255 * (picture / 255) ** power).astype(np.uint8)
        for picture in (one.images, one.white, one.black)
    )
    levels, shown = {"white": white, "black": black}, (one.patterns, one.grid)
    usual = decode(images, *shown, **levels)
    level = levels[name] + hand() * (grey - levels[name].astype(float))
    levels[name] = np.rint(level).astype(np.uint8)
    found, told, lines = decode_checked(images, *shown, **levels)
    assert f"before the monitor in its {name} picture: " in lines[0]
    assert len(lines) == 1
    assert told.doubts == []
    # Edges of a code are in other places by a part of the blur.
    assert np.mean(found.mask != usual.mask) < 0.005
    assert np.abs(found.blur_px - usual.blur_px) < 0.1
    assert np.nanmax(np.abs(found.location - usual.location)) < 0.5


@pytest.mark.parametrize("grey", [60, 200])
def test_a_hand_in_a_sine_is_not_one_in_white(grey):
    one = without_inverses(3, cells=8)
    levels = {"white": one.white, "black": one.black}
    codes = read_coding(one.patterns, one.grid.monitor_px)
    for name in ("phase-x-1", "phase-y-0"):
        own, lines = mended_levels(covered(one, [name], grey), codes, levels)
        assert lines == []
        assert own is levels


@pytest.mark.parametrize("bright", [0.1, 0.2, 0.3])
def test_a_lamp_in_the_glass_is_no_hand_in_black(bright):
    """Behind a tone curve it lifts what is dark more than what is bright."""
    one = without_inverses(3, cells=12, noise=1.0)
    v, u = np.indices(SIZE[::-1])
    lamp = bright * np.exp(-((u - 130) ** 2 + (v - 70) ** 2) / 2 / 10**2)
    pictures = np.array([*one.images, one.white, one.black])
    light = (np.maximum(pictures - 28.0, 0) / 255 + lamp).clip(0, 1)
    *images, white, black = np.rint(255 * light**0.45).astype(np.uint8)
    levels = {"white": white, "black": black}
    codes = read_coding(one.patterns, one.grid.monitor_px)
    own, lines = mended_levels(images, codes, levels)
    assert lines == []
    assert own is levels


@pytest.mark.parametrize(
    ("jump", "at"), [(1.0, 0.05), (2.0, 0.05), (2.5, 0.05), (-2.0, -0.08)]
)
@pytest.mark.parametrize("lean", [0.0, 0.1, 0.3])
def test_a_break_of_the_surface_turns_no_bit_over(jump, lean, at):
    """Of whole periods too, where phases go on, and along the border of a period."""

    def broken(u, v, monitor):
        side = u + lean * v > at
        x = monitor[0] * (0.4 + u / 1.3) + side * jump * monitor[0] / 6
        return x, monitor[1] / 2 + monitor[0] * v / 1.4

    one = without_inverses(place=broken)
    assert not asked(one, one.images)[1].mask.any()


def test_a_break_that_crosses_the_only_border_in_sight_turns_no_bit_over():
    """No area beside it goes on anywhere, so that none is known to be sound."""

    def broken(u, v, monitor):
        side = u + 0.3 * v > -0.06
        x = monitor[0] * (0.5 + u / 4) - side * monitor[0] / 3
        return x, monitor[1] / 2 + monitor[0] * v / 1.4

    one = without_inverses(place=broken)
    assert not asked(one, one.images)[1].mask.any()


@pytest.mark.parametrize("power", [0.45, 1.0, 2.2])
@pytest.mark.parametrize("changes", [{}, {"steps": 4, "cells": 16}, {"steps": 3}])
def test_nothing_passed_before_steady_pictures(changes, power):
    """Whatever a response leaves of sines and makes of edges."""
    one = scene(**changes)
    images = np.rint(255 * (one.images / 255) ** power).astype(np.uint8)
    _, passed = asked(one, images)
    assert not passed.mask.any()
    assert passed.pictures == ()


def test_pixels_are_left_out_and_counted_and_linear_asks_none():
    one = scene(4)
    images = covered(one, ["phase-x-1", "phase-x-2"], 25)
    found, examined, lines = decode_checked(images, one.patterns, one.grid)
    count = np.count_nonzero(found.status == PASSED)
    assert found.counts()["something passed before it"] == count > 300
    assert np.isnan(found.location[found.status == PASSED]).all()
    assert f"{count} pixels are left out" in lines[0]
    # The rest is examined without them: nothing else is wrong.
    assert examined.errors.max() == 0
    assert examined.factors.max() == 1
    found, _, lines = decode_checked(images, one.patterns, one.grid, linear=True)
    assert lines == []
    assert not (found.status == PASSED).any()


def in_bands(one, percent, seed=5):
    """Light that is brighter and darker from row to row, otherwise in each picture."""
    begin = np.random.default_rng(seed).uniform(0, 1, (len(one.images), 1, 1))
    turns = np.arange(SIZE[1])[:, None] / 50 + begin
    light = 1 + percent / 100 * np.sin(2 * np.pi * turns)
    return np.clip(np.rint(one.images * light), 0, 255).astype(np.uint8)


def test_bands_of_light_are_in_sigma_and_told():
    one = scene()
    found, told, _ = decode_checked(in_bands(one, 3), one.patterns, one.grid)
    left = off(one, found)
    # By noise alone, and what neighbours share of it, 0.8 and 0.5 of them.
    assert np.mean(left < 3) > 0.93
    assert (np.mean(left < 4, axis=0) > 0.95).all()
    assert any("bands of a flickering light" in doubt.text for doubt in told.doubts)


def test_steady_light_has_no_bands():
    one = scene()
    assert asked(one, one.images)[1].bands == (1.0, 1.0)
    brighter = one.images * np.linspace(0.8, 1, len(one.images))[:, None, None]
    assert asked(one, np.rint(brighter).astype(np.uint8))[1].bands == (1.0, 1.0)


@pytest.mark.parametrize("name", ["gray-x-00-inverse", "gray-x-02-inverse"])
def test_a_hand_in_one_picture_of_the_code_is_no_blur(name):
    one = scene()
    usual = decode(one.images, one.patterns, one.grid, linear=True)
    found = decode(covered(one, [name], 15), one.patterns, one.grid, linear=True)
    assert found.blur_px == pytest.approx(usual.blur_px, rel=0.03)
    assert found.margin_px == usual.margin_px


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_pictures_without_noise_are_asked_without_a_warning(dtype):
    """All steps agree to the last digit, and a hand still shows."""
    one = drawn(size=SIZE, noise=0.0, blur=0.0, share=0.9, steps=6)
    _, passed = asked(one, one.images.astype(dtype))
    assert not passed.mask[INNER].any()
    _, passed = asked(one, covered(one, ["phase-x-1"], 120).astype(dtype))
    assert passed.mask[60:100, 75:105].all()


def test_blocks_of_rows_make_no_difference(monkeypatch):
    one = scene()
    images = covered(one, ["phase-x-1", "phase-x-4"], 120)
    whole = asked(one, images)[1]
    monkeypatch.setattr(outliers, "AT_ONCE", 7 * SIZE[0])
    parts = asked(one, images)[1]
    assert parts.pictures == whole.pictures
    np.testing.assert_array_equal(parts.mask, whole.mask)


@pytest.mark.parametrize("grey", [20, 120])
def test_of_large_pictures_every_third_pixel_says_where_to_look(grey, monkeypatch):
    one = scene()
    images = covered(one, ["phase-x-1", "gray-y-01"], grey)
    whole = asked(one, images)[1]
    monkeypatch.setattr(outliers, "WHOLE", 1000)
    monkeypatch.setattr(passing_module, "WHOLE", 1000)
    monkeypatch.setattr(outliers, "AT_ONCE", 5 * SIZE[0])
    large = asked(one, images)[1]
    assert set(large.pictures) == set(whole.pictures)
    both = np.count_nonzero(large.mask & whole.mask)
    assert both > 0.97 * np.count_nonzero(large.mask | whole.mask)
    assert not asked(one, one.images)[1].mask[INNER].any()


def test_the_dark_beside_the_monitor_is_not_asked():
    """Its noise is larger than that of the light, and is taken for bands."""
    one = drawn(size=(320, 240), noise=2.0, blur=1.0, share=0.4, steps=4)
    dark = ~np.isfinite(one.true[..., 0])
    noise = np.random.default_rng(5).normal(0, 17, (len(one.images), dark.sum()))
    one.images[:, dark] = np.clip(np.rint(one.images[:, dark] + noise), 0, 255)
    found, passed = asked(one, one.images)
    assert passed.bands == (1.0, 1.0)
    assert not (passed.mask & found.mask).any()
