"""Pose from rays: Grunert's solutions, RANSAC, refinement."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from raxel.calibration.pose.three_point import (
    pose_from_rays,
    pose_of_spread_triples,
    pose_of_triples,
    pose_three_point_ransac,
    ray_point_system,
    refine_pose_ray_point,
    three_point_depths,
)
from raxel.geometry import (
    angle_between_rotations,
    on_plane,
    pose,
    rotation_from_vector,
    transform,
)
from tests.raised import raises_code
from tests.ray_scenes import unit


def triples(seed, count):
    rng = np.random.default_rng(seed)
    rotation = rotation_from_vector(0.6 * rng.normal(size=(count, 3)))
    shift = rng.uniform([-200, -200, 150], [200, 200, 900], (count, 3))
    points = rng.uniform(-150, 150, (count, 3, 2))
    corners = transform(pose(rotation, shift), on_plane(points))
    return points, corners, pose(rotation, shift)


def noisy_grid(seed, count=200, noise=0.0, outliers=0):
    rng = np.random.default_rng(seed)
    T = pose(rotation_from_vector([0.2, -0.3, 0.1]), [10.0, 20.0, 500.0])
    points = rng.uniform(-150, 150, (count, 2))
    directions = unit(transform(T, on_plane(points)))
    points = points + noise * rng.normal(size=points.shape)
    points[:outliers] = rng.uniform(-150, 150, (outliers, 2))
    return directions, points, T, rng


def distance_gaps(directions, points, depths):
    """Largest error of (2.26) of every solution, relative to the largest distance."""
    corners = depths[..., None] * directions[:, None]
    pairs = ([1, 0, 0], [2, 2, 1])
    found = corners[..., pairs[0], :] - corners[..., pairs[1], :]
    given_ = points[:, pairs[0]] - points[:, pairs[1]]
    square = np.sum(given_**2, axis=-1)
    gaps = np.abs(np.sum(found**2, axis=-1) - square[:, None])
    return gaps.max(axis=-1) / square.max(axis=-1)[:, None]


def test_three_point_solutions_include_truth():
    points, corners, _ = triples(0, 3000)
    depths = three_point_depths(unit(corners), points)
    gap = np.abs(depths - np.linalg.norm(corners, axis=2)[:, None]).max(axis=2)
    gap = np.min(np.where(np.isnan(gap), np.inf, gap), axis=1)
    # A few in ten thousand lie at a double root, where rounding may lose both.
    assert np.mean(gap > 1e-5) < 1e-3
    assert np.median(gap) < 1e-9


@settings(max_examples=60, deadline=None)
@given(st.integers(0, 2**32 - 1))
def test_three_point_has_at_most_eight_solutions(seed):
    points, corners, _ = triples(seed, 8)
    directions = unit(corners)
    depths = three_point_depths(directions, points)
    assert depths.shape == (8, 8, 3)
    assert np.array_equal(depths[:, 4:], -depths[:, :4], equal_nan=True)
    assert np.nanmax(distance_gaps(directions, points, depths)) < 1e-6
    flipped = three_point_depths(-directions, points)
    for ours, theirs in zip(depths, flipped, strict=True):
        a, b = (np.sort(x[np.isfinite(x[:, 0]), 0]) for x in (ours, theirs))
        assert len(a) == len(b)
        assert np.allclose(a, b, rtol=1e-5)


def test_poses_of_exact_triples():
    points, corners, T = triples(3, 500)
    poses, triple = pose_of_triples(unit(corners), points)
    assert np.allclose(np.linalg.det(poses[:, :3, :3]), 1.0)
    gap = np.abs(poses - T[triple]).max(axis=(1, 2))
    best = np.full(500, np.inf)
    np.minimum.at(best, triple, gap)
    assert np.mean(best < 1e-4) > 0.995
    seen = transform(poses, on_plane(points[triple]))
    assert np.abs(unit(seen) - unit(corners)[triple]).max() < 1e-6


def test_degenerate_triples_give_no_pose():
    points, corners, _ = triples(4, 2)
    points[0, 1], corners[0, 1] = points[0, 0], corners[0, 0]
    points[1, 2] = (points[1, 0] + points[1, 1]) / 2
    corners[1, 2] = (corners[1, 0] + corners[1, 1]) / 2
    poses, _ = pose_of_triples(unit(corners), points)
    assert len(poses) == 0


@pytest.mark.parametrize(("metric", "threshold"), [("ray-point", 2.0), ("angle", 4e-3)])
def test_ransac_finds_inliers_and_refinement_improves(metric, threshold):
    directions, points, T, rng = noisy_grid(5, noise=0.3, outliers=60)
    rough = pose_three_point_ransac(directions, points, rng, threshold, metric=metric)
    fine = pose_from_rays(directions, points, rng, threshold, metric=metric)
    assert rough.inliers[60:].mean() > 0.95
    assert fine.inliers[60:].mean() > 0.99
    assert fine.inliers[:60].mean() < 0.1
    assert fine.rms < rough.rms
    turn = angle_between_rotations(fine.T_camera_grid[:3, :3], T[:3, :3])
    # 140 points with 0.3 mm noise on a 300 mm grid at 500 mm.
    assert np.degrees(turn) < 0.15
    assert np.linalg.norm(fine.T_camera_grid[:3, 3] - T[:3, 3]) < 0.5


def test_ransac_threshold_is_in_radians():
    """Few right pairs among wrong ones that lie beyond the threshold, not far off."""
    for seed in range(4):
        directions, points, _, rng = noisy_grid(seed, count=60)
        turn, far = rng.uniform(0, 2 * np.pi, 48), rng.uniform(3, 15, 48)
        points[12:] += (far * [np.cos(turn), np.sin(turn)]).T
        found = pose_three_point_ransac(directions, points, rng, 1e-3, metric="angle")
        assert found.inliers[:12].all()
        assert found.inliers[12:].sum() <= 2


def test_refinement_is_exact_for_many_origins():
    _, points, T, rng = noisy_grid(7)
    origins = 30.0 * rng.normal(size=(len(points), 3))
    directions = unit(transform(T, on_plane(points)) - origins)
    start = T @ pose(rotation_from_vector([0.05, -0.04, 0.1]), [8.0, -9.0, 20.0])
    found, cost = refine_pose_ray_point(directions, points, start, origins=origins)
    assert np.abs(found - T).max() < 1e-8
    assert cost < 1e-15


def test_jacobian_equals_differences():
    directions, points, T, rng = noisy_grid(8, count=20, noise=3.0)
    weights, origin = rng.uniform(0.5, 2.0, 20), np.array([1.0, 2.0, 3.0])
    _, jacobian = ray_point_system(directions, points, T, origin, weights)
    h = 1e-5
    for column in range(6):
        step = np.zeros(6)
        step[column] = h
        ends = []
        for s in (step, -step):
            moved = T @ pose(rotation_from_vector(s[:3]), s[3:])
            ends.append(ray_point_system(directions, points, moved, origin, weights)[0])
        numeric = (ends[0] - ends[1]) / (2 * h)
        assert (
            np.abs(numeric - jacobian[:, column]).max() < 1e-6 * np.abs(jacobian).max()
        )


def test_bad_input_is_rejected_in_one_line():
    directions, points, _, rng = noisy_grid(9, count=10)
    for code, arguments in (
        ("too-few-points", (directions[:2], points[:2], rng, 1.0)),
        (
            "not-finite",
            (np.where(directions > 0.9, np.nan, directions), points, rng, 1.0),
        ),
        ("no-pose", (directions, np.column_stack([points[:, 0]] * 2), rng, 1.0)),
    ):
        with raises_code(code):
            pose_from_rays(*arguments)


def test_spread_triples_tolerate_40_percent_outliers():
    """They agree with each other, as those of a board that is counted from another row
    do. By the mean angle, a pose between the two wins, 20 degrees off."""
    off = []
    for seed in range(12):
        directions, points, T, _ = noisy_grid(seed, 60, 0.1)
        points[:24] += [80.0, 0.0]
        found = pose_of_spread_triples(directions, points, count=14)
        off.append(np.degrees(angle_between_rotations(T[:3, :3], found[:3, :3])))
    assert max(off) < 0.5


@pytest.mark.parametrize(("metric", "threshold"), [("ray-point", 0.1), ("angle", 1e-4)])
def test_point_behind_origin_is_outlier(metric, threshold):
    directions, points, _, rng = noisy_grid(6, count=40)
    directions[:5] *= -1
    found = pose_three_point_ransac(directions, points, rng, threshold, metric=metric)
    np.testing.assert_array_equal(found.inliers, np.arange(40) >= 5)


def test_refinement_minimises_chosen_error():
    directions, points, _, rng = noisy_grid(7, count=60, noise=1.0)

    def angles(T):
        sight = unit(transform(T, on_plane(points)))
        return np.arcsin(np.linalg.norm(np.cross(sight, directions), axis=1))

    found = pose_from_rays(directions, points, rng, 0.1, metric="angle").T_camera_grid
    nearest, _ = refine_pose_ray_point(directions, points, found)
    # The sine's weights are those of the start, whose distances hardly change.
    assert np.sum(angles(found) ** 2) < np.sum(angles(nearest) ** 2) * (1 - 1e-5)


@pytest.mark.parametrize("nearer", [-2.0, 2.0])
def test_three_point_handles_points_on_both_sides(nearer):
    """Two points over one place of the third's ray: there both depths fit, mirrored."""
    corners = np.array([[3.0, 0, 10], [0, 0, 10 + nearer], [-1, 4, 10]])
    depths = np.linalg.norm(corners, axis=1)
    # The triangle laid flat: what is given are its sides.
    side = np.linalg.norm(corners - corners[0], axis=1)
    across = np.linalg.norm(corners[1] - corners[2])
    x = (side[1] ** 2 + side[2] ** 2 - across**2) / (2 * side[1])
    flat = np.array([[0, 0], [side[1], 0], [x, np.sqrt(side[2] ** 2 - x**2)]])
    found = three_point_depths(unit(corners)[None], flat[None])[0]
    assert np.nanmin(np.abs(found - depths).max(axis=1)) < 1e-6
