"""Algorithm 1 from chessboards to the table, and rejected input."""

from types import SimpleNamespace

import numpy as np
import pytest

from raxel.calibration import calibrate_generic, pixels_on_board, sample_boards
from raxel.calibration.generic import standard
from raxel.cameras.core.base import pixel_grid
from raxel.evaluation import angular_residual, evaluate_camera
from raxel.geometry.poses import inverse_pose, pose, rotation_from_vector
from tests.board_scenes import FISHEYE, HEIGHT, WIDTH, board_poses, views_of
from tests.raised import raises_code


def calibrated(views, **options):
    rng = np.random.default_rng(0)
    return calibrate_generic(views, WIDTH, HEIGHT, rng=rng, **options)


def ray_errors_deg(camera):
    pixels = pixel_grid(WIDTH, HEIGHT)[camera.mask.ravel()]
    found, true = camera.rays(pixels).directions, FISHEYE.rays(pixels).directions
    return np.degrees(angular_residual(found, true))


@pytest.fixture(scope="module")
def six_boards():
    poses = board_poses(0, 6)
    return poses, calibrated(views_of(poses))


@pytest.mark.parametrize(
    ("interpolation", "ray_deg", "centre_mm", "rms_deg"),
    # 12 mm cells, bent by a fisheye at 110 to 150 mm: some hundredths of a degree by
    # homographies (a pixel is 0.57 degrees).
    [("homographic", 0.06, 0.5, 0.01), ("by need", 0.012, 0.1, 0.002)],
)
def test_generic_rays_are_exact_within_interpolation(
    interpolation, ray_deg, centre_mm, rms_deg
):
    poses = board_poses(0, 6)
    found = calibrated(views_of(poses), interpolation=interpolation)
    assert sorted(found.used) == list(range(6))
    assert found.left_out == {}
    assert np.sqrt(np.mean(ray_errors_deg(found.camera) ** 2)) < ray_deg
    centre = inverse_pose(poses[found.used[0]])[:3, 3]
    assert np.linalg.norm(found.centre - centre) < centre_mm
    assert found.rms_deg < rms_deg


def test_generic_table_covers_boards(six_boards):
    poses, _ = six_boards
    found = calibrated(views_of(poses), interpolation="homographic")
    covered = np.zeros((HEIGHT, WIDTH), bool)
    for view in views_of(poses):
        u, v = pixels_on_board(view, WIDTH, HEIGHT)[0].T
        covered[v, u] = True
    assert np.array_equal(found.camera.mask, covered)
    assert found.share_with_ray == pytest.approx(np.mean(covered))


def test_generic_frames_are_consistent(six_boards):
    poses, found = six_boards
    T_camera_base = found.T_camera_grid[0]
    assert np.allclose(found.T_base_grid[0], np.eye(4))
    assert np.allclose(T_camera_base @ found.T_base_grid, found.T_camera_grid)
    assert np.allclose(T_camera_base @ [*found.centre, 1.0], [0, 0, 0, 1])
    middle = found.camera.rays(np.array([[(WIDTH - 1) / 2, (HEIGHT - 1) / 2]]))
    # The principal point is 3 px off, which the camera cannot know.
    assert middle.directions[0, 2] > np.cos(np.radians(2.5))
    relative = poses @ inverse_pose(poses[found.used[0]])
    ours = found.T_camera_grid @ inverse_pose(found.T_camera_grid[0])
    assert (
        np.abs(
            np.trace(relative[found.used][:, :3, :3], axis1=1, axis2=2)
            - np.trace(ours[:, :3, :3], axis1=1, axis2=2)
        ).max()
        < 0.01
    )


def test_generic_camera_predicts_held_out_boards(six_boards):
    _, found = six_boards
    score = evaluate_camera(found.camera, views_of(board_poses(50, 3)))
    assert score.share_with_ray > 0.8
    assert score.rms_px < 0.03


def test_generic_noise_gain_is_one():
    found = calibrated(views_of(board_poses(2, 5), noise=0.1))
    assert sorted(found.used) == list(range(5))
    # 0.1 px is 0.057 degrees per axis.
    assert np.sqrt(np.mean(ray_errors_deg(found.camera) ** 2)) < 0.12


def test_wrong_board_is_rejected_with_reason():
    views = views_of(board_poses(4, 5))
    # Half the board's size: no pose on the true rays.
    views[3] = views[3]._replace(points=views[3].points * [0.5, 1.0])
    found = calibrated(views)
    assert sorted(found.used) == [0, 1, 2, 4]
    assert "agrees with" in found.left_out[3]


def test_missing_corners_and_empty_view_are_accepted():
    views = views_of(board_poses(5, 6))
    views[2].pixels[[0, 40]] = np.nan
    views[4].pixels[:] = np.nan
    found = calibrated(views)
    assert sorted(found.used) == [0, 1, 2, 3, 5]
    assert "0 samples" in found.left_out[4]
    assert np.sqrt(np.mean(ray_errors_deg(found.camera) ** 2)) < 0.08


def test_generic_calibration_is_reproducible():
    views = views_of(board_poses(6, 4), noise=0.1)
    first, again = calibrated(views), calibrated(views)
    assert np.array_equal(
        first.camera.directions, again.camera.directions, equal_nan=True
    )


def test_too_few_boards_are_rejected():
    with raises_code("too-few-grids"):
        calibrated(views_of(board_poses(0, 2)))


def test_boards_that_do_not_overlap_are_rejected():
    R = rotation_from_vector(np.array([[0.3, 0, 0], [0, 0.3, 0], [-0.3, 0, 0]]))
    t = np.array([[-420.0, -60, 260], [0, -60, 300], [300.0, -60, 260]])
    with raises_code("no-overlap"):
        calibrated(views_of(pose(R, t)))


def test_board_samples_lie_on_boards():
    samples = sample_boards(views_of(board_poses(8, 3)), WIDTH, HEIGHT, 3000)
    assert 1500 < samples.seen.sum() < 6000
    assert np.all(samples.pixels % samples.step == 0)
    assert np.array_equal(np.isfinite(samples.points[..., 0]), samples.seen)
    half = samples.thinned(2)
    assert half.step == 2 * samples.step
    assert 0.2 < half.seen.sum() / samples.seen.sum() < 0.3


def test_distant_board_has_quarter_weight(six_boards):
    """Of those that were placed by rays; the first three count in full."""
    _, found = six_boards
    assert (found.weights[:3] == 1).all()
    times = found.grid_rms_deg / np.sqrt(np.mean(found.grid_rms_deg[:3] ** 2))
    assert times[3:].max() > 1.1
    due = np.minimum(1, times[3:] ** -2.0)
    np.testing.assert_allclose(found.weights[3:], due, rtol=1e-6)


def test_least_noisy_boards_are_tried_first(monkeypatch):
    noise = np.random.default_rng(0).permutation(14) + 1.0
    pairs = {(0, k): SimpleNamespace(noise=noise[k - 1]) for k in range(1, 15)}
    monkeypatch.setattr(
        standard, "margins_of_pairs", lambda _, picks: np.ones(len(picks))
    )
    triples = standard._ranked(pairs, 0, [])
    tried = {board for triple in triples for board in triple[1:]}
    assert tried == {
        k for k in range(1, 15) if noise[k - 1] <= standard.MAX_N_BOARDS_PER_BASE
    }
