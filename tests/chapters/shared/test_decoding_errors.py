"""Decoding errors drawn again are like those of rendered images."""

import numpy as np
import pytest
import yaml

from chapters.shared.central.decoding_errors import (
    DecodingErrors,
    lattice_rays,
    measured_errors,
    redrawn_lattice,
    true_lattice,
)
from chapters.shared.central.sets import scored_grids, true_camera
from chapters.shared.rigs import RIGS
from raxel.lab import load_rig, render_set


@pytest.fixture(scope="module")
def seen(tmp_path_factory):
    """A view of the fisheye's monitor, with the cosine at which each pixel sees it."""
    data = yaml.safe_load((RIGS / "coolpix-4500-fce8-small.yaml").read_text("utf-8"))
    data["poses"]["list"] = data["poses"]["list"][1:2]
    folder = tmp_path_factory.mktemp("set")
    path = folder / "coolpix-4500-fce8-small.yaml"
    path.write_text(yaml.safe_dump(data), "utf-8")
    render_set(load_rig(path), folder / "set", 0)
    rays, shape = lattice_rays(true_camera(folder / "set"), 1)
    (grid,) = scored_grids(folder / "set")
    points, cosine = true_lattice(rays, shape, grid.T_camera_grid, (376.9, 301.5))
    np.testing.assert_allclose(points, grid.points, atol=1e-4)
    return grid, cosine


def test_redrawn_errors_resemble_rendered_ones(seen):
    grid, cosine = seen
    found = measured_errors([seen])
    again = redrawn_lattice(found, grid.points, cosine, np.random.default_rng(1))
    here = grid.decoded.mask & np.isfinite(again[..., 0])
    assert here.sum() > 0.95 * grid.decoded.mask.sum()
    real = (grid.decoded.location - grid.points)[here]
    drawn = (again - grid.points)[here]
    for measure in (np.std, lambda x, axis: np.median(np.abs(x), axis)):
        np.testing.assert_allclose(measure(drawn, 0), measure(real, 0), rtol=0.2)
    rebuilt = measured_errors([(grid._replace(decoded=_Like(again, grid)), cosine)])
    np.testing.assert_allclose(rebuilt.correlation_px, found.correlation_px, rtol=0.3)
    assert np.corrcoef(rebuilt.bias_mm.ravel(), found.bias_mm.ravel())[0, 1] > 0.8


class _Like:
    """Stands for a Decoded with other points."""

    def __init__(self, location, grid):
        self.location, self.sigma = location, grid.decoded.sigma
        self.mask = np.isfinite(location[..., 0])


def test_redrawn_lattice_is_correlated_by_distance():
    flat = np.zeros((2, 48, 8))
    errors = DecodingErrors(
        np.array([47.0, 38.0]), flat, np.ones((2, 8)), np.array([6.0, 3.0]),
        0.01, np.array([[30.0, 30.0]]), np.ones(2),
    )  # fmt: skip
    points = np.full((400, 500, 2), 100.0)
    drawn = redrawn_lattice(
        errors, points, np.ones((400, 500)), np.random.default_rng(2), step=3
    )
    off = drawn - points
    far = off[..., 0] > 15
    assert far.mean() == pytest.approx(0.01, abs=0.002)
    off[far] = 0
    for axis in (0, 1):
        a, b = off, np.roll(off, 1, axis)
        likeness = (a * b).mean((0, 1)) / (a * a).mean((0, 1))
        np.testing.assert_allclose(likeness, np.exp([-3 / 6, -3 / 3]), atol=0.03)
    np.testing.assert_allclose(off.std((0, 1)), 1, atol=0.03)


def test_bias_is_applied_where_it_was_measured():
    bias = np.zeros((2, 48, 8))
    bias[0] = np.sin(2 * np.pi * (np.arange(48) + 0.5) / 48)[:, None]
    errors = DecodingErrors(
        np.array([40.0, 40.0]), bias, np.zeros((2, 8)), np.ones(2),
        0.0, np.empty((0, 2)), np.ones(2),
    )  # fmt: skip
    x = np.linspace(0, 120, 1001)
    found = errors.bias_at(np.column_stack([x, x]), np.full(1001, 0.7))
    np.testing.assert_allclose(found[:, 0], np.sin(2 * np.pi * x / 40), atol=0.005)
    np.testing.assert_array_equal(found[:, 1], 0)
