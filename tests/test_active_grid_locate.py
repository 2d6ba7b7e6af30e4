"""Locations alone are those of the decoder, but for the edges of cells."""

import numpy as np
import pytest

from raxel.errors import InputError
from raxel.features.active_grid import decode, locate
from raxel.features.active_grid.bias import OF_SIGMA, OF_WINDOWS, squared_bias
from raxel.features.active_grid.coding import read_coding
from raxel.features.active_grid.undoing import no_ripple
from raxel.sets import PatternPlan
from tests.active_grids import drawn


@pytest.mark.parametrize("steps", [3, 4, 6])
@pytest.mark.parametrize("dtype", [np.uint8, np.uint16])
def test_locations_alone_are_those_of_the_decoder(steps, dtype):
    scene = drawn(cells=(13, 4), steps=steps, noise=1.0, blur=1.0, dtype=dtype)
    found = decode(scene.images, scene.patterns, scene.grid, smooth=False)
    alone = locate(scene.images, scene.patterns, scene.grid, threads=3)
    assert alone.dtype == np.float32
    same = np.abs(alone - found.location)[found.mask] < 1e-4
    assert same.mean() > 0.97
    period = np.array([16, 36]) * (1.5, 1.25)
    off = np.abs(alone - found.location)[found.mask] / period
    assert np.abs(off - np.rint(off)).max() < 1e-4


LINEAR = (no_ripple(), no_ripple())


def test_arrays_are_written_over_and_one_axis_leaves_the_other_open():
    scene = drawn(noise=1.0)
    both = locate(scene.images, scene.patterns, scene.grid)
    for axis, name in enumerate("xy"):
        own = [k for k, p in enumerate(scene.patterns) if p.axis == name]
        patterns = [scene.patterns[k] for k in own]
        into = np.zeros_like(both)
        found = locate(scene.images[own], patterns, scene.grid, into=into)
        assert found is into
        assert np.isnan(found[..., 1 - axis]).all()
        np.testing.assert_array_equal(found[..., axis], both[..., axis])


def test_without_phases_it_is_the_middle_of_the_cell():
    scene = drawn(plan=PatternPlan((3, 10), True, cell_px=(25.0, 1.0)), share=1.5)
    found = locate(scene.images, scene.patterns, scene.grid)
    off = np.abs(found - scene.true)
    assert np.nanmax(off[..., 0]) < 25 * 1.5 / 2 + 1e-3
    assert np.nanmax(off[..., 1]) < 1.25 / 2 + 1e-3


def test_bits_without_inverse_are_for_decode():
    scene = drawn()
    own = [k for k, p in enumerate(scene.patterns) if not p.inverse]
    with pytest.raises(InputError, match="without inverse; use decode"):
        locate(scene.images[own], [scene.patterns[k] for k in own], scene.grid)


def test_the_arrays_of_an_earlier_view_are_written_over():
    scene, other = drawn(noise=1.0), drawn(noise=2.0, tilt=0.4, seed=1)
    kept = decode(other.images, other.patterns, other.grid)
    expected = decode(scene.images, scene.patterns, scene.grid)
    found = decode(scene.images, scene.patterns, scene.grid, into=kept)
    assert found.location.base is kept.location.base
    for name in ("location", "sigma", "cells", "status"):
        np.testing.assert_array_equal(getattr(found, name), getattr(expected, name))


def test_the_bias_of_windows_is_that_of_a_bent_surface():
    """Second derivatives 1.2 and 0.4 of the monitor's width on 400 px."""

    def bent(u, v, monitor):
        x = 0.5 + 0.7 * u + 0.6 * u * u + 0.2 * v * v
        return x * monitor[0], (0.5 + 0.8 * v) * monitor[1]

    scene = drawn(size=(400, 300), place=bent, dtype=np.uint16)
    codes = read_coding(scene.patterns, scene.grid.monitor_px)
    squared = squared_bias(scene.images, codes, OF_WINDOWS, 0.0, 0.1, LINEAR)
    found = np.sqrt(squared)[:, 1:-1]
    expected = OF_SIGMA * OF_WINDOWS / 2 * (1.2 + 0.4) * 8 / 400**2
    assert found[0, :, 32:-32] == pytest.approx(expected, rel=0.02)
    assert found[1].max() < 0.02 * expected


def test_facets_are_not_bent():
    """Their places jump by up to a third of a period, along x alone."""

    def facets(u, v, monitor):
        i, j = np.floor(u * 400 / 29), np.floor(v * 400 / 29)
        x = 0.5 + 0.7 * u + 0.014 * ((3 * i + 5 * j) % 4)
        return x * monitor[0], (0.5 + 0.8 * v + 0.2 * u * u) * monitor[1]

    scene = drawn(size=(400, 300), place=facets, dtype=np.uint16)
    codes = read_coding(scene.patterns, scene.grid.monitor_px)
    found = squared_bias(scene.images, codes, OF_WINDOWS, 0.0, 0.1, LINEAR)
    assert np.quantile(found, 0.9) < 1e-8  # square of 1e-4 periods


def test_edges_of_cells_stay_where_they_are_whatever_the_response():
    """A picture and its inverse are equal midway between their edges."""
    plan = PatternPlan((4, 4), True)
    scene = drawn(size=(240, 180), plan=plan, blur=2.0)
    grey = np.arange(256) / 255
    bent = np.rint(255 * grey**2.2).astype(np.uint8)[scene.images]
    first = decode(scene.images, scene.patterns, scene.grid, noise=0.5)
    second = decode(bent, scene.patterns, scene.grid, noise=0.5)
    both = first.mask & second.mask
    assert both.mean() > 0.4
    assert np.mean(first.cells[both] != second.cells[both]) < 1e-3
    own = [k for k, p in enumerate(scene.patterns) if not p.inverse]
    levels = {"white": 3 * (scene.white // 4), "black": scene.black, "noise": 0.5}
    single = decode(
        scene.images[own], [scene.patterns[k] for k in own], scene.grid, **levels
    )
    both &= single.mask
    assert np.mean(first.cells[both] != single.cells[both]) > 0.005
