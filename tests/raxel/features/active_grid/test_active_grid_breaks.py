"""Blurred breaks of a surface: what is left is right, and smooth views lose none."""

import numpy as np
import pytest

from raxel.features.active_grid import decode
from raxel.features.active_grid import phase_unwrapping as breaks
from raxel.features.active_grid.coding import plan_arrays, read_coding
from raxel.sets import Pattern, PatternPlan
from tests.active_grids import drawn

BROKEN = "at a break of the surface"
SIZE = 240, 160
JUMPS = (0.1, 0.3, 0.6, 1.0, 1.6)


def from_ridge(axis):
    """Signed px from a ridge that is a little slanted, across `axis` of the image."""
    v, u = np.indices(SIZE[::-1])
    u, v = u - SIZE[0] / 2, v - SIZE[1] / 2
    return (u, v)[axis] + 0.05 * (v, u)[axis] - 0.4


def facets(jump, axis):
    """Two facets, so many periods apart along x and less along y."""

    def place(u, v, monitor):
        distance = jump * (from_ridge(axis) > 0) * monitor[0] / 8
        x = (0.4 + 0.45 * u + 0.1 * v) * monitor[0] + distance
        return x, (0.5 + 0.6 * v) * monitor[1] + 0.4 * distance

    return place


def bent(u, v, monitor):
    """As through a fisheye that looks at the monitor to 70 degrees."""
    r = np.hypot(u, v) + 1e-9
    grown = 0.18 * np.tan(1.95 * r) / r
    return (0.5 + grown * u) * monitor[0], (0.5 + grown * v) * monitor[1]


def scene_of(jump, axis=0, **options):
    options = {"blur": 0.7, "noise": 1.0, "vignetting": 0.5} | options
    return drawn(size=SIZE, place=facets(jump, axis), **options)


def standardised(scene, found):
    """(H, W, 2) errors in stated SD; none where the image's border was mirrored."""
    ratio = np.abs(found.location - scene.true) / found.sigma
    within = np.zeros(SIZE[::-1], bool)
    within[8:-8, 8:-8] = True
    return np.where(within[..., None], ratio, np.nan)


@pytest.mark.parametrize("jump", JUMPS)
@pytest.mark.parametrize("smooth", [True, False])
def test_sigma_is_correct_next_to_breaks(jump, smooth):
    near, lost = [], []
    for k, (blur, noise) in enumerate(((0.7, 1.0), (0.7, 4.0), (2.0, 1.0), (2.0, 4.0))):
        axis, seed = k % 2, k
        if jump == 0.3:
            axis = 1 - axis
        scene = scene_of(jump, axis, blur=blur, noise=noise, seed=seed)
        found = decode(scene.images, scene.patterns, scene.grid, smooth=smooth)
        ratio, away = standardised(scene, found), np.abs(from_ridge(axis))
        # Single pixels are too noisy to show the smallest jump; what noise hides is
        # within their standard deviations.
        if smooth or jump > 0.1:
            assert found.counts()[BROKEN] > 6 * len(away)
            assert not found.mask[away < 2].any()
        near.append(ratio[(away < 16) & np.isfinite(ratio[..., 0])])
        lost.append((found.status == breaks.BREAK)[away > found.margin_px + 6])
    near = np.concatenate(near)
    assert 0.60 < np.mean(near < 1) < 0.75
    assert np.mean(near.max(axis=1) > 6) < 0.003
    assert np.mean(np.concatenate(lost)) < 0.001


SMOOTH = {
    "tilt, little noise": {"noise": 1.0, "tilt": 0.4},
    "much noise": {"noise": 8.0, "tilt": 0.4, "vignetting": 1.2},
    "blur": {"noise": 2.0, "blur": 4.0},
    "32 cells": {"noise": 8.0, "cells": 32, "blur": 0.7},
    "Gray code": {"noise": 2.0, "blur": 0.7, "plan": PatternPlan((5, 6), True)},
    "fisheye": {"noise": 1.0, "blur": 0.7, "place": bent},
    "fisheye, much noise": {"noise": 8.0, "blur": 0.7, "place": bent},
}


@pytest.mark.parametrize("name", SMOOTH)
@pytest.mark.parametrize("smooth", [True, False])
def test_smooth_views_have_no_breaks(name, smooth):
    scene = drawn(size=(400, 300), **SMOOTH[name])
    found = decode(
        scene.images, scene.patterns, scene.grid, smooth=smooth,
        margin_px=12 if name == "blur" else 6,
    )  # fmt: skip
    assert found.counts()[BROKEN] < 1e-4 * found.mask.sum()


@pytest.mark.parametrize("along", [0, 1])
def test_jump_exceeds_both_neighbouring_steps(along):
    """However the steps change along the row or column; NaN says nothing."""
    x = np.arange(80.0)
    for row in (0.5 * x, 0.004 * x**2, 10 * np.sin(x / 40)):
        assert not len(found_in(row, along))
        assert not len(found_in(np.where(x == 40, np.nan, row), along))
        for jump in (4, -4):
            broken = found_in(row + jump * (x > 40), along)
            assert broken.min() in (36, 37, 38)
            assert broken.max() in (42, 43, 44)


def found_in(row, along):
    """Where a jump is found in an image of rows, or columns, that are all alike."""
    location = np.tile(row, (80, 1)).astype(np.float32)
    location = np.ascontiguousarray(location.T if along else location)[None]
    sigma = np.full_like(location, 0.01)
    found = np.empty((40, 80), np.uint8)
    used, length = np.ones(1, np.int64), np.ones(1, np.float32)
    breaks.find_breaks(location, sigma, used, length, 0, 80, found)
    alike = found[:, 40] if along else found[20]
    return np.flatnonzero(alike) * (2 if along else 1)


def gray_codes(bits, monitor_px, **cells):
    """The codes of Gray patterns with their inverses along both axes."""
    patterns = [
        Pattern(
            f"{axis}{bit}{inverse}", axis, "gray", bits,
            bit=bit, inverse=inverse, **cells,
        )
        for axis in "xy"
        for bit in range(bits)
        for inverse in (False, True)
    ]  # fmt: skip
    return read_coding(patterns, monitor_px)


def test_edges_end_with_last_visible_cell():
    """4 bits number 16 cells; of 16 px, 12 and a half are shown along x, 9 along y."""
    plan = plan_arrays(gray_codes(4, (200, 144), cell_px=16.0), (200, 144), (1, 1))
    np.testing.assert_array_equal(plan.edges, [13, 9])


@pytest.mark.parametrize("bits", [5, 7, 9])
def test_neighbour_distance_is_independent_of_cell_width(bits):
    """A 64th of the monitor's sides to each side, in its own unit."""
    monitor_px, mm_per_px = (1024, 512), 0.25
    plan = plan_arrays(gray_codes(bits, monitor_px), monitor_px, 2 * [mm_per_px])
    np.testing.assert_allclose(plan.reach, mm_per_px * np.array(monitor_px) / 64)
