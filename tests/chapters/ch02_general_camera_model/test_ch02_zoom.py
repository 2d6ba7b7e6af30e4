"""Scores of section 2.5.2: nothing left by the true camera, and known patterns seen."""

import numpy as np
import pytest
from scipy.stats import binomtest

from chapters.ch02_general_camera_model.s5_2_real_data import experiment
from chapters.ch02_general_camera_model.s5_2_real_data.claims import in_runs
from chapters.shared.general import facade, three_planes
from chapters.shared.methods import SCORINGS
from raxel.calibration import BoardView
from raxel.cameras import FisheyeCamera, PerspectiveCamera, pixel_grid
from raxel.geometry import inverse_pose, on_plane, pose, rotation_from_vector, transform
from raxel.sets import Chessboard

BOARD = Chessboard(12, 9, 15.0)
LENS = FisheyeCamera("equidistance", 250.0, [320.0, 240.0], 640, 480)


def seen(camera, vector, shift):
    """The board from one pose: BoardView and T_camera_grid."""
    R = rotation_from_vector(np.array(vector, float))
    flat = on_plane(BOARD.points())
    T = pose(R, np.array(shift) - R @ flat.mean(axis=0))
    pixels = camera.project(transform(T, flat)).pixels
    return BoardView(pixels, BOARD.points(), 12, 9), T


def test_true_camera_leaves_no_residual():
    view, _ = seen(LENS, [0.3, -0.2, 0.5], [10.0, -5.0, 180.0])
    found = experiment.residuals_of(LENS, [view])[0]
    pixels, corrected, source, left_out = found
    assert left_out == 0
    assert len(pixels) == 108
    assert np.abs(corrected).max() < 1e-8
    assert np.abs(source).max() < 1e-8


def test_residual_scales_agree_at_the_centre():
    """There a px of the corrected view is as large as one of the image."""
    view, _ = seen(LENS, [0.0, 0.0, 0.0], [0.0, 0.0, 5000.0])
    noise = np.random.default_rng(0).normal(0, 0.2, view.pixels.shape)
    view = view._replace(pixels=view.pixels + noise)
    _, corrected, source, _ = experiment.residuals_of(LENS, [view])[0]
    assert np.allclose(corrected, source, atol=2e-3)


def test_wrong_projection_law_leaves_a_radial_bias_that_changes_sign():
    pinhole = PerspectiveCamera(
        [[250.0, 0, 319.5], [0, 250.0, 239.5], [0, 0, 1]], [], 640, 480
    )
    views = [seen(LENS, [0.0, 0.0, k], [0.0, 0.0, 120.0])[0] for k in (0.0, 0.4, 0.9)]
    boards = experiment.residuals_of(pinhole, views)
    found = experiment.radial_bias(boards, np.array([320.0, 240.0]))
    inner, outer = found["corrected"]["q2"], found["corrected"]["q5"]
    assert inner["mean_px"] * outer["mean_px"] < 0
    assert inner["p"] < 0.01
    assert outer["p"] < 0.01


def test_moran_index_separates_pattern_from_noise():
    rng = np.random.default_rng(1)
    places = BOARD.points()
    smooth = np.column_stack([np.sin(places[:, 0] / 40), np.cos(places[:, 1] / 40)])
    index, p = experiment.moran(places, smooth, rng)
    assert index > 0.5
    assert p == pytest.approx(1 / 1000)
    chance = [experiment.moran(places, rng.normal(size=(108, 2)), rng)[1]
              for _ in range(40)]  # fmt: skip
    # p is uniform without a pattern: 40 draws rarely have more than 4 below 0.02.
    assert np.count_nonzero(np.array(chance) < 0.02) <= 4


def test_stage_steps_are_recovered_in_both_frames():
    _, first = seen(LENS, [0.2, 0.3, 0.1], [-20.0, 0.0, 200.0])
    along = first[:3, :3] @ [1.0, 0, 0]
    poses = [first]
    for _ in range(4):
        poses.append(poses[-1].copy())
        poses[-1][:3, 3] += 25 * along
    flat = on_plane(BOARD.points())
    views = [
        BoardView(LENS.project(transform(T, flat)).pixels, BOARD.points(), 12, 9)
        for T in poses
    ]
    found = experiment.stage_poses(LENS, views)
    steps = experiment.steps_of(found)
    assert np.allclose(steps["grid"], [25.0, 0, 0], atol=1e-6)
    assert np.allclose(steps["camera"], 25 * along, atol=1e-6)
    scatter = experiment.scatter_of(steps["grid"])
    assert scatter["step_mm"] == pytest.approx(25)
    assert scatter["deviation_mm"] < 1e-6


def test_centre_trial_uses_the_frame_of_the_base_grid():
    out = experiment.centre_trial({}, np.random.default_rng(3))
    for linear in ("as printed", "well conditioned"):
        assert out[linear]["centre_error_mm"] > 0
        for scoring in SCORINGS:
            assert 0 < out[linear][scoring]["corrected"]["ratio"] < 1.5


def test_true_centre_leaves_no_residual_without_noise():
    scene = experiment.SCENE | {"noise": 0.0}
    data, _ = three_planes.measure(scene, np.random.default_rng(0))
    T_base_grid = inverse_pose(data.grids[0]) @ data.grids
    left = experiment.rms_of(data, inverse_pose(data.grids[0])[:3, 3], T_base_grid)
    assert max(max(scales.values()) for scales in left.values()) < 1e-6


def test_homography_removes_a_plane_and_leaves_distortion():
    for seed in range(5):
        out = experiment.homography_trial({}, np.random.default_rng(seed))
        assert out["without_px"] < 1e-8
        assert out["with_px"] > 0.05


def test_share_of_runs_has_its_exact_interval():
    reading = in_runs(np.arange(10) < 9, "so")
    exact = binomtest(9, 10).proportion_ci(0.95, method="exact")
    assert (reading.verdict, reading.regenerated) == ("reproduced", 0.9)
    assert reading.interval == pytest.approx((exact.low, exact.high))
    assert reading.reason == "9 of 10 simulated runs; so"
    assert in_runs(np.arange(10) < 8, "").verdict == "differs"


def test_upright_view_keeps_verticals_in_columns():
    K = np.array([[60.0, 0, 79.5], [0, 60.0, 59.5], [0, 0, 1]])
    camera = PerspectiveCamera(K, [], 160, 120)
    world = camera.rays(pixel_grid(160, 120)).directions
    world = world @ facade.T_world_camera()[:3, :3].T
    # All points of a vertical line have one x / z, in the frame of the front.
    sideways = (world[:, 0] / world[:, 2]).reshape(120, 160).astype(np.float32)
    seen = facade.corrected_images(sideways, {"generic_as_printed": camera})
    focal = 79.5 / np.tan(np.radians(facade.HALF_VIEW_DEG))
    columns = np.arange(40, 120)
    wanted = np.broadcast_to((columns - 79.5) / focal, (40, 80))
    np.testing.assert_allclose(seen["view.upright"][30:70, 40:120], wanted, atol=5e-3)
