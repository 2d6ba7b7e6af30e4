"""Pictures of an active grid that contradict each other are told; good ones never."""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from raxel.features.active_grid import decode
from raxel.features.active_grid.checks.doubts import clipped_at, examine
from raxel.features.active_grid.checks.phases import edge_doubts
from raxel.features.active_grid.coding import read_coding
from raxel.sets import PatternPlan, plan_of_cells
from tests.active_grids import drawn

USUAL = {"size": (200, 150), "noise": 2.0, "blur": 1.0, "share": 0.9}
FINE = PatternPlan((5, 5), False, 4, (16.0, 16.0))


@cache
def scene(steps=4, seed=0):
    return drawn(**USUAL, steps=steps, seed=seed)


def told(images, patterns, grid, **levels):
    found = decode(images, patterns, grid, **levels)
    return examine(images, patterns, grid, found, **levels).doubts


def first(images, steps=4, patterns=None, **levels):
    """The first Doubt about pictures of the usual scene."""
    one = scene(steps)
    return told(images, patterns or one.patterns, one.grid, **levels)[0]


def number(name, steps=4):
    """Which picture has this name, without .png."""
    names = [p.image.removesuffix(".png") for p in scene(steps).patterns]
    return names.index(name)


def exchanged(*pairs, steps=4):
    images = scene(steps).images.copy()
    for names in pairs:
        own = [number(name, steps) for name in names]
        images[own] = images[own[::-1]]
    return images


def instead(name, other, steps=4):
    """One picture taken again while the monitor showed another."""
    images = scene(steps).images.copy()
    images[number(name, steps)] = scene(steps, seed=1).images[number(other, steps)]
    return images


def facets(u, v, monitor):
    """Two mirrors, each showing one half; what is in the middle is not seen."""
    x = np.where(u < 0, 0.35 + 0.7 * u, 0.65 + 0.7 * u) * monitor[0]
    return x, (0.5 + 0.9 * v) * monitor[1]


def patches(u, v, monitor):
    """A surface in 35 pieces that see places far from each other's."""
    k, j = np.floor((u + 0.5) * 7), np.floor((v + 0.5) * 5)
    turn = np.sin(12.9 * k + 78.2 * j) * 43758.5 % 1
    x = (0.3 + 0.5 * turn + 0.3 * u) * monitor[0]
    return x, (0.5 + 0.45 * v + 0.3 * np.cos(9 * turn)) * monitor[1]


def ball(u, v, monitor):
    """Above, a mirror squeezes half of the monitor into some pixels."""
    x = (0.5 + 0.9 * u) * monitor[0]
    return x, monitor[1] * (0.02 + 0.96 * (v / 0.75 + 0.5) ** 0.3)


@pytest.mark.parametrize(
    "changes",
    [
        {},
        {"steps": 6},
        {"steps": 3, "dtype": np.uint16},
        {"cells": (13, 4), "tilt": 0.5},
        {"cells": 1},
        {"noise": 8.0, "blur": 2.0},
        {"share": 1.6},
        {"share": 0.3, "vignetting": 2.5},
        {"plan": FINE},
        {"plan": PatternPlan((5, 6), True)},
        {"plan": PatternPlan((10, 0), True, cell_px=(1.0, 0.0))},
        {"place": facets},
        {"place": patches},
        {"place": ball, "cells": 16, "noise": 0.5, "blur": 3.0},
    ],
)
def test_good_pictures_raise_no_doubt(changes):
    for seed in (0, 1, 2, 3) if not changes else (len(str(changes)),):
        one = drawn(**{**USUAL, "seed": seed, **changes})
        levels = {"white": one.white, "black": one.black} if seed % 2 else {}
        assert told(one.images, one.patterns, one.grid, **levels) == []


@pytest.mark.parametrize("power", [0.45, 2.2])
@pytest.mark.parametrize("changes", [{}, {"cells": 2}, {"share": 2.5, "steps": 6}])
def test_tone_curves_raise_no_doubt(power, changes):
    """They leave harmonics in the sines, and lines along the edges of the code."""
    one = drawn(**{**USUAL, "noise": 1.0, "blur": 1.5, "tilt": 0.4, **changes})
    images = np.rint(255 * (one.images / 255) ** power).astype(np.uint8)
    assert told(images, one.patterns, one.grid) == []


def test_other_orders_and_subsets_raise_no_doubt():
    one = scene(6)
    for keep in (
        np.random.default_rng(0).permutation(len(one.patterns)),
        [k for k, p in enumerate(one.patterns) if p.axis == "y"],
        [k for k, p in enumerate(one.patterns) if p.kind == "gray"],
        [k for k, p in enumerate(one.patterns) if not p.inverse],
    ):
        patterns = [one.patterns[k] for k in keep]
        levels = {"white": one.white, "black": one.black}
        assert told(one.images[keep], patterns, one.grid, **levels) == []


@pytest.mark.parametrize("steps", [4, 6])
@pytest.mark.parametrize(
    ("pairs", "message"),
    [
        (
            [("gray-x-00", "gray-x-01")],
            "gray-x-00-inverse.png and gray-x-01-inverse.png are in each other's place",
        ),
        (
            [("gray-x-00", "gray-x-02"), ("gray-x-00-inverse", "gray-x-02-inverse")],
            "gray-x-00.png and gray-x-02.png, gray-x-00-inverse.png and gray-x-02-inv",
        ),
        (
            [("gray-x-01", "gray-y-01"), ("gray-x-01-inverse", "gray-y-01-inverse")],
            "gray-x-01.png and gray-y-01.png, gray-x-01-inverse.png and gray-y-01-inv",
        ),
        (
            [("gray-y-01", "gray-y-01-inverse")],
            "gray-y-01.png and gray-y-01-inverse.png are in each other's place: the",
        ),
        (
            [("gray-x-00", "gray-x-00-inverse")],
            "the phase along x falls where its Gray code rises: phase-x-0.png and pha",
        ),
        (
            [(f"gray-x-0{b}", f"gray-x-0{b}-inverse") for b in range(3)],
            "the pictures of axis x and their inverses are exchanged throughout",
        ),
        (
            [("phase-y-0", "phase-y-1")],
            {
                4: "the phase along y falls where its Gray code rises: phase-y-0.png",
                6: "the phase steps along y are not in order: phase-y-0.png and ph",
            },
        ),
        (
            [("phase-x-1", "phase-x-3")],
            {4: "the phase along x falls where", 6: "the phase steps along x are not"},
        ),
        (
            [(f"phase-x-{k}", f"phase-y-{k}") for k in range(4)],
            {4: "the sines along x (phase-x-0.png to phase-x-3.png) do not fit", 6: ""},
        ),
        (
            [("gray-x-02", "phase-x-1")],
            "gray-x-02.png and phase-x-1.png are in each other's place: gray-x-02.png",
        ),
    ],
)
def test_pictures_in_each_others_place(steps, pairs, message):
    doubt = first(exchanged(*pairs, steps=steps), steps)
    message = message[steps] if isinstance(message, dict) else message
    assert doubt.spoils
    assert doubt.text.startswith(message)
    assert "\n" not in doubt.text


@pytest.mark.parametrize("steps", [3, 4, 6])
@pytest.mark.parametrize(
    ("name", "other", "message"),
    [
        (
            "gray-x-01-inverse",
            "gray-x-01",
            "gray-x-01.png and gray-x-01-inverse.png are not opposite to each other",
        ),
        (
            "gray-y-02",
            "gray-y-01-inverse",
            "gray-y-02.png and gray-y-02-inverse.png are not opposite to each other",
        ),
        (
            "phase-x-1",
            "phase-x-0",
            "phase-x-1.png shows the same step as phase-x-0.png",
        ),
    ],
)
def test_a_monitor_that_had_not_changed_yet(steps, name, other, message):
    doubt = first(instead(name, other, steps), steps)
    assert doubt.spoils
    assert doubt.text.startswith(message)


def test_a_step_of_the_other_axis_and_a_copied_file():
    doubt = first(instead("phase-x-1", "phase-y-0", 6), 6)
    assert doubt.text.startswith("phase-x-1.png shows no step of the sines along x")
    images = scene().images.copy()
    images[3] = images[2]
    doubt = first(images)
    assert doubt.spoils
    assert doubt.text.startswith("gray-x-01-inverse.png: the same picture as gray-x-01")


def test_white_and_black_exchanged():
    one = scene()
    doubt = first(one.images, white=one.black, black=one.white)
    assert doubt.spoils
    assert "black picture is brighter than its white one" in doubt.text


@pytest.mark.parametrize(
    ("change", "message"),
    [
        (lambda k: (-k) % 6, "the phase along x falls where its Gray code rises"),
        (lambda k: (k + 1) % 6, "the sines along x (phase-x-0.png to phase-x-5.png) b"),
    ],
)
def test_steps_against_the_code(change, message):
    images = scene(6).images.copy()
    own = [number(f"phase-x-{k}", 6) for k in range(6)]
    images[own] = images[[own[change(k)] for k in range(6)]]
    doubt = first(images, 6)
    assert doubt.spoils
    assert doubt.text.startswith(message)


def test_sines_that_moved_against_the_code():
    """No rim is in the picture to see it by, and whole steps are further off."""
    one = drawn(**USUAL | {"share": 1.6})
    images = one.images.copy()
    for image in images[12:]:
        image[:] = np.roll(image, 4, 1)
    doubt = told(images, one.patterns, one.grid)[0]
    assert doubt.spoils
    assert "as if something had moved; take all pictures in one pose" in doubt.text


@pytest.mark.parametrize(
    "wrong", [{"periods": 4.0}, {"periods": 7.0}, {"cell_px": 20.0}, {"cell_px": 12.5}]
)
def test_lengths_in_the_file_that_the_pictures_do_not_show(wrong):
    one, key = scene(), next(iter(wrong))
    patterns = [
        replace(p, **wrong) if p.axis == "x" and getattr(p, key) else p
        for p in one.patterns
    ]
    doubt = first(one.images, patterns=patterns)
    assert doubt.spoils
    assert (
        "do not fit the cells of its Gray code (gray-x-00.png to gray-x-02-inverse.png)"
        in doubt.text
    )


def test_a_code_that_leaves_the_monitor():
    """Gray code alone: nothing else says that cells of 50 px are too wide."""
    one = scene()
    own = [k for k, p in enumerate(one.patterns) if p.kind == "gray"]
    patterns = [
        replace(one.patterns[k], cell_px=2 * one.patterns[k].cell_px) for k in own
    ]
    doubt = first(one.images[own], patterns=patterns)
    assert doubt.spoils
    assert "would lie beside the monitor along x and y; mend target" in doubt.text


@pytest.mark.parametrize(
    ("begin", "end", "shift", "message"),
    [
        (4, None, (0, 3), "between gray-x-01-inverse.png and gray-x-02.png"),
        (12, None, (1, 1), "between gray-y-02-inverse.png and phase-x-0.png"),
        (3, None, (0, 2), "between gray-x-01.png and gray-x-01-inverse.png"),
        (18, None, (2, 0), "among phase-y-0.png to phase-y-3.png"),
    ],
)
def test_a_camera_that_moved(begin, end, shift, message):
    images = scene().images.copy()
    for image in images[begin:end]:
        image[:] = np.roll(image, shift, (0, 1))
    doubt = first(images)
    assert doubt.spoils
    assert doubt.text.startswith("the picture moved by about ")
    assert message in doubt.text
    small = scene().images.copy()
    for image in small[begin:end]:
        # Half a pixel; blurred a little by it.
        turn = np.float32([[1, 0, shift[1] / 6], [0, 1, shift[0] / 6]])
        image[:] = cv2.warpAffine(image, turn, image.shape[::-1])
    found = told(small, scene().patterns, scene().grid)
    assert not any(doubt.spoils for doubt in found)


@pytest.mark.parametrize("name", ["gray-x-01-inverse", "phase-x-1"])
def test_light_that_changed(name):
    images = scene(6).images.copy()
    k = number(name, 6)
    images[k] = np.rint(0.87 * images[k])
    doubt = first(images, 6)
    assert not doubt.spoils
    assert doubt.text.startswith(f"{name}.png is ")
    assert "darker than others" in doubt.text
    images[k] = np.rint(0.6 * images[k])
    assert first(images, 6).spoils


def test_overexposed_parts_are_left_out_and_counted():
    one = scene()
    images = np.clip(1.35 * one.images.astype(float), 0, 255).astype(np.uint8)
    (doubt,) = told(images, one.patterns, one.grid)
    assert not doubt.spoils
    assert "% of the pixels that see the monitor are overexposed" in doubt.text


@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_a_camera_that_stops_counting_early(dtype):
    """12 bits in files of 16, and grey values that end at 235."""
    top = {np.uint8: 160, np.uint16: 4095}[dtype]
    one = drawn(**USUAL)
    assert clipped_at(one.images, one.patterns) is None
    scale = 1.0 if dtype == np.uint8 else 4095 / 160
    images = np.minimum(scale * one.images, top).astype(dtype)
    found = clipped_at(images, one.patterns)
    assert found.level == top
    clipped = decode(images, one.patterns, one.grid, saturated=found.level)
    unaware = decode(images, one.patterns, one.grid)
    assert clipped.counts()["overexposed"] > 0.05 * clipped.mask.size
    assert unaware.counts()["overexposed"] == 0
    assert clipped_at(np.minimum(images, top + 1), one.patterns) == found


def test_sines_that_nobody_showed_are_told():
    images = scene().images.copy()
    for step in range(4):
        images[number(f"phase-y-{step}")] = 7 + step
    doubt = first(images)
    assert doubt.spoils
    assert doubt.text.startswith("phase-y-0.png to phase-y-3.png show no sines along y")


def test_mosaics_of_colour_cameras_are_told():
    images = scene().images.astype(float)
    images[:, ::2, ::2] *= 0.6
    images[:, 1::2, 1::2] *= 0.45
    doubt = first(np.rint(images).astype(np.uint8))
    assert doubt.spoils
    assert "mosaics; give their colour pictures" in doubt.text


@pytest.mark.parametrize(("slope", "falls"), [(0.0, False), (-0.1, True)])
def test_clipped_sines_that_stand_still_do_not_fall(slope, falls):
    one = scene()
    codes = read_coding(one.patterns, one.grid.monitor_px)
    along = np.where(np.arange(300) % 3 == 0, 0.1, slope)
    sample = SimpleNamespace(names=[p.image for p in one.patterns], codes=codes)
    ones = np.ones(300, complex)
    found = list(edge_doubts(sample, 0, range(4), ones, ones, along))
    assert [("falls where" in doubt.text) for doubt in found] == [True] * falls


@pytest.mark.parametrize("steps", [3, 4, 5, 6])
@pytest.mark.parametrize("offset", [0.0, 0.25])
def test_every_picture_out_of_order_is_named_and_no_other(steps, offset):
    """Swaps, reversals and other permutations of a sine's steps."""
    plan = plan_of_cells((200, 144), 8, steps, offset)
    one = drawn(**USUAL, plan=plan)
    names = [p.image for p in one.patterns]
    own = np.array([names.index(f"phase-x-{k}.png") for k in range(steps)])
    rng = np.random.default_rng(steps)
    every = [np.arange(steps)[::-1], -np.arange(steps) % steps]
    every += [rng.permutation(steps) for _ in range(4)]
    for order in every:
        moved = {names[own[k]] for k in range(steps) if order[k] != k}
        if not moved:
            continue
        images = one.images.copy()
        images[own] = images[own[order]]
        doubt = told(images, one.patterns, one.grid)[0]
        assert doubt.spoils
        text = doubt.text.replace("(phase-x-0.png to", "").split(", or gray")[0]
        assert moved == {names[k] for k in own if names[k] in text}
