"""Fixed-centre bundle adjustment: derivatives, exact recovery, descent."""

import numpy as np
import pytest

from raxel.calibration.adjust import bundle
from raxel.calibration.adjust.bundle import (
    bundle_adjust_fixed_centre,
    moved_poses,
    ray_directions,
    ray_point_residuals,
    reduced_normal_equations,
)
from raxel.geometry.poses import angle_between_rotations
from tests.calibration_scenes import central_difference, partly_seen, scene
from tests.raised import raises_code

SHARE = 0.7  # of the rays that a grid is seen by


def disturbed(T, seed, angle=0.02, length=5.0):
    step = np.random.default_rng(seed).normal(size=(len(T) - 1, 2, 3))
    return moved_poses(T, (step * np.array([[angle], [length]])).ravel())


def cost_at(points, seen, centre, poses):
    directions = ray_directions(points, seen, centre, poses)
    return np.sum(ray_point_residuals(points, seen, centre, poses, directions) ** 2)


def test_gradient_equals_differences_of_cost():
    centre, T, _, points, seen = partly_seen(1, SHARE, noise=1.0)
    poses = disturbed(T, 1)
    q = bundle.homogeneous(points, seen)
    cost, _, gradient = reduced_normal_equations(q, centre, poses)
    assert cost == pytest.approx(cost_at(points, seen, centre, poses), rel=1e-12)
    numeric = central_difference(
        lambda s: cost_at(points, seen, centre, moved_poses(poses, s)), 18
    )
    assert np.abs(2 * gradient - numeric).max() < 1e-6 * np.abs(numeric).max()


def test_normal_matrix_equals_eliminated_jtj():
    # Exact at zero residual, where elimination and projection agree.
    centre, T, _, points, seen = partly_seen(2, SHARE)
    _, normal, _ = reduced_normal_equations(bundle.homogeneous(points, seen), centre, T)

    def residuals(step):
        poses = moved_poses(T, step)
        u = ray_directions(points, seen, centre, poses)
        return ray_point_residuals(points, seen, centre, poses, u)[:, seen.any(axis=0)]

    jacobian = central_difference(residuals, 18).reshape(-1, 18)
    expected = jacobian.T @ jacobian
    assert np.abs(normal - expected).max() < 1e-6 * np.abs(expected).max()


@pytest.mark.parametrize("seed", range(3))
def test_bundle_recovers_disturbed_poses(seed):
    centre, T, directions, points, seen = partly_seen(seed, SHARE, count=200)
    result = bundle_adjust_fixed_centre(points, seen, centre, disturbed(T, seed))
    assert result.converged
    assert np.abs(result.T_base_grid[:, :3, 3] - T[:, :3, 3]).max() < 1e-6
    turns = angle_between_rotations(result.T_base_grid[:, :3, :3], T[:, :3, :3])
    assert turns.max() < 1e-8
    known = seen.any(axis=0)
    assert np.abs(result.directions[known] - directions[known]).max() < 1e-8
    assert np.isnan(result.directions[~known]).all()


def test_best_direction_minimises_distances():
    centre, T, _, points, seen = partly_seen(7, SHARE, noise=2.0)
    u = ray_directions(points, seen, centre, T)
    best = np.sum(ray_point_residuals(points, seen, centre, T, u) ** 2, axis=(0, 2))
    rng = np.random.default_rng(0)
    for size in (1e-4, 1e-2):
        other = u + size * rng.normal(size=u.shape)
        other /= np.linalg.norm(other, axis=1)[:, None]
        residuals = ray_point_residuals(points, seen, centre, T, other)
        assert np.all(np.sum(residuals**2, axis=(0, 2)) >= best - 1e-12)


def test_grid_without_common_rays_is_rejected():
    centre, T, _, points, seen = partly_seen(8, SHARE)
    seen[2] &= ~seen[[0, 1, 3]].any(axis=0)
    with raises_code("too-few-rays"):
        bundle_adjust_fixed_centre(points, seen, centre, T)


def test_non_finite_poses_are_rejected():
    centre, T, _, points, seen = partly_seen(9, SHARE)
    T[1, 0, 3] = np.nan
    with raises_code("not-finite"):
        bundle_adjust_fixed_centre(points, seen, centre, T)


@pytest.mark.parametrize(("shared", "enough"), [(2, False), (3, True)])
def test_bundle_needs_three_common_rays(shared, enough):
    centre, T, _, points = scene(10, grids=4, count=60)
    seen = np.ones(points.shape[:2], bool)
    seen[2, shared:] = False
    if enough:
        result = bundle_adjust_fixed_centre(points, seen, centre, disturbed(T, 10))
        assert result.converged
        return
    with raises_code("too-few-rays"):
        bundle_adjust_fixed_centre(points, seen, centre, T)
