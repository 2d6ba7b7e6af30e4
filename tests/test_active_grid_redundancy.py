"""Steps of a sine that do not agree: which picture, how much, how wrong places are."""

from functools import cache

import cv2
import numpy as np
import pytest

from raxel.features.active_grid import decode
from raxel.features.active_grid.checks.doubts import examine
from raxel.features.active_grid.checks.redundancy import LIGHT, MOTION, mismatch
from raxel.features.active_grid.checks.sample import sampled
from raxel.features.active_grid.checks.steadiness import OF_SINE
from raxel.features.active_grid.coding import read_coding
from raxel.sets import PatternPlan
from tests.active_grids import drawn

USUAL = {"size": (280, 210), "noise": 2.0, "blur": 1.0, "share": 1.2}


@cache
def scene(steps=4, **changes):
    return drawn(**USUAL | changes, steps=steps)


def spoilt(one, name, change):
    """The pictures, one of them changed; change: of floats."""
    images = one.images.copy()
    k = [pattern.image for pattern in one.patterns].index(f"{name}.png")
    changed = np.rint(change(images[k].astype(float)))
    images[k] = np.clip(changed, 0, 255)
    return images


def rolled(px, axis):
    return lambda picture: np.roll(picture, px, axis)


def compressed(picture):
    """As a JPEG file of quality 20."""
    data = cv2.imencode(".jpg", picture, [cv2.IMWRITE_JPEG_QUALITY, 20])[1]
    return cv2.imdecode(data, cv2.IMREAD_GRAYSCALE).astype(float)


def examined(one, images):
    """Decoded, Mismatch along x and what is said of it."""
    found = decode(images, one.patterns, one.grid)
    codes = read_coding(one.patterns, one.grid.monitor_px)
    sample = sampled(images, one.patterns, codes, one.grid, found.noise, ())
    told = examine(images, one.patterns, one.grid, found)
    return found, mismatch(sample, 0, found.noise), told


INNER = np.s_[10:-10, 10:-10, 0]  # where no picture's border was mirrored or moved


def error(one, found):
    """RMS along x in periods."""
    off = (found.location - one.true)[INNER]
    return np.sqrt(np.nanmean(off**2)) / (one.grid.monitor_mm[0] / 8)


@cache
def clean_error(steps):
    one = scene(steps)
    return error(one, decode(one.images, one.patterns, one.grid))


CHANGES = {
    "a third brighter": ("phase-x-1", lambda p: 1.3 * p, LIGHT, 0.3),
    "darker": ("phase-x-2", lambda p: 0.87 * p, LIGHT, -0.13),
    "a little brighter": ("phase-x-3", lambda p: 1.03 * p, LIGHT, 0.03),
    "moved": ("phase-x-2", rolled(2, 1), MOTION, 2.0),
    "moved a little": ("phase-x-1", rolled(1, 1), MOTION, 1.0),
}


@pytest.mark.parametrize("steps", [4, 5])
@pytest.mark.parametrize("name", CHANGES)
def test_the_picture_its_change_and_the_error_by_it(steps, name):
    picture, change, kind, size = CHANGES[name]
    one = scene(steps)
    found, off, told = examined(one, spoilt(one, picture, change))
    named = {one.patterns[k].image for k in off.pictures}
    # Of four steps, a shift of the opposite one backwards does the same.
    assert f"{picture}.png" in named
    assert len(named) <= (2 if kind == MOTION and steps == 4 else 1)
    assert off.kind == kind
    # A shift is found by differences over two pixels of the blurred picture.
    assert off.size == pytest.approx(size, rel=0.12 if kind == MOTION else 0.05)
    by_it = np.sqrt(error(one, found) ** 2 - clean_error(steps) ** 2)
    assert off.periods == pytest.approx(by_it, rel=0.2 if kind == MOTION else 0.15)
    stated = OF_SINE * off.by_one * one.grid.monitor_mm[0] / 8
    assert told.errors[0] == pytest.approx(stated, rel=1e-3)
    assert f"{picture}.png" in told.doubts[0].text
    far = off.periods > 0.01  # a hundredth of a period, and many standard deviations
    assert told.doubts[0].spoils == (far or name in ("a third brighter", "moved"))


@pytest.mark.parametrize(
    ("noise", "change"),
    [
        (0.5, compressed),
        (2.0, compressed),
        (1.0, lambda p: 1.01 * p),
        (0.5, rolled(1, 0)),
        (2.0, lambda p: p + 4),
    ],
)
def test_sigma_holds_what_is_not_refused(noise, change):
    one = scene(noise=noise)
    found, _, told = examined(one, spoilt(one, "phase-x-1", change_of(change)))
    assert not any(doubt.spoils for doubt in told.doubts)
    images = spoilt(one, "phase-x-1", change_of(change))
    found = decode(images, one.patterns, one.grid, shared=told.factors)
    sigma = told.widened(found.sigma)[INNER]
    off = np.abs((found.location - one.true)[INNER]) / sigma
    off = off[np.isfinite(off)]
    assert 0.6 < np.mean(off < 1) < 0.85
    assert np.mean(off > 6) < 1e-3


def change_of(change):
    return (lambda p: change(p.astype(np.uint8))) if change is compressed else change


FAIR = {
    "tilt and vignetting": ({"tilt": 0.4, "vignetting": 1.5}, 2.2),
    "one cell": ({"cells": 1}, 0.45),
    "fine sines": ({"plan": PatternPlan((5, 5), False, 4, (16.0, 16.0))}, 2.2),
    "16 bit": ({"dtype": np.uint16}, 0.45),
}


@pytest.mark.parametrize("name", FAIR)
def test_good_steps_agree(name):
    """Whatever the tone curve, and lights that differ by half a percent spoil none."""
    changes, power = FAIR[name]
    one = scene(**changes)
    top = np.iinfo(one.images.dtype).max
    images = np.rint(top * (one.images / top) ** power).astype(one.images.dtype)
    assert examined(one, images)[2].doubts == []
    gains = 1 + 0.005 * np.sin(np.arange(len(images)))
    unsteady = (images * gains[:, None, None]).astype(images.dtype)
    assert not any(doubt.spoils for doubt in examined(one, unsteady)[2].doubts)


def test_facets_seen_at_angles_of_their_own_agree():
    """Light, and what scatters into it, change with the facet; the curve does not."""
    one = scene(noise=0.5, share=1.4)
    v, u = np.indices(one.images.shape[1:]) // 40
    light, scattered = 0.6 + 0.1 * ((3 * u + v) % 4), 4.0 * ((u + 2 * v) % 5)
    images = 255 * ((light * one.images + scattered) / 255) ** 0.5
    images = np.rint(images).astype(np.uint8)
    assert not examined(one, images)[2].errors.any()


@pytest.mark.parametrize("share", [0.87, 0.95, 1.05, 1.3])
def test_of_three_steps_the_code_knows_the_light(share):
    """Half of a picture and its inverse is a third of all steps, with no pattern."""
    one = scene(3)
    assert not examined(one, one.images)[2].errors.any()
    found, off, told = examined(one, spoilt(one, "phase-x-1", lambda p: share * p))
    assert (off.kind, off.pictures) == (LIGHT, (13,))
    assert off.size == pytest.approx(share - 1, rel=0.2)
    by_it = np.sqrt(error(one, found) ** 2 - clean_error(3) ** 2)
    assert by_it < off.periods < 1.7 * by_it
    assert "phase-x-1.png" in told.doubts[0].text


def test_of_three_steps_without_inverses_nothing_is_known():
    one = scene(3)
    own = [k for k, pattern in enumerate(one.patterns) if not pattern.inverse]
    images, patterns = one.images[own], [one.patterns[k] for k in own]
    codes = read_coding(patterns, one.grid.monitor_px)
    levels = {"white": one.white, "black": one.black}
    found = decode(images, patterns, one.grid, **levels)
    sample = sampled(images, patterns, codes, one.grid, found.noise, levels.values())
    assert mismatch(sample, 0, found.noise) is None


@pytest.mark.parametrize("px", [1, 2])
def test_what_moved_between_code_and_sines(px):
    one = scene(4)
    images = one.images.copy()
    sines = [k for k, pattern in enumerate(one.patterns) if pattern.kind == "phase"]
    images[sines] = np.roll(images[sines], px, axis=2)
    texts = [doubt.text for doubt in examined(one, images)[2].doubts]
    (text,) = (text for text in texts if text.startswith("the sines along x"))
    assert f"about {px}" in text or f"about {px - 1}.9" in text
