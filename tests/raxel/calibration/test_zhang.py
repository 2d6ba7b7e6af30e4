"""The standard perspective method and rejected input."""

import numpy as np
import pytest

from raxel.calibration import BoardView, calibrate_zhang
from raxel.cameras.lenses.perspective import PerspectiveCamera
from raxel.errors import InputError
from raxel.geometry import (
    angle_between_rotations,
    on_plane,
    pose,
    rotation_from_vector,
    transform,
)

COLUMNS, ROWS = 9, 6
BOARD = np.stack(np.meshgrid(np.arange(COLUMNS), np.arange(ROWS)), -1).reshape(-1, 2)
BOARD = 30.0 * BOARD
K = np.array([[510.0, 0.0, 310.0], [0.0, 505.0, 245.0], [0.0, 0.0, 1.0]])
TRUE = PerspectiveCamera(K, [-0.25, 0.06], 640, 480)


def board_poses(seed, count, tilt=0.5):
    rng = np.random.default_rng(seed)
    R = rotation_from_vector(rng.uniform(-tilt, tilt, (count, 3)))
    t = rng.uniform([-60, -40, 450], [60, 40, 650], (count, 3))
    return pose(R, t - R @ [120.0, 75.0, 0.0])


def views_of(poses, noise=0.0, seed=0):
    rng = np.random.default_rng(seed)
    flat = on_plane(BOARD)
    out = []
    for k, T in enumerate(poses):
        pixels = TRUE.project(transform(T, flat)).pixels
        pixels = pixels + noise * rng.normal(size=pixels.shape)
        out.append(BoardView(pixels, BOARD, COLUMNS, ROWS, f"{k}.png"))
    return out


def test_zhang_is_exact_to_single_precision():
    poses = board_poses(0, 6)
    found = calibrate_zhang(views_of(poses), 640, 480)
    assert np.abs(found.camera.K - K).max() < 5e-3
    assert np.abs(found.camera.radial - TRUE.radial).max() < 1e-4
    assert found.rms_px < 1e-4
    turns = angle_between_rotations(found.T_camera_grid[:, :3, :3], poses[:, :3, :3])
    assert turns.max() < 1e-5
    assert np.abs(found.T_camera_grid[:, :3, 3] - poses[:, :3, 3]).max() < 1e-2


def test_zhang_residual_equals_noise():
    found = calibrate_zhang(views_of(board_poses(1, 8), noise=0.2), 640, 480)
    # 0.2 px in u and in v; 54 of 864 numbers are used up by the parameters.
    assert found.rms_px == pytest.approx(0.2 * np.sqrt(2), rel=0.1)


def without_corners(views, missing):
    """The views with the corners of these numbers NaN in every one."""
    holes = [view._replace(pixels=view.pixels.copy()) for view in views]
    for view in holes:
        view.pixels[missing] = np.nan
    return holes


def test_zhang_ignores_missing_corners():
    views = without_corners(views_of(board_poses(0, 6)), [0, 4, 17, 53])
    found = calibrate_zhang(views, 640, 480)
    assert np.abs(found.camera.K - K).max() < 5e-3
    assert found.rms_px < 1e-4
    # Six corners of a board suffice, where others hold the camera.
    views[2].pixels[[*range(0, 24), *range(28, 51)]] = np.nan
    assert np.isfinite(views[2].pixels[:, 0]).sum() == 6
    found = calibrate_zhang(views, 640, 480)
    assert np.abs(found.camera.K - K).max() < 1e-2


def test_zhang_rejects_degenerate_views():
    views = views_of(board_poses(2, 3))
    (few,) = without_corners(views[1:2], slice(5, None))
    (row,) = without_corners(views[1:2], slice(COLUMNS, None))
    line = views[0]._replace(pixels=views[0].pixels[:, :1] * [1.0, 2.0])
    for rejected, wrong in (
        (pytest.raises(InputError, match="1 view"), views[:1]),
        (pytest.raises(InputError, match=r"1\.png: corners: found 5"), [views[0], few]),
        (pytest.raises(InputError, match=r"1\.png: corners"), [views[0], row]),
        (pytest.raises(InputError, match=r"0\.png: corners"), [line, views[1]]),
    ):
        with rejected:
            calibrate_zhang(wrong, 640, 480)


def test_zhang_residual_is_of_returned_camera():
    """Of a lens that two radial terms do not describe."""
    wide = K * [[0.6], [0.6], [1.0]] + [[0, 0, 130.0], [0, 0, 100.0], [0, 0, 0]]
    bent = PerspectiveCamera(wide, [-0.3, 0.15, -0.05], 640, 480)
    poses, flat = board_poses(7, 6), on_plane(BOARD)
    poses[:, 2, 3] -= 200
    views = [
        BoardView(bent.project(transform(T, flat)).pixels, BOARD, COLUMNS, ROWS, "a")
        for T in poses
    ]
    found = calibrate_zhang(views, 640, 480)
    off = [
        found.camera.project(transform(T, flat)).pixels - view.pixels
        for T, view in zip(found.T_camera_grid, views, strict=True)
    ]
    rms = np.sqrt(np.mean(np.sum(np.square(off), axis=2)))
    assert found.rms_px == pytest.approx(rms, rel=1e-3)
    assert rms > 0.01
