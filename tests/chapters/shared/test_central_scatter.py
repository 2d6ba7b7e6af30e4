"""Scatter of rays about a centre, depth spread, and the shift of a lens."""

from types import SimpleNamespace

import numpy as np
import pytest

from chapters.ch04_central_generic.s3_1_setup.experiment import shift_between
from chapters.shared.central.sets import TrueGrids, shared_rays, true_grids
from chapters.shared.central.three_grids import (
    best_lines,
    calibrated,
    crossings,
    depth_spread,
    facing_plane,
    scatter_of,
    tilted_over_facing,
)
from raxel.cameras import Rays
from raxel.geometry import inverse_pose, pose, rotation_from_vector, transform

RNG = np.random.default_rng(3)
CENTRE = np.array([10.0, -5.0, -200.0])
POSES = np.array(
    [
        np.eye(4),
        pose(rotation_from_vector(np.array([0.3, 0.1, 0.0])), [5.0, 9.0, 40.0]),
        pose(rotation_from_vector(np.array([-0.2, 0.4, 0.1])), [-3.0, 2.0, 90.0]),
    ]
)


def seen_along(origins, directions):
    """Points (3, N, 2) where lines meet the three grids."""
    points = []
    for T in inverse_pose(POSES):
        o = transform(T, origins)
        d = directions @ T[:3, :3].T
        points.append((o - d * (o[:, 2:] / d[:, 2:]))[:, :2])
    return np.array(points)


def directions_ahead(count):
    d = RNG.normal(size=(count, 3)) * [0.25, 0.25, 0.05] + [0, 0, 1]
    return d / np.linalg.norm(d, axis=1, keepdims=True)


def test_best_lines_and_scatter_of_non_central_rays():
    d = directions_ahead(4000)
    across = facing_plane(d)
    off = RNG.normal(size=(4000, 2)) * [0.3, 0.1]
    points = seen_along(CENTRE + off @ across, d)
    lines = best_lines(points, POSES)
    along = np.sum(lines.directions * d, axis=1)
    np.testing.assert_allclose(np.abs(along), 1, atol=1e-12)
    crossing = crossings(CENTRE, lines)
    np.testing.assert_allclose(np.abs(crossing), np.abs(off), atol=1e-8)
    scatter = scatter_of(crossing)
    assert scatter["rms_mm"] == pytest.approx(np.hypot(0.3, 0.1), rel=0.05)
    assert scatter["eigenvalues"] == pytest.approx(1 / 9, rel=0.1)
    assert scatter["kurtosis"] < 0.5
    assert scatter["inside"]


def test_every_method_recovers_exact_grids():
    d = directions_ahead(300)
    points = seen_along(np.broadcast_to(CENTRE, d.shape), d)
    found = calibrated(points, TrueGrids(CENTRE, POSES, 0.0))
    for method in found.values():
        assert method["centre_off_mm"] < 1e-6
        assert method["ray_mean_mm"] < 1e-7
        assert method["all"]["rms_mm"] < 1e-5
    assert found["cgsp"]["cz"] == pytest.approx(-200)
    spread = depth_spread(CENTRE, points, POSES)
    assert 0 < spread.min() < spread.max() < 1


def test_image_shift_is_measured_from_decoded_points():
    v, u = np.indices((60, 80)).astype(float)

    def seen(u, v):
        return np.stack([0.4 * u + 0.01 * v + 1e-3 * u * v, 0.3 * v - 0.02 * u], -1)

    moved = seen(u - 1.2, v + 0.7)
    moved[:20] = np.nan
    np.testing.assert_allclose(shift_between(seen(u, v), moved), [1.2, -0.7], atol=0.01)


def test_shared_rays_keep_their_pixels():
    width, height = 40, 25
    points = seen_along(np.tile(CENTRE, (1000, 1)), directions_ahead(1000))
    blind = RNG.random(1000) < 0.2
    points[1, blind] = np.nan
    for most in (5000, 300):
        found = shared_rays(points, width, np.random.default_rng(0), most=most)
        assert found.found == 1000 - blind.sum()
        u, v = found.pixels.astype(int).T
        assert u.max() < width
        assert height - 5 < v.max() < height
        np.testing.assert_array_equal(points[:, v * width + u], found.points)


def test_true_scatter_is_the_distance_of_rays_from_the_centre():
    """Wherever on them they begin, as they do at a mirror."""
    d = directions_ahead(3000)
    aside = RNG.normal(0, 0.4, (3000, 3))
    aside -= np.sum(aside * d, axis=1, keepdims=True) * d
    origins = CENTRE + aside + RNG.uniform(5, 80, (3000, 1)) * d
    camera = SimpleNamespace(rays=lambda pixels: Rays(origins, d, np.ones(3000, bool)))
    T_camera_base = pose(rotation_from_vector(np.array([0.2, 0.1, -0.3])), [4.0, 5, 6])
    poses = T_camera_base @ POSES
    true = true_grids(camera, poses, np.zeros((3000, 2)))
    np.testing.assert_allclose(true.T_base_grid, POSES, atol=1e-12)
    expected = transform(inverse_pose(T_camera_base), CENTRE)
    np.testing.assert_allclose(true.centre, expected, atol=0.3)
    assert true.scatter_mm == pytest.approx(0.4 * np.sqrt(2), rel=0.05)


def test_tilted_plane_widens_the_scatter():
    count = 3000
    d = np.tile([0.0, 0.0, 1.0], (count, 1))
    off = np.column_stack([RNG.normal(size=(count, 2)) * 0.2, np.zeros(count)])
    lines = best_lines(seen_along(CENTRE + off, d), POSES)
    found = tilted_over_facing(CENTRE, lines)
    # Across the direction of the least tilt, 10 degrees, a round cloud grows by 1/cos.
    expected = np.sqrt((1 + 1 / np.cos(np.radians(10.0)) ** 2) / 2)
    assert found == pytest.approx(expected, rel=0.003)
