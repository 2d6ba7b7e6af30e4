"""Calibrations from the points that every pixel has read of an active grid."""

import numpy as np
import pytest

from raxel.calibration import (
    calibrate_generic,
    calibrate_opencv_fisheye,
    calibrate_zhang,
    dense_view,
    locate_pixels,
)
from raxel.calibration.generic.board_growth import ray_table
from raxel.calibration.views import dense
from raxel.calibration.views.correspondence import add_points
from raxel.cameras import PerspectiveCamera, pixel_grid
from raxel.errors import InputError
from raxel.evaluation import angular_residual, evaluate_camera
from raxel.evaluation.coverage import board_counts
from raxel.evaluation.misfit import misfit
from raxel.geometry.poses import angle_between_rotations
from tests.board_scenes import FISHEYE, HEIGHT, WIDTH, board_poses
from tests.grid_scenes import SIZE_MM, grids_of, seen_points

K = np.array([[230.0, 0.0, 121.0], [0.0, 228.0, 88.0], [0.0, 0.0, 1.0]])
PINHOLE = PerspectiveCamera(K, [-0.2, 0.05], WIDTH, HEIGHT)
POSES = board_poses(3, 5)
NEARER = board_poses(3, 5, spread=(25.0, 20.0))
NOISE_MM = 0.05


@pytest.fixture(autouse=True)
def few_samples(monkeypatch):
    """Enough for these small images, and quicker."""
    monkeypatch.setattr(dense, "N_SAMPLES", 300)


def rays_off(camera, views):
    """Angles (rad) of a camera's rays to the fisheye's, frames aligned."""
    pixels = pixel_grid(WIDTH, HEIGHT)
    rays, true = camera.rays(pixels), FISHEYE.rays(pixels)
    both = rays.valid & true.valid
    assert np.array_equal(rays.valid, board_counts(views, WIDTH, HEIGHT).ravel() > 0)
    return angular_residual(rays.directions[both], true.directions[both])


def test_dense_view_calibrates_lens_to_single_precision():
    found = calibrate_zhang(grids_of(NEARER, PINHOLE), WIDTH, HEIGHT)
    assert np.abs(found.camera.K - K).max() < 5e-3
    assert np.abs(found.camera.radial - PINHOLE.radial).max() < 1e-4
    turns = angle_between_rotations(found.T_camera_grid[:, :3, :3], NEARER[:, :3, :3])
    assert turns.max() < 2e-5
    fisheye = calibrate_opencv_fisheye(grids_of(POSES, FISHEYE), WIDTH, HEIGHT)
    assert rays_off_everywhere(fisheye.camera) < 5e-5


def rays_off_everywhere(camera):
    pixels = pixel_grid(WIDTH, HEIGHT)[::7]
    directions = [c.rays(pixels).directions for c in (camera, FISHEYE)]
    return angular_residual(*directions).max()


def test_dense_view_calibrates_every_pixel():
    views = grids_of(POSES, FISHEYE)
    found = calibrate_generic(views, WIDTH, HEIGHT, rng=np.random.default_rng(0))
    assert sorted(found.used) == list(range(len(POSES)))
    assert found.interpolation == ("none",) * len(POSES)
    # Points are kept in single precision.
    assert rays_off(found.camera, views).max() < 2e-6
    assert found.share_with_ray == np.mean(board_counts(views, WIDTH, HEIGHT) > 0)


def test_dense_residual_equals_noise():
    views = grids_of(POSES, FISHEYE, NOISE_MM)
    found = calibrate_generic(views, WIDTH, HEIGHT, rng=np.random.default_rng(0))
    exact = grids_of(POSES, FISHEYE)
    # A ray depends on one to five points 130 mm away, each with an error of 0.05 mm
    off = rays_off(found.camera, exact)
    assert 0.2 < np.sqrt(np.mean(off**2)) / (np.sqrt(2) * NOISE_MM / 130) < 1
    scores = evaluate_camera(found.camera, grids_of(POSES, FISHEYE, NOISE_MM, seed=1))
    assert scores.share_with_ray > 0.95
    judged = misfit(scores.images, views)
    assert not judged.large
    # The scores hold the noise of fresh points and of the table.
    assert 1 < judged.rms_px / judged.sd_px < 1.5


def test_wrong_lens_model_is_reported():
    views = grids_of(NEARER, PINHOLE, NOISE_MM)
    straight = PerspectiveCamera(K, [0.0, 0.0], WIDTH, HEIGHT)
    assert not misfit(evaluate_camera(PINHOLE, views).images, views).large
    assert misfit(evaluate_camera(straight, views).images, views).large


def test_dense_sigma_is_converted_to_pixels():
    # A pinhole straight before the grid: 0.5 mm a pixel along u, 0.504 along v.
    camera = PerspectiveCamera(K, [0, 0], WIDTH, HEIGHT)
    T = np.eye(4)
    T[:3, 3] = -60, -40, 115
    points = seen_points(camera, T)
    sd = dense_view(points, np.broadcast_to([0.05, 0.1], points.shape)).sd
    sd = sd[np.isfinite(sd)]
    wanted = np.sqrt(((0.05 * 2) ** 2 + (0.1 * 228 / 115) ** 2) / 2)
    assert np.allclose(sd, wanted, rtol=1e-4)
    assert len(sd) > 0.8 * dense.N_SAMPLES
    assert dense_view(points).sd is None


def test_locate_does_not_interpolate_across_edges():
    points = seen_points(FISHEYE, POSES[0])
    points[60:70, 100:110] = np.nan
    points[:, 130:] += 40.0  # another facet
    view = dense_view(points)
    pixels = np.random.default_rng(4).uniform(-1, [WIDTH, HEIGHT], (4000, 2))
    found, inside = locate_pixels(pixels, view)
    u, v = np.floor(pixels).astype(int).T
    framed = (u >= 0) & (v >= 0) & (u < WIDTH - 1) & (v < HEIGHT - 1)
    corners = np.full((len(pixels), 4, 2), np.nan)
    for k, (i, j) in enumerate([(0, 0), (0, 1), (1, 0), (1, 1)]):
        corners[framed, k] = points[v[framed] + i, u[framed] + j]
    assert np.array_equal(inside, np.isfinite(corners).all(axis=(1, 2)) & (u != 129))
    a, b = (pixels - np.column_stack([u, v])).T[..., None]
    top = (1 - a) * corners[:, 0] + a * corners[:, 1]
    low = (1 - a) * corners[:, 2] + a * corners[:, 3]
    wanted = (1 - b) * top + b * low
    assert np.allclose(found[inside], wanted[inside], atol=1e-4)
    assert np.isnan(found[~inside]).all()


def test_mirrored_grid_is_flipped():
    points = seen_points(FISHEYE, POSES[0])
    seen = dense_view(points)
    mirrored = points.copy()
    mirrored[..., 1] = SIZE_MM[1] - points[..., 1]
    view = dense_view(mirrored)
    found = np.isfinite(view.pixels[:, 0])
    wanted = seen.points[found, 1] - SIZE_MM[1]
    assert np.allclose(view.points[found, 1], wanted, atol=1e-4)
    assert np.array_equal(view.points[:, 0], seen.points[:, 0])
    assert (view.mirrored, seen.mirrored) == (True, False)


@pytest.mark.parametrize(
    ("location", "more", "message"),
    [
        (np.zeros((9, 9)), {}, r"location: .*\(9, 9\)"),
        (np.zeros((9, 9, 2)), {}, "found 81 "),
        (np.zeros((20, 20, 2)), {"sigma": np.ones((20, 20))}, "sigma: "),
        (np.zeros((20, 20, 2)), {"mask": np.ones((2, 2), bool)}, "mask: "),
        (np.full((20, 20, 2), [np.nan, 1.0]), {}, "found 0 "),
    ],
)
def test_dense_view_rejects_invalid_input(location, more, message):
    with pytest.raises(InputError, match=f"one: {message}"):
        dense_view(location, **more, name="one")


@pytest.mark.parametrize("axis", [0, 1])
def test_dense_points_are_weighted_per_axis(axis):
    location = np.array([[[3.0, -2.0], [5.0, 7.0], [np.nan, 1.0]]], np.float32)
    sigma = np.full((1, 3, 2), 0.5, np.float32)
    sigma[0, 1, axis] = 1.2
    sums, plane = np.zeros((1, 3, 9)), np.eye(3)
    add_points(sums, location, sigma, plane, 2.0)
    weight = np.array([2 / 0.5, 2 / (0.25 + 1.44), 0.0])
    np.testing.assert_allclose(sums[0, :, 8], weight, rtol=1e-6)
    np.testing.assert_allclose(sums[0, :2, 6], weight[:2] * [3, 5], rtol=1e-6)
    np.testing.assert_allclose(sums[0, :2, 3], weight[:2] * [-6, 35], rtol=1e-6)


def test_dense_lattice_keeps_pixel_points():
    points = seen_points(FISHEYE, POSES[0])
    view = dense_view(points, np.full(points.shape, 0.1), name="a")
    found = np.isfinite(view.pixels[:, 0])
    assert dense.N_SAMPLES <= np.count_nonzero(found) < 1.5 * dense.N_SAMPLES
    assert len(view.pixels) == view.columns * view.rows
    u, v = view.pixels[found].astype(int).T
    assert np.array_equal(view.points[found], points[v, u].astype(np.float32))
    step = u[1] - u[0]
    assert {*(u - u[0]) % step, *(v - v[0]) % step} == {0}
    assert view.area() == np.count_nonzero(np.isfinite(points[..., 0]))


def test_precise_point_has_larger_weight():
    T = np.eye(4)[None] + np.array([[[0, 0, 0, 0]] * 2 + [[0, 0, 0, 100.0], [0] * 4]])
    grids = []
    for shift, sigma in ((0.0, 0.1), (1.0, 0.3)):
        points = np.full((20, 20, 2), shift)
        grids.append(dense_view(points, np.full(points.shape, sigma)))
    table = ray_table(grids, np.concatenate([T, T]), np.zeros(3), 20, 20)
    assert np.allclose(100 * table[..., 0] / table[..., 2], 0.1, atol=1e-3)
