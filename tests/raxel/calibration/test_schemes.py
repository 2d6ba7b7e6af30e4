"""The thesis's other adjustments, rays by centroids, free lines, central or not."""

import numpy as np
import pytest

from raxel.calibration import (
    adjust_concurrence,
    adjust_consistent,
    adjust_ray_point,
    centrality_test,
    centroid_directions,
    centroid_weights,
    relax_centrality,
    relax_poses,
)
from raxel.calibration.adjust.bundle import homogeneous
from raxel.calibration.adjust.consistent import pose_vector, poses_of_vector
from raxel.calibration.adjust.free_lines import concurrence_system
from raxel.calibration.adjust.ray_elimination import moved
from raxel.calibration.generic.central_test import correlation
from raxel.errors import InputError
from raxel.geometry import (
    intersect_rays_plane,
    on_plane,
    pose,
    rotation_from_vector,
    transform,
)
from tests.calibration_scenes import central_difference
from tests.calibration_scenes import scene as exact_scene
from tests.raised import raises_code
from tests.wide_angle_scenes import centre_error, drawn


def disturbed(centre, T, seed=0, size=0.05):
    rng = np.random.default_rng(seed)
    return moved(centre, T, size * rng.standard_normal(6 * len(T) - 3))


def everything(points):
    return np.ones(points.shape[:2], bool)


def test_relaxation_recovers_exact_poses():
    centre, T, u, points = exact_scene(1, grids=4, count=200)
    assert pose_vector(T).shape == (18,)
    assert np.allclose(poses_of_vector(pose_vector(T)), T, atol=1e-12)
    start = disturbed(centre, T)[1]
    found = relax_poses(points, everything(points), centre, start, tolerance=1e-12)
    assert found.converged
    assert np.abs(found.T_base_grid - T).max() < 1e-4
    assert np.abs(found.directions - u).max() < 1e-6


def test_centroid_directions_are_weighted():
    centre, T, u, points = exact_scene(2, count=50)
    seen = everything(points)
    seen[1, 0], seen[:, 1] = False, False
    points = points + np.random.default_rng(0).normal(size=points.shape)
    weights = np.array([3.0, 2.0, 1.0])
    found = centroid_directions(points, seen, centre, T, weights)
    P = transform(T, on_plane(points)) - centre
    middle = np.einsum("j,jnk->nk", weights, P)
    middle[0] -= 2 * P[1, 0]
    expected = middle / np.linalg.norm(middle, axis=1, keepdims=True)
    expected[1] = np.nan
    assert np.allclose(found, expected, equal_nan=True)
    assert np.abs(found[2:] - u[2:]).max() < 0.01
    with pytest.raises(InputError, match="weights"):
        centroid_directions(points, seen, centre, T, [1.0, 0.0, 1.0])


def test_centroid_weights_are_optimal():
    # Noise of points in mm, and of one pose: the weighted centroids scatter least.
    centre, T, u, points = exact_scene(3, count=40)
    covariances = np.zeros((3, 6, 6))
    covariances[2] = np.diag([1e-5, 1e-5, 1e-5, 2.0, 2.0, 2.0])
    weights = centroid_weights(
        points, everything(points), centre, T, covariances, 0.3, "plane"
    )
    rng = np.random.default_rng(0)
    errors = []
    for _ in range(300):
        noisy = points + 0.3 * rng.standard_normal(points.shape)
        poses = T.copy()
        step = np.zeros(15)
        step[9:] = rng.multivariate_normal(np.zeros(6), covariances[2])
        poses = moved(centre, T, step)[1]
        errors.append(
            [
                centroid_directions(noisy, everything(points), centre, poses, w) - u
                for w in (None, weights, weights * [[1.0], [1.0], [3.0]])
            ]
        )
    equal, ours, other = np.sqrt(np.mean(np.square(errors), axis=(0, 2, 3)))
    assert ours < 0.8 * equal
    assert ours < other


def test_jacobian_of_concurrence_equals_differences():
    centre, T, _, points = exact_scene(4, count=30)
    rng = np.random.default_rng(0)
    points = points + rng.normal(size=points.shape)
    seen = rng.random(points.shape[:2]) < 0.8
    seen[:2] = True
    q = homogeneous(points, seen)
    centre, T = disturbed(centre, T)
    _, jacobian = concurrence_system(q, centre, T)
    h = 1e-5
    numeric = [
        concurrence_system(q, *moved(centre, T, s))[0]
        - concurrence_system(q, *moved(centre, T, -s))[0]
        for s in h * np.eye(15)
    ]
    numeric = np.stack(numeric, axis=-1) / (2 * h)
    assert np.abs(jacobian - numeric).max() < 1e-7 * np.abs(numeric).max()


@pytest.mark.parametrize("adjust", [adjust_concurrence, adjust_ray_point])
def test_free_centre_recovers_exact_geometry(adjust):
    centre, T, _, points = exact_scene(5, grids=4, count=100)
    found = adjust(points, everything(points), *disturbed(centre, T))
    assert found.converged
    assert np.abs(found.centre - centre).max() < 1e-6
    assert np.abs(found.T_base_grid - T).max() < 1e-6


def test_concurrence_is_biased_by_noise():
    errors = []
    for seed in range(6):
        scene, linear = drawn(seed)
        start = linear.centre, linear.T_base_grid
        found = adjust_concurrence(scene.noisy, everything(scene.noisy), *start)
        assert np.all(np.diff(found.costs) < 0)
        errors.append([centre_error(linear.centre), centre_error(found.centre)])
    before, after = np.median(errors, axis=0)
    assert after > 5 * before


def beside_the_centre(scene, most, seed, sigma=0.2):
    """Noisy points of rays that start up to `most` mm along z from the centre."""
    u = scene.directions
    origins = np.tile([0.0, 0.0, 600.0], (len(u), 1))
    origins[:, 2] += most * (1 - np.abs(u[:, 2])) / (1 - np.abs(u[:, 2]).min())
    points = np.stack(
        [intersect_rays_plane(origins, u, T).points for T in scene.T_base_grid]
    )
    rng = np.random.default_rng(seed)
    return points + sigma * rng.standard_normal(points.shape), origins


def central_of(points, start, sigma=0.2):
    return adjust_consistent(points, None, start.centre, start.T_base_grid, sigma=sigma)


def test_free_lines_recover_exact_geometry():
    scene, linear = drawn(0, noise=0.0)
    points, origins = beside_the_centre(scene, 8.0, 0, sigma=0.0)
    lines = relax_centrality(points, central_of(points, linear), tolerance=1e-9)
    assert lines.used.all()
    assert np.abs(lines.T_base_grid - scene.T_base_grid).max() < 1e-6
    assert np.abs(lines.directions - scene.directions).max() < 1e-8
    assert np.abs(np.cross(lines.origins - origins, scene.directions)).max() < 1e-5


def test_centrality_test_separates_cameras():
    p_values, inside = [], []
    for seed in range(20):
        scene, linear = drawn(seed, noise=0.0)
        points, _ = beside_the_centre(scene, 0.0, seed)
        found = centrality_test(
            points, None, linear.centre, linear.T_base_grid, sigma=0.2
        )
        p_values.append([found.p_value, found.p_of_noise])
        inside.append(found.at_least_mm == 0.0)
    # A p-value is as often below a tenth as that.
    for column in np.transpose(p_values):
        assert 0.2 < np.mean(column < 0.5) < 0.8
        assert np.min(column) > 1e-3
    assert np.mean(inside) > 0.8
    scene, linear = drawn(0, noise=0.0)
    points, origins = beside_the_centre(scene, 8.0, 0)
    found = centrality_test(points, None, linear.centre, linear.T_base_grid, sigma=0.2)
    u = scene.directions
    across = np.eye(3) - u[:, :, None] * u[:, None, :]
    best = np.linalg.solve(across.sum(axis=0), np.einsum("nij,nj->i", across, origins))
    true = np.sqrt(np.mean(np.sum(np.cross(origins - best, u) ** 2, axis=1)))
    assert not found.central
    assert found.distance_mm == pytest.approx(true, rel=0.1)
    assert 0.9 * found.at_least_mm < true < 1.1 * found.at_most_mm
    assert str(found).startswith("not central: ")


def test_centrality_test_is_robust_to_gross_errors():
    scene, linear = drawn(0, noise=0.0, grids=4)
    rng = np.random.default_rng(0)
    start = linear.centre, linear.T_base_grid
    for most, central in ((0.0, True), (8.0, False)):
        points, _ = beside_the_centre(scene, most, 0)
        clean = centrality_test(points, None, *start, sigma=0.2)
        wrong = rng.random(points.shape[:2]) < 0.01
        points[wrong] += rng.uniform(-60, 60, (np.count_nonzero(wrong), 2))
        found = centrality_test(points, None, *start, sigma=0.2)
        assert found.central == clean.central == central
        assert found.noise_ratio == pytest.approx(1.0, abs=0.1)
        assert found.distance_mm == pytest.approx(clean.distance_mm, abs=1.0)
        assert found.rays > 0.9 * clean.rays
    points[rng.random(points.shape[:2]) < 0.2] += 40.0
    with raises_code("too-few-rays"):
        centrality_test(points, None, *start, sigma=0.2)


def test_window_correlation_reduces_weight():
    assert correlation(1) == 1.0
    rng = np.random.default_rng(0)
    sums = []
    for _ in range(400):
        raw = rng.standard_normal((46, 46))
        padded = np.pad(raw.cumsum(0).cumsum(1), ((1, 0), (1, 0)))
        of_windows = padded[7:, 7:] - padded[:-7, 7:] - padded[7:, :-7]
        smooth = (of_windows + padded[:-7, :-7]) / 7
        sums.append(np.sum(smooth**2))
    inflated = np.var(sums) / (2 * smooth.size)
    # At the edge of so small an image there are fewer neighbours.
    assert inflated == pytest.approx(correlation(7), rel=0.25)


def test_relaxation_round_moves_each_pose_once():
    """Steps of Gauss and Newton, as differences of the distances give them."""
    centre, T, _, points = exact_scene(4, count=60)
    seen, start = everything(points), disturbed(centre, T, size=0.3)[1]
    found = relax_poses(points, seen, centre, start, iterations=1, tolerance=0.0)
    u = centroid_directions(points, seen, centre, start)

    def off_rays(k, step):
        at = start[k] @ pose(rotation_from_vector(step[:3]), step[3:])
        reach = transform(at, on_plane(points[k])) - centre
        return (reach - np.sum(reach * u, axis=1)[:, None] * u).ravel()

    for k in (1, 2):
        J = central_difference(lambda step, k=k: off_rays(k, step), 6)
        step = -np.linalg.lstsq(J, off_rays(k, np.zeros(6)))[0]
        moved_there = start[k] @ pose(rotation_from_vector(step[:3]), step[3:])
        went = np.abs(moved_there - start[k]).max()
        assert np.abs(found.T_base_grid[k] - moved_there).max() < 1e-4 * went


def test_single_grid_rays_do_not_affect_concurrence():
    centre, T, _, points = exact_scene(5, count=80)
    points = points + 0.2 * np.random.default_rng(5).standard_normal(points.shape)
    seen, start = everything(points), disturbed(centre, T)
    seen[1:, :10] = False
    more = adjust_concurrence(points, seen, *start)
    shared = adjust_concurrence(points[:, 10:], seen[:, 10:], *start)
    assert np.array_equal(more.centre, shared.centre)
    assert np.array_equal(more.costs, shared.costs)


def test_plane_and_pose_noise_have_equal_weight():
    """Noise of 2 mm per axis and a pose that is 2 mm off do the same across a ray that
    meets its grid squarely; one that leans by 60 degrees sees of the former less."""
    lean = np.radians(60)
    slanted = rotation_from_vector([0, lean, 0])
    T = pose(np.array([np.eye(3), np.eye(3), slanted]), [[0, 0, 100.0]] * 3)
    shifted = np.zeros((3, 6, 6))
    shifted[1, 3:, 3:] = 4 * np.eye(3)
    points = np.zeros((3, 1, 2))
    weights = centroid_weights(
        points, everything(points), np.zeros(3), T, shifted, 2.0, "plane"
    )
    across = (4 * np.cos(lean) ** 2 + 4) / 2
    np.testing.assert_allclose(weights[:, 0], [100 / 4, 100 / 8, 100 / across])


def test_pose_rotation_moves_points_off_oblique_rays():
    """By differences: what each turn and shift of a grid does to a point, across the
    ray that sees it, on any side and at any slant."""
    rng = np.random.default_rng(4)
    T = pose(rotation_from_vector([0.3, -0.5, 0.7]), [20.0, -30.0, 150.0])
    points, step = rng.uniform(-80, 80, (6, 2)), 1e-6
    root = rng.normal(size=(6, 6)) * np.repeat([[1e-2], [1.0]], 3, axis=0)
    weights = centroid_weights(
        points[None], np.ones((1, 6), bool), np.zeros(3), T[None],
        (root @ root.T)[None], 1e-9, "plane",
    )[0]  # fmt: skip
    seen = transform(T, on_plane(points))
    length = np.linalg.norm(seen, axis=1)
    across = np.eye(3) - seen[:, :, None] * seen[:, None] / length[:, None, None] ** 2
    turns = [T @ pose(rotation_from_vector(step * e), np.zeros(3)) for e in np.eye(3)]
    shifts = [pose(np.eye(3), step * e) @ T for e in np.eye(3)]
    moves = [transform(U, on_plane(points)) - seen for U in turns + shifts]
    off = across @ np.stack(moves, axis=2) / step @ root
    np.testing.assert_allclose(weights, length / (off**2).sum((1, 2)) * 2, rtol=1e-4)


def test_free_line_noise_is_unbiased():
    """Two poses take twelve of the fifty coordinates that 25 lines leave."""
    scene, linear = drawn(0, noise=0.0)
    points, _ = beside_the_centre(scene, 0.0, 0)
    central = central_of(points, linear)
    variances = []
    for first in range(39):
        own = slice(first, None, 39)
        few = central._replace(
            whitening=central.whitening[:, own], directions=central.directions[own]
        )
        lines = relax_centrality(points[:, own], few)
        assert lines.degrees_of_freedom == 2 * len(lines.used) - 12
        variances.append(lines.noise**2)
    assert np.mean(variances) == pytest.approx(1, abs=0.1)
