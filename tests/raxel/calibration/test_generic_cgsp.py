"""CGSP complete: from boards and active grids to a camera."""

from types import SimpleNamespace

import numpy as np
import pytest

from raxel.calibration import calibrate_cgsp, dense_view
from raxel.calibration.generic import central_test as central_views
from raxel.calibration.generic import cgsp
from raxel.calibration.generic.board_growth import ray_table
from raxel.calibration.generic.central_test import centrality_of_views
from raxel.calibration.views import dense
from raxel.cameras import AxialCamera, centrality, pixel_grid
from raxel.evaluation.cross_validation import evaluate_camera
from raxel.geometry import inverse_pose, on_plane, pose, transform
from tests.board_scenes import FISHEYE, HEIGHT, WIDTH, board_poses, views_of
from tests.grid_scenes import SIZE_MM, grids_of, seen_points
from tests.raised import raises_code

POSES = board_poses(3, 5)
NOISE_MM = 0.05


class Sampled(Exception):
    """Number of requested pixels."""


@pytest.fixture(autouse=True)
def few_samples(monkeypatch):
    """Enough for these small images, and quicker."""
    monkeypatch.setattr(dense, "N_SAMPLES", 300)


def calibrated(views, **options):
    return calibrate_cgsp(views, WIDTH, HEIGHT, rng=np.random.default_rng(0), **options)


def centre_off(found, poses=POSES):
    return np.linalg.norm(found.centre - inverse_pose(poses[found.used[0]])[:3, 3])


@pytest.mark.parametrize("adjust", [True, False])
def test_cgsp_is_exact_on_exact_active_grids(adjust):
    views = grids_of(POSES, FISHEYE)
    found = calibrated(views, adjust=adjust)
    assert sorted(found.used) == list(range(len(POSES)))
    # Points are kept in single precision.
    assert centre_off(found) < 1e-5
    assert evaluate_camera(found.camera, views).rms_px < 1e-4
    assert found.linear.inliers.mean(axis=1).min() > 0.4


def test_cgsp_residual_equals_noise():
    found = calibrated(grids_of(POSES, FISHEYE, NOISE_MM))
    assert centre_off(found) < 0.03
    # Points 130 mm away, off by 0.05 mm along two axes; a ray adapts to its points.
    share = found.grid_rms_deg / np.degrees(np.sqrt(2) * NOISE_MM / 130)
    assert np.all((share > 0.5) & (share < 1))
    assert found.weights.tolist() == [1.0] * len(POSES)


def test_cgsp_accepts_boards():
    found = calibrated(views_of(POSES, noise=0.1))
    assert sorted(found.used) == list(range(len(POSES)))
    assert centre_off(found) < 1.5
    assert evaluate_camera(found.camera, views_of(POSES)).rms_px < 0.15


def spoilt(views_points, share, rng):
    points = views_points.copy()
    wrong = rng.random(points.shape[:2]) < share
    points[wrong] += rng.uniform(-40, 40, (np.count_nonzero(wrong), 2))
    return points


def test_cgsp_tolerates_wrong_points():
    rng = np.random.default_rng(1)
    points = [seen_points(FISHEYE, T) for T in POSES]
    views = [
        dense_view(spoilt(p, 0.05, rng), name=f"{k}") for k, p in enumerate(points)
    ]
    found = calibrated(views, adjust=False)
    assert sorted(found.used) == list(range(len(POSES)))
    assert np.linalg.norm(found.linear.centre - found.centre) == 0
    assert centre_off(found) < 1e-3


def test_unrelated_grid_is_rejected_with_reason():
    rng = np.random.default_rng(2)
    points = [seen_points(FISHEYE, T) for T in POSES]
    points[2] = np.where(
        np.isnan(points[2]), np.nan, rng.uniform(0, 130, points[2].shape)
    )
    found = calibrated([dense_view(p, name=f"{k}") for k, p in enumerate(points)])
    assert sorted(found.used) == [0, 1, 3, 4]
    assert "pose" in found.left_out[2]


def test_grid_without_base_overlap_gets_pose_from_rays():
    """A chain of grids: the last overlaps two others, not the base."""
    shifts = np.array([[0, 0, 0], [-25, 5, 5], [25, -5, 10], [-75, 0, 0], [75, 0, 5.0]])
    T = board_poses(3, 5, spread=(0.0, 0.0))
    T[:, :3, 3] += shifts
    views = grids_of(T, FISHEYE, NOISE_MM, size_mm=0.6 * SIZE_MM)
    found = calibrated(views)
    assert sorted(found.used) == list(range(5))
    began = len(found.linear.T_base_grid)
    assert began < 5
    assert centre_off(found, T) < 0.3
    covered = sum(view.covered(WIDTH, HEIGHT).astype(int) for view in views)
    assert found.pixels_of_one_grid == np.count_nonzero(covered == 1) > 0
    assert found.share_with_ray == np.mean(covered > 0)
    assert np.all(found.weights[:began] == 1)
    assert np.all(found.weights <= 1)


def test_parallel_and_separate_grids_are_rejected():
    flat = pose(np.eye(3), [[-70.0, -60, 120], [-90, -50, 140], [-60, -70, 150]])
    with raises_code("not-determined"):
        calibrated(grids_of(flat, FISHEYE, NOISE_MM))
    apart = board_poses(3, 3, spread=(0.0, 0.0))
    apart[:, :3, 3] += [[-80.0, 0, 0], [0, 0, 0], [80, 0, 0]]
    with raises_code("no-overlap"):
        calibrated(grids_of(apart, FISHEYE, size_mm=0.4 * SIZE_MM))


def one_centre(views):
    """The CentralTest of these views, by the poses that CGSP gives them."""
    found = calibrated(views)
    used = [views[k] for k in found.used]
    return centrality_of_views(used, WIDTH, HEIGHT, found.T_camera_grid)


def test_centrality_test_measures_fisheye_distance():
    law = "equidistance", 100.0, [122.0, 88.0]
    camera = AxialCamera(*law, (30.0,), WIDTH, HEIGHT, np.pi / 2)
    views = grids_of(POSES, camera, NOISE_MM)
    found = one_centre(views)
    shared = sum(view.covered(WIDTH, HEIGHT) for view in views) >= 3
    true = centrality(camera.rays(pixel_grid(WIDTH, HEIGHT)[shared.ravel()]))
    assert not found.central
    assert found.at_least_mm < true < found.at_most_mm
    assert found.noise_ratio == pytest.approx(1.0, abs=0.1)


@pytest.mark.parametrize("seen", [grids_of, views_of])
def test_central_views_pass_centrality_test(seen):
    noise = {grids_of: NOISE_MM, views_of: 0.1}[seen]
    p_values = [
        one_centre(seen(board_poses(k, 5), FISHEYE, noise, k)).p_value for k in (21, 22)
    ]
    assert min(p_values) > 1e-3
    assert max(p_values) > 0.1


def test_too_few_common_pixels_give_no_test():
    T = board_poses(3, 3, spread=(0.0, 0.0))
    T[:, :3, 3] += [[-60.0, 0, 0], [0, 0, 0], [60, 0, 0]]
    views = grids_of(T, FISHEYE, NOISE_MM, size_mm=0.3 * SIZE_MM)
    assert centrality_of_views(views, WIDTH, HEIGHT, T) is None


def test_grid_weight_scales_influence():
    T = POSES[:2]
    exact = [seen_points(FISHEYE, one) for one in T]
    moved = [dense_view(exact[0]), dense_view(exact[1] + 1.0)]
    plain, light = (
        ray_table(moved, T, np.zeros(3), WIDTH, HEIGHT, weights)
        for weights in (None, np.array([1.0, 0.1]))
    )
    true = ray_table([dense_view(p) for p in exact], T, np.zeros(3), WIDTH, HEIGHT)
    both = np.isfinite(exact[0] + exact[1])[..., 0]
    off = [np.linalg.norm(t[both] - true[both], axis=1) for t in (plain, light)]
    flat = [on_plane(p[both]) for p in exact]
    near, far = (
        np.sum(transform(one, p) ** 2, axis=1) for one, p in zip(T, flat, strict=True)
    )
    # Distances from the ray: a point counts with the square of its range.
    share = [w * far / (near + w * far) for w in (1.0, 0.1)]
    ratio = np.median(off[1] / off[0] / (share[1] / share[0]))
    assert ratio == pytest.approx(1.0, abs=0.01)


@pytest.mark.parametrize("every_pixel", [True, False])
def test_centrality_test_limits_correlated_pixels(monkeypatch, every_pixel):
    """One for each window of the decoder, 7 x 7 px, or for each cell of a board."""

    def taken(views, width, height, count):
        raise Sampled(count)

    monkeypatch.setattr(central_views, "sample_boards", taken)
    monkeypatch.setattr(central_views, "interpolated_view", lambda view, way: (view, 0))
    view = SimpleNamespace(
        every_pixel=every_pixel, columns=9, rows=7, area=lambda: 4900.0, sd=None
    )
    with pytest.raises(Sampled) as reported:
        centrality_of_views([view] * 3, 100, 80, np.tile(np.eye(4), (3, 1, 1)))
    assert reported.value.args[0] == pytest.approx(3 * (100 if every_pixel else 8 * 6))


def test_grid_points_keep_their_pixel_sigma(monkeypatch):
    rng = np.random.default_rng(11)
    views = [
        SimpleNamespace(every_pixel=True, sigma=rng.uniform(1, 2, (6, 9, 2)))
        for _ in range(4)
    ]
    pixels = np.column_stack([rng.integers(0, 9, 20), rng.integers(0, 6, 20)])
    samples = SimpleNamespace(
        pixels=pixels, points=np.zeros((4, 20, 2)), seen=np.ones((4, 20), bool)
    )
    start = SimpleNamespace(linear=SimpleNamespace(centre=None))
    growth = SimpleNamespace(boards=[2, 0, 3], T_base_grid=None, start=start)
    result = SimpleNamespace(centre=None, T_base_grid=None, directions=None)
    given = {}

    def adjusted(*_, sigma, loss):
        given["sigma"] = sigma
        return result

    monkeypatch.setattr(cgsp, "adjust_consistent", adjusted)
    cgsp._adjusted(views, samples, growth)
    for own, board in zip(given["sigma"], growth.boards, strict=True):
        for sigma, (u, v) in zip(own, pixels, strict=True):
            np.testing.assert_array_equal(sigma, views[board].sigma[v, u])
