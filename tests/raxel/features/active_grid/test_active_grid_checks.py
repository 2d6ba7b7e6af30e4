"""Consistency checks detect contradictory images, and accept valid ones.

Every fault here once passed, or is one that a user makes: a table of faults and codes.
"""

from dataclasses import replace
from functools import cache
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from raxel.features.active_grid import decode
from raxel.features.active_grid.checks import phases as edges
from raxel.features.active_grid.checks.code import sampled
from raxel.features.active_grid.checks.diagnostics import clipped_at, examine
from raxel.features.active_grid.checks.motion import SINE_TO_SIGMA
from raxel.features.active_grid.checks.phases import (
    _offset_diagnostics,
    _windows,
    edge_diagnostics,
)
from raxel.features.active_grid.checks.redundancy import LIGHT, MOTION, mismatch
from raxel.features.active_grid.coding import read_coding
from raxel.features.active_grid.errors import Noise
from raxel.sets import PatternPlan, plan_of_cells
from tests.active_grids import drawn

USUAL = {"size": (200, 150), "noise": 2.0, "blur": 1.0, "share": 0.9}
FINE = PatternPlan((5, 5), False, 4, (16.0, 16.0))


@cache
def scene(steps=4, seed=0, **changes):
    return drawn(**USUAL | changes, steps=steps, seed=seed)


def diagnostics(images, patterns, grid, **levels):
    found = decode(images, patterns, grid, **levels)
    return examine(images, patterns, grid, found, **levels).diagnostics


def first(images, steps=4, patterns=None, **levels):
    """The first Doubt about images of the usual scene."""
    one = scene(steps)
    return diagnostics(images, patterns or one.patterns, one.grid, **levels)[0]


def number(name, steps=4):
    """Index of the image with this name, without .png."""
    return ([p.image.removesuffix(".png") for p in scene(steps).patterns]).index(name)


# ----------------------------------------------------------------------- good images


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


@pytest.mark.parametrize("seed", [0, 1])
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
def test_valid_images_give_no_diagnostic(changes, seed):
    one = drawn(**{**USUAL, "seed": seed, **changes})
    levels = {"white": one.white, "black": one.black} if seed else {}
    assert diagnostics(one.images, one.patterns, one.grid, **levels) == []


@pytest.mark.parametrize("power", [0.45, 2.2])
@pytest.mark.parametrize(
    "changes", [{}, {"cells": 2}, {"share": 2.5, "steps": 6}, {"plan": FINE}]
)
def test_tone_curves_give_no_diagnostic(power, changes):
    """They leave harmonics in the sines, and lines along the edges of the code."""
    one = drawn(**{**USUAL, "noise": 1.0, "blur": 1.5, "tilt": 0.4, **changes})
    images = np.rint(255 * (one.images / 255) ** power).astype(np.uint8)
    assert diagnostics(images, one.patterns, one.grid) == []


@pytest.mark.parametrize(
    "kept",
    [
        lambda p: True,
        lambda p: p.axis == "y",
        lambda p: p.kind == "gray",
        lambda p: not p.inverse,
    ],
)
def test_subsets_in_any_order_give_no_diagnostic(kept):
    one = scene(6)
    keep = [k for k, p in enumerate(one.patterns) if kept(p)]
    keep = np.random.default_rng(0).permutation(keep)
    patterns = [one.patterns[k] for k in keep]
    levels = {"white": one.white, "black": one.black}
    assert diagnostics(one.images[keep], patterns, one.grid, **levels) == []


def test_light_change_of_half_percent_is_accepted():
    one = scene()
    gains = 1 + 0.005 * np.sin(np.arange(len(one.images)))
    images = (one.images * gains[:, None, None]).astype(np.uint8)
    assert not any(
        diagnostic.invalidates
        for diagnostic in diagnostics(images, one.patterns, one.grid)
    )


def test_facets_with_different_light_are_consistent():
    """Light, and what scatters into it, change with the facet; the curve does not."""
    one = drawn(size=(280, 210), noise=0.5, blur=1.0, share=1.4)
    v, u = np.indices(one.images.shape[1:]) // 40
    light, scattered = 0.6 + 0.1 * ((3 * u + v) % 4), 4.0 * ((u + 2 * v) % 5)
    images = 255 * ((light * one.images + scattered) / 255) ** 0.5
    images = np.rint(images).astype(np.uint8)
    found = decode(images, one.patterns, one.grid)
    assert not examine(images, one.patterns, one.grid, found).errors.any()


# ------------------------------------------------------- images in the place of others


EVERY_X = [(f"gray-x-0{b}", f"gray-x-0{b}-inverse") for b in range(3)]
OTHER_AXIS = [(f"phase-x-{k}", f"phase-y-{k}") for k in range(4)]
X_0_AND_2 = [("gray-x-00", "gray-x-02"), ("gray-x-00-inverse", "gray-x-02-inverse")]
X_1_AND_Y_1 = [("gray-x-01", "gray-y-01"), ("gray-x-01-inverse", "gray-y-01-inverse")]


@pytest.mark.parametrize(
    ("steps", "pairs", "code", "named"),
    [
        (4, [("gray-x-00", "gray-x-01")], "not-opposite", "gray-x-00-inverse.png"),
        (6, X_0_AND_2, "code-leaps", "gray-x-00.png and gray-x-02.png"),
        (4, X_1_AND_Y_1, "code-leaps", "gray-x-01.png and gray-y-01.png"),
        (4, [("gray-y-01", "gray-y-01-inverse")], "code-leaps", "inverse of gray-y-01"),
        (6, [("gray-x-00", "gray-x-00-inverse")], "reversed", "gray-x-00.png"),
        (4, EVERY_X, "code-leaps", "gray-x-02-inverse.png"),
        (4, [("phase-y-0", "phase-y-1")], "step-order", "along y"),
        (6, [("phase-y-0", "phase-y-1")], "step-order", "along y"),
        (4, [("phase-x-1", "phase-x-3")], "reversed", "axis x"),
        (6, [("phase-x-1", "phase-x-3")], "step-order", "along x"),
        (4, OTHER_AXIS, "period", "phase-x-0.png to phase-x-3.png"),
        (6, OTHER_AXIS, "not-a-step", "along x"),
        (4, [("gray-x-02", "phase-x-1")], "not-opposite", "gray-x-02.png"),
    ],
)
def test_exchanged_images_are_detected(steps, pairs, code, named):
    images = scene(steps).images.copy()
    for names in pairs:
        own = [number(name, steps) for name in names]
        images[own] = images[own[::-1]]
    diagnostic = first(images, steps)
    assert (diagnostic.code, diagnostic.invalidates) == (code, True)
    assert named in diagnostic.text
    assert "\n" not in diagnostic.text


@pytest.mark.parametrize("steps", [3, 4, 6])
@pytest.mark.parametrize(
    ("places", "code"),
    [
        ({"gray-x-01-inverse": "gray-x-01"}, "not-opposite"),
        ({"gray-y-02": "gray-y-01-inverse"}, "not-opposite"),
        ({"phase-x-1": "phase-x-0"}, "same-step"),
        ({f"gray-x-02{e}": f"gray-x-01{e}" for e in ("", "-inverse")}, "doubled-bit"),
        ({f"gray-y-01{e}": f"gray-x-01{e}" for e in ("", "-inverse")}, "doubled-bit"),
        (
            {"gray-x-01": "gray-x-00-inverse", "gray-x-01-inverse": "gray-x-00"},
            "doubled-bit",
        ),
    ],
)
def test_wrong_pattern_is_detected(steps, places, code):
    images = scene(steps).images.copy()
    for name, other in places.items():
        images[number(name, steps)] = scene(steps, seed=1).images[number(other, steps)]
    diagnostic = first(images, steps)
    assert (diagnostic.code, diagnostic.invalidates) == (code, True)
    assert all(f"{name}.png" in diagnostic.text for name in places)


@pytest.mark.parametrize("change", [lambda k: -k % 6, lambda k: (k + 1) % 6])
def test_steps_inconsistent_with_code_are_detected(change):
    images = scene(6).images.copy()
    own = [number(f"phase-x-{k}", 6) for k in range(6)]
    images[own] = images[[own[change(k)] for k in range(6)]]
    diagnostic = first(images, 6)
    assert (diagnostic.code, diagnostic.invalidates) == (
        "reversed" if change(1) == 5 else "offset",
        1,
    )


def test_faults_of_single_images_are_detected():
    one = scene()
    copied, level = one.images.copy(), one.images.copy()
    copied[3] = copied[2]
    for step in range(4):
        level[number(f"phase-y-{step}")] = 7 + step
    found = [
        first(copied),
        first(level),
        first(one.images, white=one.black, black=one.white),
    ]
    assert [diagnostic.code for diagnostic in found] == [
        "same-image",
        "no-sines",
        "white-black",
    ]
    assert all(diagnostic.invalidates for diagnostic in found)
    clipped = np.clip(1.35 * one.images.astype(float), 0, 255).astype(np.uint8)
    (diagnostic,) = diagnostics(clipped, one.patterns, one.grid)
    assert (diagnostic.code, diagnostic.invalidates) == ("overexposed", False)


@pytest.mark.parametrize(
    "wrong", [{"periods": 4.0}, {"periods": 7.0}, {"cell_px": 20.0}, {"cell_px": 12.5}]
)
def test_wrong_lengths_in_set_yaml_are_detected(wrong):
    one, key = scene(), next(iter(wrong))
    patterns = [
        replace(p, **wrong) if p.axis == "x" and getattr(p, key) else p
        for p in one.patterns
    ]
    diagnostic = first(one.images, patterns=patterns)
    assert (diagnostic.code, diagnostic.invalidates) == ("period", True)


def test_code_wider_than_monitor_is_detected():
    """Gray code alone: nothing else shows that cells of 50 px are too wide."""
    one = scene()
    own = [k for k, p in enumerate(one.patterns) if p.kind == "gray"]
    patterns = [
        replace(one.patterns[k], cell_px=2 * one.patterns[k].cell_px) for k in own
    ]
    diagnostic = first(one.images[own], patterns=patterns)
    assert (diagnostic.code, diagnostic.invalidates) == ("beside-monitor", True)


@pytest.mark.parametrize("steps", [5, 6])
def test_unstated_offset_is_measured(steps):
    one = drawn(plan=plan_of_cells((200, 144), 8, steps, 0.25), noise=1.0, blur=1.0)
    patterns = [replace(p, offset=0.0) for p in one.patterns]
    diagnostic = diagnostics(one.images, patterns, one.grid)[0]
    assert (diagnostic.code, diagnostic.invalidates) == ("offset", True)
    assert "give offset: 0.25" in diagnostic.text


@pytest.mark.parametrize(("slope", "falls"), [(0.0, False), (-0.1, True)])
def test_clipped_sines_are_not_reversed(slope, falls):
    one = scene()
    codes = read_coding(one.patterns, one.grid.monitor_px)
    along = np.where(np.arange(300) % 3 == 0, 0.1, slope)
    sample = SimpleNamespace(names=[p.image for p in one.patterns], codes=codes)
    ones = np.ones(300, complex)
    found = list(edge_diagnostics(sample, 0, ones, ones, along))
    assert [diagnostic.code for diagnostic in found] == ["reversed"] * falls


# ------------------------------------------------------------ movement, light, levels


@pytest.mark.parametrize(
    ("begin", "end", "shift", "code", "named"),
    [
        (4, None, (0, 3), "moved", "gray-x-01-inverse.png and gray-x-02.png"),
        (12, None, (1, 1), "moved", "gray-y-02-inverse.png and phase-x-0.png"),
        (3, None, (0, 2), "moved", "gray-x-01.png and gray-x-01-inverse.png"),
        (18, None, (2, 0), "moved-step", "among phase-y-0.png to phase-y-3.png"),
    ],
)
def test_camera_motion_is_detected(begin, end, shift, code, named):
    images = scene().images.copy()
    for image in images[begin:end]:
        image[:] = np.roll(image, shift, (0, 1))
    diagnostic = first(images)
    assert (diagnostic.code, diagnostic.invalidates) == (code, True)
    assert named in diagnostic.text
    small = scene().images.copy()
    for image in small[begin:end]:
        # Half a pixel; blurred a little by it.
        turn = np.float32([[1, 0, shift[1] / 6], [0, 1, shift[0] / 6]])
        image[:] = cv2.warpAffine(image, turn, image.shape[::-1])
    found = diagnostics(small, scene().patterns, scene().grid)
    assert not any(diagnostic.invalidates for diagnostic in found)


def test_motion_between_code_and_phases_is_detected():
    """No rim is in the image to see it by, and whole steps are further off."""
    one = scene(share=1.6)
    images = one.images.copy()
    images[12:] = np.roll(images[12:], 4, axis=2)
    diagnostic = diagnostics(images, one.patterns, one.grid)[0]
    assert (diagnostic.code, diagnostic.invalidates) == ("offset", True)
    images[12:] = np.roll(one.images[12:], 1, axis=2)
    codes = [
        diagnostic.code for diagnostic in diagnostics(images, one.patterns, one.grid)
    ]
    assert "moved-code-phase" in codes


@pytest.mark.parametrize(
    ("steps", "name"), [(6, "gray-x-01-inverse"), (6, "phase-x-1"), (3, "phase-x-1")]
)
def test_light_change_is_detected(steps, name):
    images = scene(steps).images.copy()
    k = number(name, steps)
    images[k] = np.rint(0.87 * images[k])
    diagnostic = first(images, steps)
    assert (diagnostic.code, diagnostic.invalidates) == ("brightness", False)
    assert diagnostic.text.startswith(f"{name}.png: ")
    images[k] = np.rint(0.6 * images[k])
    assert first(images, steps).invalidates


@pytest.mark.parametrize(
    ("dtype", "top"), [(np.uint8, 160), (np.uint16, 4095)], ids=["8 bit", "16 bit"]
)
def test_clipping_below_full_range_is_detected(dtype, top):
    """12 bits in files of 16, and grey values that end at 235."""
    one = drawn(**USUAL)
    assert clipped_at(one.images, one.patterns) is None
    images = np.minimum(top / 160 * one.images, top).astype(dtype)
    assert clipped_at(images, one.patterns) == top
    clipped = decode(images, one.patterns, one.grid, saturated=top)
    unaware = decode(images, one.patterns, one.grid)
    assert clipped.counts()["overexposed"] > 0.05 * clipped.mask.size
    assert unaware.counts()["overexposed"] == 0
    assert clipped_at(np.minimum(images, top + 1), one.patterns) == top


@pytest.mark.parametrize(("times", "clipped"), [(1, False), (3, False), (9, True)])
def test_clipping_level_needs_frequency_spike(times, clipped):
    """Of a dark scene few pixels reach the top, and rounding makes them uneven."""
    values = np.repeat(np.arange(100, 201), 60)
    image = np.append(values, np.full(60 * (times - 1), 200)).astype(np.uint8)[None]
    found = clipped_at([image], [SimpleNamespace(kind="phase")])
    assert found == (200 if clipped else None)


# ---------------------------------------------------------- one step against the others


INNER = np.s_[10:-10, 10:-10, 0]  # where no image's border was mirrored or moved
WIDE = {"size": (280, 210), "share": 1.2}


def error(one, found):
    """RMS along x in periods."""
    error = (found.location - one.true)[INNER]
    return np.sqrt(np.nanmean(error**2)) / (one.grid.monitor_mm[0] / 8)


@pytest.mark.parametrize("steps", [4, 5])
@pytest.mark.parametrize(
    ("name", "change", "kind", "size", "invalidates"),
    [
        ("phase-x-1", lambda p: 1.3 * p, LIGHT, 0.3, True),
        ("phase-x-2", lambda p: 0.87 * p, LIGHT, -0.13, None),
        ("phase-x-3", lambda p: 1.03 * p, LIGHT, 0.03, False),
        ("phase-x-2", lambda p: np.roll(p, 2, 1), MOTION, 2.0, True),
        ("phase-x-1", lambda p: np.roll(p, 1, 1), MOTION, 1.0, None),
    ],
)
def test_inconsistent_step_is_identified(steps, name, change, kind, size, invalidates):
    one = scene(steps, **WIDE)
    images = one.images.copy()
    k = [pattern.image for pattern in one.patterns].index(f"{name}.png")
    images[k] = np.clip(np.rint(change(images[k].astype(float))), 0, 255)
    found = decode(images, one.patterns, one.grid)
    codes = read_coding(one.patterns, one.grid.monitor_px)
    sample = sampled(images, one.patterns, codes, one.grid, found.noise, ())
    found_step, checked = (
        mismatch(sample, 0, found.noise),
        examine(images, one.patterns, one.grid, found),
    )
    named = {one.patterns[k].image for k in found_step.images}
    # Of four steps, a shift of the opposite one backwards does the same.
    assert f"{name}.png" in named
    assert len(named) <= (2 if kind == MOTION and steps == 4 else 1)
    assert found_step.kind == kind
    # A shift is found by differences over two pixels of the blurred image.
    assert found_step.size == pytest.approx(size, rel=0.12 if kind == MOTION else 0.05)
    clean = error(one, decode(one.images, one.patterns, one.grid))
    by_it = np.sqrt(error(one, found) ** 2 - clean**2)
    assert found_step.periods == pytest.approx(
        by_it, rel=0.2 if kind == MOTION else 0.15
    )
    stated = SINE_TO_SIGMA * found_step.periods * one.grid.monitor_mm[0] / 8
    assert checked.errors[0] == pytest.approx(stated, rel=1e-3)
    assert f"{name}.png" in checked.diagnostics[0].text
    invalidates = found_step.periods > 0.01 if invalidates is None else invalidates
    assert checked.diagnostics[0].invalidates == invalidates


@pytest.mark.parametrize(
    ("noise", "change"),
    [
        (1.0, lambda p: 1.01 * p),
        (0.5, lambda p: np.roll(p, 1, 0)),
        (2.0, lambda p: p + 4),
    ],
)
def test_sigma_includes_accepted_step_errors(noise, change):
    one = scene(**WIDE, noise=noise)
    images = one.images.copy()
    k = [pattern.image for pattern in one.patterns].index("phase-x-1.png")
    images[k] = np.clip(np.rint(change(images[k].astype(float))), 0, 255)
    found = decode(images, one.patterns, one.grid)
    checked = examine(images, one.patterns, one.grid, found)
    assert not any(diagnostic.invalidates for diagnostic in checked.diagnostics)
    found = decode(images, one.patterns, one.grid, shared=checked.factors)
    error = np.abs((found.location - one.true)[INNER])
    error = error / checked.widened(found.sigma)[INNER]
    error = error[np.isfinite(error)]
    assert 0.6 < np.mean(error < 1) < 0.85
    assert np.mean(error > 6) < 1e-3


# ----------------------------------------------------------------------------- limits


@pytest.mark.parametrize(
    ("error", "noise", "blur_px", "moved"),
    [
        (0.003, 0.001, None, False),  # so little a response may do
        (0.02, 0.001, 1.0, True),  # half a pixel
        (0.02, 0.001, None, True),
        (0.02, 0.1, 1.0, False),  # noise of the mean is a third of it
        (0.02, 0.02, 1.0, True),
        (0.02, 0.001, 8.0, False),  # blur draws edges and sines apart by more
    ],
)
def test_offset_from_code_has_tolerance(monkeypatch, error, noise, blur_px, moved):
    """Periods of 25 px, at 300 edges; off and noise of one edge in periods."""
    one = drawn(steps=5)
    codes = read_coding(one.patterns, one.grid.monitor_px)
    sample = SimpleNamespace(names=[p.image for p in one.patterns], codes=codes)
    turns = error + noise * np.random.default_rng(6).normal(size=300)
    observed = np.exp(2j * np.pi * turns), np.ones(300), np.full(300, 2 * np.pi / 25)
    monkeypatch.setattr(edges, "phases_at_edges", lambda *_: observed)
    found = list(edges.motion_after_code(sample, 0, blur_px))
    assert [diagnostic.code for diagnostic in found] == ["moved-code-phase"] * moved


def test_edge_phase_is_interpolated():
    """Edges of cells of 8 px, 0.7 px behind the one pixel and 0.3 before the other."""
    x = np.arange(64) + 0.3
    cells = (x // 8).astype(np.int32)
    difference = np.clip(np.abs((x + 4) % 8 - 4), 0, 1) * np.cos(np.pi * cells)
    code = SimpleNamespace(cell=8, period=32)
    observed = np.exp(2j * np.pi * x / 32)[None, None]
    sides = (np.s_[:, :, :-1], np.s_[:, :, 1:])
    lit = np.ones((1, 1, 64), bool)
    phase, due, along, breaks = edges._at_edges(
        code, difference[None, None, None], observed, cells[None, None], lit, *sides
    )
    assert len(phase) == 7
    assert breaks == [0]
    np.testing.assert_allclose(np.angle(phase * np.conj(due)), 0, atol=0.01)
    np.testing.assert_allclose(along, 2 * np.pi / 32)


@pytest.mark.parametrize(
    ("periods", "begun", "doubted"),
    [
        ((8, 9), 0.03, False),  # a cell's thirtieth: ripples look like it
        ((8, 9), 0.06, True),
        ((20, 20.5), (0.0, -0.0015), False),  # of a mean of noise, 0.06 by these two
        ((20, 20.5), (0.0, -0.003), True),
    ],
)
def test_offset_between_sines_has_tolerance(periods, begun, doubted):
    rng, periods = np.random.default_rng(7), np.float32(periods)
    turns = rng.uniform(0.1, 0.9, 2000) * periods[:, None] + np.reshape(begun, (-1, 1))
    turns = np.float32((turns + 0.002 * rng.normal(size=turns.shape)) % 1)
    variances = np.full(turns.shape, np.float32(0.002**2))
    every = [SimpleNamespace(offset=0.0)] * 2
    found = list(_offset_diagnostics(every, turns, variances, periods, "x"))
    assert len(found) == doubted
    if np.ndim(begun) == 0 and doubted:
        offset = float(
            found[0].text.split("give offset: ")[1].split(" ")[0].rstrip(",")
        )
        assert offset == pytest.approx(begun, abs=0.005)


def test_window_phases_have_smaller_variance():
    """By propagation: 2 / N of a grey value's variance, over amplitude squared."""
    wave = np.full((30, 40), 40 * np.exp(1.2j), np.complex64)
    sample = SimpleNamespace(
        lit=np.ones(wave.size, bool),
        wave_of=lambda *_: (wave, np.full(wave.shape, np.float32(100))),
    )
    turns, variances = _windows(sample, [SimpleNamespace(steps=range(4))], Noise(6.0))
    np.testing.assert_allclose(turns, 1.2 / (2 * np.pi), rtol=1e-5)
    due = 2 / 4 * 6.0 / 49 / 40**2 / (2 * np.pi) ** 2
    np.testing.assert_allclose(variances, due, rtol=1e-4)
