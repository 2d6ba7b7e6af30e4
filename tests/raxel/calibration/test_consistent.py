"""Bundle adjustment that moves the centre: derivatives, exactness, what it promises."""

import tracemalloc

import numpy as np
import pytest

from raxel.calibration import adjust_consistent
from raxel.calibration.adjust import ray_elimination as elimination
from raxel.calibration.adjust.bundle import (
    image_whitening,
    squared_residuals,
    start_directions,
)
from raxel.calibration.adjust.ray_elimination import (
    LOSSES,
    moved,
    normal_equations,
    steps_of_poses,
)
from raxel.errors import CalibrationError, InputError
from raxel.geometry import angle_between_rotations
from tests.calibration_scenes import central_difference, meet_grids, partly_seen
from tests.calibration_scenes import scene as exact_scene
from tests.raised import raises_code
from tests.wide_angle_scenes import centre_error, drawn, plain_error

SHARE = 0.8  # of the rays that a grid is seen by


def rays_of(points, seen, centre, T):
    u = start_directions(points, seen, centre, T)
    return points, image_whitening(seen, u, centre, T), u


@pytest.mark.parametrize("loss", LOSSES)
def test_gradient_equals_differences_of_cost(loss):
    centre, T, _, points, seen = partly_seen(1, SHARE, count=80, noise=1.0)
    points, whitening, u = rays_of(points, seen, centre, T)
    bends = LOSSES[loss], 1e-5
    centre, T = moved(centre, T, 0.001 * np.random.default_rng(0).normal(size=21))

    def cost(step):
        rays = points, whitening, u.copy()
        return normal_equations(rays, *moved(centre, T, step), bends, 300).cost

    found = normal_equations((points, whitening, u), centre, T, bends, 300)
    if loss != "none":
        squares = squared_residuals((points, whitening, u), centre, T)
        assert np.nanmean(squares > 1e-5) > 0.02
    numeric = central_difference(cost, 21, 1e-6) / 2
    assert np.abs(found.gradient - numeric).max() < 1e-6 * np.abs(numeric).max()


def test_normal_matrix_is_derivative_of_gradient():
    # At zero residual nothing else is left of the second derivatives.
    centre, T, _, points, seen = partly_seen(2, SHARE, count=80)
    points, whitening, u = rays_of(points, seen, centre, T)

    def gradient(step):
        rays = points, whitening, u.copy()
        return normal_equations(rays, *moved(centre, T, step), settle=8).gradient

    normal = normal_equations((points, whitening, u), centre, T).normal
    # Units: a rotation of 1 rad moves points by several 100 mm.
    unit = 1 / np.sqrt(np.diag(normal))
    numeric = central_difference(gradient, 21)
    assert np.abs((normal - numeric) * np.outer(unit, unit)).max() < 1e-4


def test_whitening_matches_image_noise():
    centre, T, u, points = exact_scene(3, count=20)
    seen = np.ones(points.shape[:2], bool)
    whitening = image_whitening(seen, u, centre, T).astype(float)
    turned = u + 1e-4 * np.random.default_rng(0).standard_normal((20_000, *u.shape))
    for j, pose in enumerate(T):
        d, c = turned @ pose[:3, :3], (centre - pose[:3, 3]) @ pose[:3, :3]
        q = c[:2] - c[2] * d[..., :2] / d[..., 2:]
        e = (q - points[j]) / 1e-4
        a, b, w = whitening[j].T
        white = np.stack([a * e[..., 0] + b * e[..., 1], w * e[..., 1]])
        covariance = np.einsum("and,bnd->dab", white, white) / len(turned)
        assert np.abs(covariance - np.eye(2)).max() < 0.06


def test_consistent_adjustment_is_exact_on_exact_points():
    for seed in range(3):
        centre, T, u, points, seen = partly_seen(seed, SHARE, count=300)
        start = moved(centre, T, np.random.default_rng(seed).normal(size=21) * 0.01)
        found = adjust_consistent(points, seen, *start)
        assert found.converged
        assert np.abs(found.centre - centre).max() < 1e-8
        assert np.abs(found.T_base_grid[:, :3, 3] - T[:, :3, 3]).max() < 1e-8
        turns = angle_between_rotations(found.T_base_grid[:, :3, :3], T[:, :3, :3])
        assert turns.max() < 1e-10
        known = seen.any(axis=0)
        assert np.abs(found.directions[known] - u[known]).max() < 1e-11
        assert np.isnan(found.directions[~known]).all()


def test_results_do_not_depend_on_processors(monkeypatch):
    scene, linear = drawn(0, rays=20_000)
    start = linear.centre, linear.T_base_grid
    monkeypatch.setattr(elimination, "processors", lambda: 1)
    one = adjust_consistent(scene.noisy, None, *start)
    monkeypatch.setattr(elimination, "processors", lambda: 3)
    three = adjust_consistent(scene.noisy, None, *start)
    assert np.array_equal(one.covariance, three.covariance)
    assert np.array_equal(one.directions, three.directions)


def test_covariance_predicts_errors():
    squares, errors = [], []
    for seed in range(200):
        scene, linear = drawn(seed)
        found = adjust_consistent(scene.noisy, None, linear.centre, linear.T_base_grid)
        assert found.converged
        off = plain_error(found, scene)
        squares.append(off @ np.linalg.solve(found.covariance, off) / len(off))
        errors.append(centre_error(found.centre))
    assert 0.8 < np.mean(squares) < 1.25
    assert np.median(errors) <= 1.05


def test_given_sigma_is_used_unchanged():
    scene, linear = drawn(3)
    start = None, linear.centre, linear.T_base_grid
    once, twice = (
        adjust_consistent(scene.noisy, *start, sigma=sigma).covariance
        for sigma in (0.3, 0.6)
    )
    # The weights are held in single precision.
    np.testing.assert_allclose(twice, 4 * once, rtol=1e-4, atol=1e-6 * once.max())


def test_pose_steps_equal_differences():
    centre, T, _, _ = exact_scene(0)
    change = steps_of_poses(T)
    for column, step in enumerate(1e-6 * np.eye(15)):
        new_centre, new = moved(centre, T, step)
        plain = [new_centre - centre]
        for j in (1, 2):
            R = T[j, :3, :3].T @ new[j, :3, :3]
            plain += [[R[2, 1], R[0, 2], R[1, 0]], new[j, :3, 3] - T[j, :3, 3]]
        assert np.allclose(np.concatenate(plain) / 1e-6, change[:, column], atol=1e-4)


def test_given_sigma_gives_unit_chi_square():
    scene, linear = drawn(1, noise=0.0)
    rng = np.random.default_rng(0)
    sigma = rng.uniform(0.1, 0.6, scene.points.shape)
    noisy = scene.points + sigma * rng.standard_normal(sigma.shape)
    found = adjust_consistent(
        noisy, None, linear.centre, linear.T_base_grid, sigma=sigma
    )
    assert found.reduced_chi_square == pytest.approx(1.0, abs=0.1)
    off = plain_error(found, scene)
    assert off @ np.linalg.solve(found.covariance, off) < 3 * len(off)


@pytest.mark.parametrize("loss", ["huber", "cauchy"])
def test_robust_loss_tolerates_outliers(loss):
    errors, noises = [], []
    for seed in range(8):
        scene, linear = drawn(seed)
        noisy = scene.noisy.copy()
        rng = np.random.default_rng(seed)
        bad = rng.random(noisy.shape[:2]) < 0.03
        noisy[bad] += rng.normal(scale=30.0, size=(bad.sum(), 2))
        start = linear.centre, linear.T_base_grid
        plain, robust = (
            adjust_consistent(noisy, None, *start, loss=name) for name in ("none", loss)
        )
        clean = adjust_consistent(scene.noisy, None, *start)
        errors.append([centre_error(plain.centre), centre_error(robust.centre)])
        noises.append(robust.noise / clean.noise)
    plain, robust = np.median(errors, axis=0)
    assert robust < 0.3 * plain
    # 3 % of wrong points shift the median's place by as much.
    assert np.median(noises) == pytest.approx(1.0, abs=0.1)


def test_adjustment_needs_less_than_200_bytes_per_ray():
    scene, linear = drawn(0, rays=50_000)
    points = np.ascontiguousarray(scene.noisy)
    seen = np.ones(points.shape[:2], bool)
    tracemalloc.start()
    adjust_consistent(points, seen, linear.centre, linear.T_base_grid)
    used = tracemalloc.get_traced_memory()[1] + points.nbytes
    tracemalloc.stop()
    assert used / points.shape[1] < 200


def test_bad_input_is_rejected_in_one_line():
    centre, T, _, points, seen = partly_seen(5, SHARE, count=80)
    alone = seen.copy()
    alone[3] = False
    behind = T.copy()
    behind[2, 2, 3] += 3 * centre[2]
    flat = exact_scene(6, count=100)
    parallel = flat[1].copy()
    parallel[1:, :3, :3], parallel[1:, 2, 3] = np.eye(3), (50.0, -50.0)
    both = meet_grids(flat[0], flat[2], parallel)
    for rejected, arguments in (
        (pytest.raises(CalibrationError, match="grid 3"), (points, alone, centre, T)),
        (
            pytest.raises(CalibrationError, match="grid 2"),
            (points, seen, centre, behind),
        ),
        (raises_code("not-finite"), (points, np.ones_like(seen), centre, T)),
        (
            raises_code("too-few-rays"),
            (exact_scene(5)[3][:, :3], None, *exact_scene(5)[:2]),
        ),
        (
            pytest.raises(InputError, match="'T_base_grid'"),
            (points, seen, centre, T[:3]),
        ),
        (raises_code("too-few-grids"), (points[:2], seen[:2], centre, T[:2])),
        (raises_code("parallel-grids"), (*both, flat[0], parallel)),
    ):
        with rejected:
            adjust_consistent(*arguments)
    with pytest.raises(InputError, match="loss: found 'l1'"):
        adjust_consistent(points, seen, centre, T, loss="l1")
    for sigma in (0.0, np.ones(len(points)), np.ones(points.shape[1])):
        with pytest.raises(InputError, match="sigma"):
            adjust_consistent(points, seen, centre, T, sigma=sigma)


def test_degrees_of_freedom_count_all_unknowns():
    """Of each point's two: two for a ray, three for the centre, six for a pose but the
    base's."""
    centre, T, _, points = exact_scene(6, count=12)
    grids, rays = points.shape[:2]
    found = adjust_consistent(points, None, centre, T)
    left = 2 * grids * rays - 2 * rays - 3 - 6 * (grids - 1)
    assert found.degrees_of_freedom == left
