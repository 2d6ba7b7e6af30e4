"""The protocol of 4.3.1: three grids begin, further ones are placed from their rays."""

import numpy as np
import pytest

from raxel.calibration import (
    calibrate_central,
    centroid_directions,
    grid_pose_ransac,
    linear_cgsp,
    pose_from_rays,
    ray_point_distances,
    relaxed_start,
)
from raxel.errors import CalibrationError
from raxel.geometry import on_plane, transform
from tests.calibration_scenes import scene

FIRST = 3


def begun(noise=0.0, seed=3):
    """centre, T_base_grid, points (5, N, 2) and the linear stage of three of them."""
    centre, T, _, points = scene(seed, count=400, grids=5)
    points = points + noise * np.random.default_rng(0).standard_normal(points.shape)
    return centre, T, points, linear_cgsp(points[:FIRST], side=1)


@pytest.mark.parametrize("place", [grid_pose_ransac, pose_from_rays])
def test_further_grids_extend_calibrated_area(place):
    centre, T, points, start = begun()
    # Half of the rays see nothing of the first grids, but for those of the fourth.
    far = np.arange(points.shape[1]) % 2 == 1
    points[:FIRST, far] = np.nan
    points[4, ~far] = np.nan
    found = calibrate_central(points, start, place, np.random.default_rng(1))
    assert (found.used, found.failed) == ([0, 1, 2, 3, 4], {})
    np.testing.assert_allclose(found.T_base_grid, T, atol=1e-6)
    assert np.isfinite(found.directions).all()
    placed = transform(T[4], on_plane(points[4, far]))
    assert ray_point_distances(placed, centre, found.directions[far]).max() < 1e-6


def test_unjoined_grids_use_first_rays_only():
    _, _, points, start = begun()
    far = np.arange(points.shape[1]) % 2 == 1
    points[:FIRST, far] = np.nan
    points[4, ~far] = np.nan
    rng = np.random.default_rng(1)
    found = calibrate_central(points, start, grid_pose_ransac, rng, join=False)
    assert found.used == [0, 1, 2, 3]
    assert list(found.failed) == [4]
    assert "0 points" in found.failed[4]


def test_relaxation_keeps_centre_and_reduces_distances():
    _, _, points, start = begun(noise=0.5)
    first = points[:FIRST]
    seen = np.ones(first.shape[:2], bool)
    start.T_base_grid[2, :3, 3] += [1.0, -1.0, 2.0]
    relaxed = relaxed_start(first, start)
    np.testing.assert_array_equal(relaxed.centre, start.centre)

    def rms(T):
        rays = centroid_directions(first, seen, start.centre, T)
        placed = transform(T, on_plane(first))
        return np.sqrt(np.mean(ray_point_distances(placed, start.centre, rays) ** 2))

    assert rms(relaxed.T_base_grid) < 0.9 * rms(start.T_base_grid)
    every_third = relaxed_start(first[:, ::3], start)
    some = relaxed_start(first, start, most=first.shape[1] // 3)
    np.testing.assert_array_equal(some.T_base_grid, every_third.T_base_grid)


def test_ray_distances_are_perpendicular():
    points = np.array([[[0.0, 3.0, 7.0], [4.0, 0.0, -2.0]]])
    along_z = np.tile([0.0, 0.0, 1.0], (2, 1))
    np.testing.assert_allclose(
        ray_point_distances(points, np.zeros(3), along_z), [[3.0, 4.0]]
    )
    origins = np.array([[0.0, 3.0, 0.0], [4.0, 1.0, 0.0]])
    np.testing.assert_allclose(
        ray_point_distances(points, origins, along_z), [[0.0, 1.0]]
    )


def test_wrong_first_points_do_not_widen_threshold():
    """A tenth of them are 60 mm off; the usual distance is that of the others."""
    _, _, points, start = begun(noise=0.2)
    points[1, ::10] += [60.0, 0.0]
    limits = []

    def place(rays, seen, rng, threshold):
        limits.append(threshold)
        raise CalibrationError("only its limit is tested")

    calibrate_central(points, start, place, np.random.default_rng(1))
    assert len(limits) == 2
    assert max(limits) < 2.0
