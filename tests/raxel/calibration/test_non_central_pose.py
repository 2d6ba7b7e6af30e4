"""Pose of a flat grid from rays without a centre: exact, tilts, wrong pairs."""

import numpy as np
import pytest

from raxel.calibration.pose.non_central import other_tilt, pose_from_non_central_rays
from raxel.cameras import Rays
from raxel.geometry import (
    angle_between_rotations,
    on_plane,
    pose,
    rotation_from_vector,
    tangent_bases,
    transform,
    vector_from_rotation,
)
from tests.bent_mirror_scenes import GRID, bent, grid_pose, seen
from tests.raised import raises_code

CAMERA, T_TRUE = bent(10.0), grid_pose(turn=(9.0, -6.0, 20.0))
PIXELS = seen(CAMERA, T_TRUE)


def test_non_central_pose_is_exact_from_either_tilt():
    rays = CAMERA.rays(PIXELS)
    found = pose_from_non_central_rays(rays, GRID)
    assert np.abs(found.T_camera_grid - T_TRUE).max() < 1e-8
    assert found.rms < 1e-9
    assert not found.ambiguous
    np.testing.assert_array_equal(found.inliers, rays.valid)
    viewpoint = np.array([5.0, 0.0, 700.0])
    other = other_tilt(T_TRUE, GRID, viewpoint)
    assert angle_between_rotations(other[:3, :3], T_TRUE[:3, :3]) > 0.1
    np.testing.assert_allclose(other_tilt(other, GRID, viewpoint), T_TRUE, atol=1e-9)
    nearby = T_TRUE @ pose(np.eye(3), [3.0, -2.0, 5.0])
    again = pose_from_non_central_rays(rays, GRID, nearby)
    assert np.abs(again.T_camera_grid - T_TRUE).max() < 1e-8


def test_non_central_pose_rejects_outliers():
    rng = np.random.default_rng(1)
    rays = CAMERA.rays(PIXELS + 0.2 * rng.standard_normal(PIXELS.shape))
    wrong = rng.permutation(np.flatnonzero(rays.valid))[: rays.valid.sum() // 5]
    points = GRID.copy()
    points[wrong] = rng.uniform(GRID.min(0), GRID.max(0), (len(wrong), 2))
    found = pose_from_non_central_rays(rays, points)
    assert np.count_nonzero(found.inliers[wrong]) <= 1
    right = np.setdiff1d(np.flatnonzero(rays.valid), wrong)
    assert found.inliers[right].mean() > 0.97
    assert np.abs(found.T_camera_grid - T_TRUE).max() < 0.1


def test_non_central_covariance_predicts_scatter():
    rng, squares = np.random.default_rng(2), []
    for _ in range(15):
        rays = CAMERA.rays(PIXELS + 0.2 * rng.standard_normal(PIXELS.shape))
        found = pose_from_non_central_rays(rays, GRID, T_TRUE)
        shift = T_TRUE[:3, :3].T @ (found.T_camera_grid - T_TRUE)[:3, 3]
        squares.append(shift**2 / np.diag(found.covariance)[3:])
    assert 0.5 < np.mean(squares) < 1.8


def test_rays_without_pose_are_rejected():
    rays, rng = CAMERA.rays(PIXELS), np.random.default_rng(3)
    few = Rays(rays.origins, rays.directions, rays.valid & (np.arange(182) < 40))
    few = Rays(few.origins, few.directions, few.valid & (np.cumsum(few.valid) < 6))
    with raises_code("too-few-points"):
        pose_from_non_central_rays(few, GRID)
    assert pose_from_non_central_rays(rays, rng.permutation(GRID)).rms > 10


def test_other_tilt_has_similar_image():
    viewpoint = np.array([150.0, -90.0, 40.0])
    other = other_tilt(T_TRUE, GRID, viewpoint)
    assert angle_between_rotations(other[:3, :3], T_TRUE[:3, :3]) > 0.1
    middle = transform(T_TRUE, on_plane(GRID.mean(axis=0)[None]))[0]
    sight = (middle - viewpoint) / np.linalg.norm(middle - viewpoint)
    across = np.eye(3) - np.outer(sight, sight)
    flat_images = [
        (transform(T, on_plane(GRID)) - middle) @ across for T in (T_TRUE, other)
    ]
    np.testing.assert_allclose(*flat_images, atol=1e-9)


def test_non_central_covariance_holds_for_few_corners():
    """Noise of 0.05 mm both ways across each of twelve rays: what is left of it tells
    its size only if a distance counts as two equations, not as three."""
    rng, squares = np.random.default_rng(4), []
    points = rng.uniform(0, 60, (12, 2))
    T = pose(rotation_from_vector([0.4, -0.3, 0.2]), [-20, -30, 400])
    ends, R = transform(T, on_plane(points)), T[:3, :3]
    origins = rng.uniform(-15, 15, (12, 3))
    directions = ends - origins
    directions /= np.linalg.norm(directions, axis=1)[:, None]
    across = tangent_bases(directions)
    for _ in range(60):
        off = across @ rng.normal(0, 0.05, (12, 2, 1))
        rays = Rays(origins + off[..., 0], directions, np.ones(12, bool))
        found = pose_from_non_central_rays(rays, points, T)
        turn = vector_from_rotation(R.T @ found.T_camera_grid[:3, :3])
        error = np.append(turn, R.T @ (found.T_camera_grid - T)[:3, 3])
        squares.append(error @ np.linalg.solve(found.covariance, error))
    # Six numbers whose scale has 18 degrees of freedom: 6 * 18 / (18 - 2).
    assert np.mean(squares) == pytest.approx(6.75, abs=1.8)
