"""Sines that begin elsewhere than at the monitor's border, as cosines do."""

from dataclasses import replace

import numpy as np
import pytest

from raxel.features.active_grid import decode, locate
from raxel.features.active_grid.checks.doubts import examine
from raxel.features.active_grid.checks.steps import every_turned
from raxel.features.active_grid.coding import Sines
from raxel.sets import plan_of_cells
from tests.active_grids import drawn

MONITOR = 200, 144


@pytest.mark.parametrize("offset", [0.25, -0.4])
@pytest.mark.parametrize("steps", [3, 4, 5])
def test_places_are_those_of_sines_without_offset(steps, offset):
    plan = plan_of_cells(MONITOR, 8, steps, offset)
    one = drawn(plan=plan, noise=1.0, blur=1.0)
    found = decode(one.images, one.patterns, one.grid)
    off = np.abs(found.location - one.true)[found.mask]
    # Pixels at a cell's edge are half a period or more off where the phase is.
    assert np.max(off / found.sigma[found.mask]) < 6
    assert found.mask.mean() > 0.45
    assert examine(one.images, one.patterns, one.grid, found).doubts == []
    np.testing.assert_allclose(
        locate(one.images, one.patterns, one.grid)[20:100:9, 40:120:9],
        one.true[20:100:9, 40:120:9],
        atol=2.0,
    )


@pytest.mark.parametrize("steps", [5, 6])
def test_an_offset_that_is_not_stated_is_asked_for(steps):
    one = drawn(plan=plan_of_cells(MONITOR, 8, steps, 0.25), noise=1.0, blur=1.0)
    patterns = [replace(p, offset=0.0) for p in one.patterns]
    found = decode(one.images, patterns, one.grid)
    doubt = examine(one.images, patterns, one.grid, found).doubts[0]
    assert doubt.spoils
    assert "0.25 periods off the cells of its Gray code" in doubt.text
    assert "give offset: 0.25 if they begin there" in doubt.text


@pytest.mark.parametrize("offset", [0.0, 0.25, 0.1])
@pytest.mark.parametrize("steps", [3, 5])
def test_phases_of_steps_that_begin_or_run_elsewhere_are_turned_back(steps, offset):
    """Light of what is shown, read as if it were shown in its order."""
    own = Sines(tuple(range(steps)), 25.0, offset)
    places = np.linspace(0, 0.9, 7)
    for turned in every_turned(steps):
        shown = turned.shown(range(steps)) / steps + offset
        light = 100 + 50 * np.sin(2 * np.pi * (places + shown[:, None]))
        sine, cosine, _ = own.weights @ light
        read = np.arctan2(sine, cosine) / (2 * np.pi)
        off = turned.undone(read, own) - places
        np.testing.assert_allclose(off - np.round(off), 0, atol=1e-9)
