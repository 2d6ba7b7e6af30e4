"""Pose of a grid from rays on a synthetic plane: linear, RANSAC, angles."""

import numpy as np
import pytest

from raxel.calibration.pose.grid_pose import (
    angular_system,
    grid_pose_ransac,
    linear_grid_pose,
    refine_pose_angular,
    synthetic_plane_normal,
    tangent_bases,
)
from raxel.geometry import (
    angle_between_rotations,
    on_plane,
    pose,
    rotation_from_vector,
    transform,
    vector_from_rotation,
)
from tests.raised import raises_code
from tests.ray_scenes import unit

T_TRUE = pose(rotation_from_vector([0.35, -0.3, 0.4]), [30.0, -40.0, 500.0])


def exact(seed, count=200, T=T_TRUE, half=300.0):
    rng = np.random.default_rng(seed)
    points = rng.uniform(-half, half, (count, 2))
    return unit(transform(T, on_plane(points))), points, rng


def shaken(directions, sigma, rng):
    """Directions with Gaussian noise of standard deviation sigma, both ways."""
    noise = sigma * rng.standard_normal((len(directions), 2, 1))
    return unit(directions + (tangent_bases(directions) @ noise)[..., 0])


def turn_and_shift(found, T=T_TRUE):
    turn = angle_between_rotations(found[:3, :3], T[:3, :3])
    return turn, np.linalg.norm(found[:3, 3] - T[:3, 3])


def tilted(normal, degrees, about):
    axis = unit(np.cross(normal, about))
    return rotation_from_vector(np.radians(degrees) * axis) @ normal


@pytest.mark.parametrize("degrees", [0, 20, 40, 60])
def test_linear_pose_is_exact_for_any_plane(degrees):
    directions, points, rng = exact(1)
    normal = tilted(synthetic_plane_normal(directions), degrees, [0.3, 1.0, 0.2])
    found = linear_grid_pose(directions, points, normal=normal)
    assert np.abs(found.T_camera_grid - T_TRUE).max() < 1e-9
    assert found.behind == np.count_nonzero(directions @ normal <= 0.01)
    again = grid_pose_ransac(directions, points, rng, 1e-6, normal=normal)
    assert np.abs(again.T_camera_grid - T_TRUE).max() < 1e-9
    assert np.count_nonzero(again.inliers) == len(points) - again.behind


def test_synthetic_normal_minimises_squared_sines():
    directions, _, rng = exact(2)
    normal = synthetic_plane_normal(-directions)

    def sines(n):
        return np.sum(np.cross(directions, n) ** 2)

    for other in unit(normal + 0.1 * rng.standard_normal((20, 3))):
        assert sines(normal) < sines(other)
    assert np.all(-directions @ normal > 0)


def test_rays_behind_plane_are_excluded():
    # The grid reaches from one side of the camera almost to the other: 165 degrees.
    near = pose(np.eye(3), [0.0, 0.0, 40.0])
    points = np.random.default_rng(3).uniform([-300, -20], [300, 20], (400, 2))
    directions = unit(transform(near, on_plane(points)))
    assert np.degrees(np.arccos((directions @ directions.T).min())) > 160
    found = linear_grid_pose(directions, points, normal=[1.0, 0.0, 0.3])
    assert 0 < found.behind < 300
    assert np.abs(found.T_camera_grid - near).max() < 1e-8


def test_facing_plane_meets_all_rays():
    near = pose(np.eye(3), [0.0, 0.0, 100.0])
    angle = np.linspace(0, 2 * np.pi, 40, endpoint=False)
    points = 250 * np.column_stack([np.cos(angle), np.sin(angle)])
    directions = unit(transform(near, on_plane(points)))
    across = synthetic_plane_normal(directions)
    assert abs(across[2]) < 1e-6
    assert linear_grid_pose(directions, points, normal=across).behind >= 18
    found = linear_grid_pose(directions, points)
    assert found.behind == 0
    assert np.abs(found.T_camera_grid - near).max() < 1e-9


@pytest.mark.parametrize(("metric", "threshold"), [("ray-point", 2.0), ("angle", 4e-3)])
def test_ransac_rejects_outliers_and_refits_inliers(metric, threshold):
    directions, points, rng = exact(5, count=1500)
    points += 0.3 * rng.standard_normal(points.shape)
    points[:300] = rng.uniform(-300, 300, (300, 2))
    found = grid_pose_ransac(directions, points, rng, threshold, metric=metric)
    assert found.inliers[300:].mean() > 0.99
    assert found.inliers[:300].mean() < 0.02
    right = found.inliers
    linear = linear_grid_pose(directions[right], points[right])
    # The plane of all rays is not quite that of the right ones.
    assert np.abs(linear.T_camera_grid - found.T_camera_grid).max() < 0.05
    everything = linear_grid_pose(directions, points).T_camera_grid
    assert turn_and_shift(found.T_camera_grid)[0] < turn_and_shift(everything)[0] / 20


def test_ransac_threshold_is_length_or_angle():
    directions, points, rng = exact(6, count=60)
    side = np.cross(directions, [0.0, 0.0, 1.0])
    for k, wrong in ((0, 1e-3), (1, 3e-3)):
        directions[k] = unit(directions[k] + wrong * unit(side[k]))
    for metric, size in (("angle", 1.0), ("ray-point", 500.0)):
        # The first is off by 1e-3 rad, about 0.5 mm at 500 mm; the other by 3e-3.
        found = grid_pose_ransac(directions, points, rng, 2e-3 * size, metric=metric)
        assert found.inliers[0]
        assert not found.inliers[1]


def test_angular_jacobian_equals_differences():
    directions, points, rng = exact(8, count=40)
    directions[:20] = shaken(directions[:20], 0.5, rng)
    directions[20:30] = shaken(directions[20:30], 1e-5, rng)
    across = tangent_bases(directions)
    residual, jacobian = angular_system(directions, across, points, T_TRUE)
    chord = np.linalg.norm(
        unit(transform(T_TRUE, on_plane(points))) - directions, axis=1
    )
    np.testing.assert_allclose(
        np.linalg.norm(residual, axis=1), 2 * np.arcsin(chord / 2), atol=1e-12
    )
    h = 1e-5
    for column in range(6):
        step = np.zeros(6)
        step[column] = h
        ends = []
        for s in (step, -step):
            moved = T_TRUE @ pose(rotation_from_vector(s[:3]), s[3:])
            ends.append(angular_system(directions, across, points, moved)[0])
        numeric = (ends[0] - ends[1]) / (2 * h)
        gap = np.abs(numeric - jacobian[:, :, column]).max()
        assert gap < 1e-6 * np.abs(jacobian).max()


@pytest.mark.parametrize("known", [True, False])
def test_angular_pose_is_more_accurate_than_linear(known):
    sigma, squared, linear, angular = 2e-3, [], [], []
    for seed in range(200):
        directions, points, rng = exact(seed, count=60)
        directions = shaken(directions, sigma, rng)
        start = linear_grid_pose(directions, points).T_camera_grid
        fine = refine_pose_angular(
            directions, points, start, sigma=sigma if known else None
        )
        T = fine.T_camera_grid
        error = np.concatenate(
            [
                vector_from_rotation(T[:3, :3].T @ T_TRUE[:3, :3]),
                T[:3, :3].T @ (T_TRUE[:3, 3] - T[:3, 3]),
            ]
        )
        squared.append(error @ np.linalg.solve(fine.covariance, error) / 6)
        linear.append(turn_and_shift(start)[0])
        angular.append(turn_and_shift(T)[0])
    assert 0.8 < np.mean(squared) < 1.25
    assert np.median(angular) < 0.95 * np.median(linear)


def test_bad_input_is_rejected_in_one_line():
    directions, points, rng = exact(9, count=20)
    line = np.column_stack([points[:, 0], 2 * points[:, 0]])
    on_line = unit(transform(T_TRUE, on_plane(line)))
    rejected = [
        ("too-few-rays", lambda: linear_grid_pose(directions[:3], points[:3])),
        ("normal", lambda: linear_grid_pose(
            directions, points, normal=[0.0, 0.0, 0.0])),
        ("too-few-rays", lambda: linear_grid_pose(
            directions, points, normal=[0.0, 0.0, -1.0])),
        ("bad-input", lambda: linear_grid_pose(on_line, line)),
        ("bad-input", lambda: grid_pose_ransac(on_line, line, rng, 1.0)),
        ("degenerate-points", lambda: refine_pose_angular(on_line, line, T_TRUE)),
        ("not-finite", lambda: grid_pose_ransac(
            directions, np.where(points > 290, np.nan, np.nan), rng, 1.0)),
        ("too-few-points", lambda: refine_pose_angular(
            directions[:3], points[:3], T_TRUE)),
    ]  # fmt: skip
    for code, call in rejected:
        with raises_code(code):
            call()


@pytest.mark.parametrize("count", [4, 7])
def test_unknown_noise_uses_six_parameters(count):
    """Two angles of each point; the turns and the shift take six of them."""
    directions, points, rng = exact(11, count)
    directions = shaken(directions, 1e-3, rng)
    own = refine_pose_angular(directions, points, T_TRUE)
    variance = count * own.rms**2 / (2 * count - 6)
    reported = refine_pose_angular(directions, points, T_TRUE, sigma=np.sqrt(variance))
    np.testing.assert_allclose(own.covariance, reported.covariance, rtol=1e-4)
