"""Tones that a camera sets by what lies around are told, and nothing else is."""

from functools import cache

import cv2
import numpy as np
import pytest

from raxel.features.active_grid.checks.sample import sampled
from raxel.features.active_grid.checks.tones import tone_doubts
from raxel.features.active_grid.coding import read_coding
from raxel.features.active_grid.noise import Noise
from raxel.features.active_grid.view import decode_checked
from tests.active_grids import drawn


@cache
def scene(blur=1.0, **changes):
    return drawn(noise=1.5, blur=blur, **{"cells": 16, "share": 0.9} | changes)


def toned(one, strength, reach=20):
    """Held back where it is bright about a pixel, lifted where it is dark."""
    around = [cv2.GaussianBlur(p.astype(float), (0, 0), reach) for p in one.images]
    light = one.images * (1 + strength * (0.35 - np.array(around) / 255))
    return np.clip(np.rint(light), 0, 255).astype(np.uint8)


def told(one, images, patterns=None, blur=1.0):
    patterns = patterns or one.patterns
    codes = read_coding(patterns, one.grid.monitor_px)
    asked = images, patterns, codes, one.grid, Noise(2.25), (one.white, one.black)
    return list(tone_doubts(sampled(*asked), blur))


@pytest.mark.parametrize("steps", [3, 4, 6])
def test_local_tones_are_told_with_their_size(steps):
    one = scene(steps=steps)
    (doubt,) = told(one, toned(one, 0.6))
    assert not doubt.spoils
    (larger,) = told(one, toned(one, 1.2))
    shares = [float(d.text.split("up to ")[1].split(" %")[0]) for d in (doubt, larger)]
    # Means of what is around lie within 0.3 of their middle.
    assert 1.2 < shares[0] < 0.6 * 0.3 * 100
    assert shares[1] > 1.5 * shares[0]


def test_local_tones_are_told_without_inverse_pictures_too():
    one = scene(steps=4)
    kept = [k for k, p in enumerate(one.patterns) if not p.inverse]
    patterns = [one.patterns[k] for k in kept]
    assert len(told(one, toned(one, 0.8)[kept], patterns)) == 1
    assert told(one, one.images[kept], patterns) == []


@pytest.mark.parametrize("power", [0.45, 1.0, 2.2])
@pytest.mark.parametrize("changes", [{}, {"blur": 3.0, "share": 1.3}, {"share": 0.5}])
def test_whatever_answers_alike_everywhere_is_not_told(power, changes):
    one = scene(**changes)
    images = np.rint(255 * (one.images / 255) ** power).astype(np.uint8)
    assert told(one, images, blur=changes.get("blur", 1.0)) == []


def test_a_picture_that_is_brighter_as_a_whole_and_some_scattered_light_are_not():
    one = scene()
    gains = 1 + np.random.default_rng(8).normal(0, 0.03, (len(one.images), 1, 1))
    assert told(one, np.rint(one.images * gains).astype(np.uint8)) == []
    around = [cv2.GaussianBlur(p.astype(float), (0, 0), 30) for p in one.images]
    scattered = np.rint(0.95 * one.images + 0.05 * np.array(around))
    assert told(one, scattered.astype(np.uint8)) == []


def test_it_is_asked_of_what_is_decoded():
    one = scene(steps=4)
    _, examined, _ = decode_checked(toned(one, 0.8), one.patterns, one.grid)
    assert any("local tone mapping" in doubt.text for doubt in examined.doubts)
