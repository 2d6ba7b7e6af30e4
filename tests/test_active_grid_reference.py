"""The compiled decoder against plain array arithmetic, pixel by pixel."""

import numpy as np
import pytest

from raxel.features.active_grid import Noise, decode
from raxel.features.active_grid.phases import turns
from raxel.sets import ActiveGrid
from tests.active_grids import drawn, plainly_decoded


def facets(u, v, monitor):
    """A picture in tiles of 40 x 30 px, each of which sees another part."""
    tile = np.floor(u * 4).astype(int) + 5 * np.floor(v * 16 / 3).astype(int)
    x = monitor[0] * (0.5 + 0.4 * np.sin(7.0 * tile) + 0.4 * u)
    return x, monitor[1] * (0.5 + 0.4 * np.cos(5.0 * tile) + 0.4 * v)


@pytest.mark.parametrize("smooth", [True, False], ids=["7 x 7", "raw"])
@pytest.mark.parametrize(
    "scene",
    [
        {"noise": 0.5},
        {"noise": 6.0, "blur": 1.5},
        {"noise": 20.0},
        {"noise": 2.0, "cells": (5, 12), "steps": 7, "monitor": (203, 151)},
        {"noise": 3.0, "place": facets},
        {"noise": 3.0, "size": (2500, 32), "monitor": (1920, 1440)},
    ],
    ids=["clean", "blurred", "noisy", "other plan", "facets", "in two strips"],
)
def test_cells_and_mask_are_those_of_the_plain_decoder(scene, smooth):
    scene = drawn(**scene)
    variance = 30.537
    pixels = ActiveGrid(scene.grid.monitor_px)
    found = decode(
        scene.images, scene.patterns, pixels,
        smooth=smooth, noise=Noise(variance), margin_px=0,
    )  # fmt: skip
    place, cells, mask = plainly_decoded(scene, variance, smooth)
    assert found.unit == "px"
    assert 0.1 < mask.mean() < 1
    np.testing.assert_array_equal(found.mask, mask)
    np.testing.assert_array_equal(found.cells[mask], cells[mask])
    off = np.abs(found.location - place)[mask] * 8 / scene.grid.monitor_px
    assert off.max() < 1e-4


def test_angles_in_turns():
    angle = np.linspace(0, 1, 20001)[:-1]
    for x in angle[::7]:
        s, c = np.float32(np.sin(2 * np.pi * x)), np.float32(np.cos(2 * np.pi * x))
        off = abs(turns(s, c) - x)
        assert min(off, 1 - off) < 2e-7
    assert turns(np.float32(-1e-12), np.float32(1)) in (0, np.float32(1 - 2**-24))


def test_pictures_in_a_list_in_any_order_and_number_of_threads():
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
