"""OpenCV's fisheye calibration as a peer: exact on its own model, clear in refusal."""

import numpy as np
import pytest

from raxel.calibration import BoardView, calibrate_opencv_fisheye
from raxel.calibration.parametric import opencv_fits as opencv_fisheye
from raxel.cameras.lenses.fisheye import KannalaBrandtCamera
from raxel.errors import InputError
from raxel.geometry import on_plane, pose, rotation_from_vector, transform

COLUMNS, ROWS = 9, 6
BOARD = 30.0 * np.stack(np.meshgrid(np.arange(COLUMNS), np.arange(ROWS)), -1).reshape(
    -1, 2
)
TRUE = KannalaBrandtCamera(
    [1.0, -0.03, 0.004, -0.002, 0.0003], (330.0, 328.0), (645.0, 476.0), 1280, 960
)


def views_of(count, noise=0.0):
    """Boards up to 65 degrees from the axis, each turned to the camera and tilted."""
    rng = np.random.default_rng(3)
    views = []
    while len(views) < count:
        polar, azimuth = rng.uniform(0, 0.9), rng.uniform(0, 2 * np.pi)
        faced = rotation_from_vector(
            polar * np.array([-np.sin(azimuth), np.cos(azimuth), 0.0])
        )
        R = faced @ rotation_from_vector(rng.uniform(-0.5, 0.5, 3))
        t = 260 * faced[:, 2] - R @ [120.0, 75.0, 0.0]
        pixels = TRUE.project(transform(pose(R, t), on_plane(BOARD))).pixels
        if np.isfinite(pixels).all():
            pixels = pixels + noise * rng.normal(size=pixels.shape)
            views.append(BoardView(pixels, BOARD, COLUMNS, ROWS, f"{len(views)}.png"))
    return views


def test_opencv_fisheye_recovers_own_model():
    found = calibrate_opencv_fisheye(views_of(12), 1280, 960)
    assert found.rms_px < 1e-5
    assert np.abs(found.camera.principal_point - TRUE.principal_point).max() < 1e-3
    assert np.abs(found.camera.pixels_per_unit - TRUE.pixels_per_unit).max() < 1e-3
    assert np.abs(found.camera.k - TRUE.k).max() < 1e-5
    assert found.T_camera_grid.shape == (12, 4, 4)


def test_opencv_residual_equals_noise():
    views = views_of(12, noise=0.2)
    views[0].pixels[[3, 17]] = np.nan
    found = calibrate_opencv_fisheye(views, 1280, 960)
    # 0.2 px in u and in v; 80 of 1292 numbers are used up by the parameters.
    assert found.rms_px == pytest.approx(0.2 * np.sqrt(2), rel=0.1)


def test_single_view_is_rejected():
    with pytest.raises(InputError, match="1 view"):
        calibrate_opencv_fisheye(views_of(1), 1280, 960)


def test_best_start_is_used_in_any_order(monkeypatch):
    """From a long focal length this lens is missed by a hundred pixels."""
    monkeypatch.setattr(
        opencv_fisheye, "START_SPANS_RAD", opencv_fisheye.START_SPANS_RAD[::-1]
    )
    found = calibrate_opencv_fisheye(views_of(10, noise=0.1), 1280, 960)
    assert found.rms_px == pytest.approx(0.1 * np.sqrt(2), rel=0.1)
