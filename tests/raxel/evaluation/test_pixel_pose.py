"""Each error at its own best pose, in px and in angle."""

import numpy as np
import pytest

from raxel.calibration.parametric.opencv_fits import calibrate_zhang
from raxel.cameras import FisheyeCamera, GeneralCamera
from raxel.evaluation.cross_validation import evaluate_camera
from raxel.evaluation.distortion import pixels_by_point, refine_pose_in_pixels
from raxel.geometry import on_plane, pose, rotation_from_vector, transform
from tests.board_scenes import BOARD, FISHEYE, HEIGHT, WIDTH, board_poses, views_of
from tests.mirror_cameras import CONVEX

FLAT = on_plane(BOARD)


def wide_views(seed=0):
    """Boards all over a fisheye's image, also far from its axis."""
    return views_of(board_poses(seed, 6, spread=(90.0, 60.0)))


def rims_apart(camera):
    """Its table with a hole: rays in the left two thirds only."""
    whole = GeneralCamera.from_camera(camera)
    mask = whole.mask.copy()
    mask[:, 2 * WIDTH // 3 :] = False
    return GeneralCamera(np.nan_to_num(whole.directions), mask)


def rms(residuals):
    return np.sqrt(np.nanmean(np.sum(residuals**2, axis=1)))


@pytest.mark.parametrize(
    "camera",
    [
        FISHEYE,
        FisheyeCamera("stereographic", 100.0, [122.0, 88.0], WIDTH, HEIGHT),
        rims_apart(FisheyeCamera("equisolid", 103.0, [120.0, 90.0], WIDTH, HEIGHT)),
        calibrate_zhang(wide_views(), WIDTH, HEIGHT).camera,
    ],
    ids=["true", "other law", "table with a hole", "zhang"],
)
def test_px_errors_are_smallest_at_their_own_pose(camera):
    for view, score in zip(
        wide_views(1), evaluate_camera(camera, wide_views(1)).images, strict=True
    ):
        seen = camera.project(transform(score.T_camera_grid_by_angle, FLAT)).pixels
        by_angle = np.where(
            camera.rays(view.pixels).valid[:, None], view.pixels - seen, np.nan
        )
        # The same corners: none is lost for a smaller error.
        assert np.array_equal(np.isnan(by_angle), np.isnan(score.residuals_px))
        assert score.rms_px <= rms(by_angle)
        assert score.rms_px == pytest.approx(rms(score.residuals_px))


def test_pose_in_px_is_optimal_for_non_central_cameras():
    rng = np.random.default_rng(0)
    camera = CONVEX["sphere"]
    points = np.stack(np.meshgrid(np.arange(8), np.arange(6)), -1).reshape(-1, 2) * 30.0
    flat = on_plane(points)
    middle = camera.rays(np.array([[230.0, 190.0]]))
    across = np.column_stack([middle.directions[0], [0, 1, 0], [0, 0, 1]])
    R = np.linalg.qr(across)[0][:, [1, 2, 0]]
    T = pose(R, middle.origins[0] + 400 * middle.directions[0] - R @ [105, 75, 0])
    seen = camera.project(transform(T, flat))
    assert seen.valid.all()
    assert not camera.central
    pixels = seen.pixels + 0.3 * rng.normal(size=seen.pixels.shape)
    start = T @ pose(rotation_from_vector([0.02, -0.03, 0.01]), [4.0, -3.0, 6.0])
    best, residuals = refine_pose_in_pixels(camera, pixels, points, start)
    for step in 1e-4 * np.vstack([np.eye(6), -np.eye(6)]):
        other = best @ pose(rotation_from_vector(step[:3]), 100 * step[3:])
        nearby = pixels - camera.project(transform(other, flat)).pixels
        assert np.sum(nearby**2) > np.sum(residuals**2) * (1 - 1e-6)
    exact, residuals = refine_pose_in_pixels(camera, seen.pixels, points, start)
    assert rms(residuals) < 1e-6
    assert np.abs(exact - T).max() < 1e-4


def test_steps_that_lose_a_corner_are_rejected():
    """The pose that would fit best lies a degree further out than the lens sees."""
    lens = "equidistance", 100.0, [120.0, 90.0], WIDTH, HEIGHT
    points = 20.0 * np.stack(np.meshgrid(np.arange(6), np.arange(5)), -1).reshape(-1, 2)
    flat = on_plane(points)
    T = pose(rotation_from_vector([0.1, 0.2, 0]), [50, -40, 150])
    outward = pose(rotation_from_vector([0, np.radians(1), 0]), np.zeros(3)) @ T
    x, y, z = transform(T, flat).T
    limit = np.arctan2(np.hypot(x, y), z).max() + np.radians(0.1)
    camera = FisheyeCamera(*lens, limit)
    pixels = FisheyeCamera(*lens).project(transform(outward, flat)).pixels
    at_start = pixels - camera.project(transform(T, flat)).pixels
    found, residuals = refine_pose_in_pixels(camera, pixels, points, T)
    assert np.isfinite(at_start).all()
    assert camera.project(transform(found, flat)).valid.all()
    assert np.isfinite(residuals).all()
    assert rms(residuals) < rms(at_start)


def test_pixel_derivatives_hold_at_the_image_edge():
    """There rays are known to one side alone; differences of `project` tell."""
    table = GeneralCamera.from_camera(FISHEYE)
    mask = np.zeros_like(table.mask)
    mask[40:141, 60:181] = True
    camera = GeneralCamera(np.nan_to_num(table.directions), mask)
    pixels = np.array([[60, 90], [180, 90], [120, 40], [120, 140], [120, 90]], float)
    points = 500 * FISHEYE.rays(pixels).directions
    found = pixels_by_point(camera, pixels, points)
    for axis in range(3):
        step = 1e-3 * np.eye(3)[axis]
        ahead, behind = (FISHEYE.project(points + s * step).pixels for s in (1, -1))
        due = (ahead - behind) / 2e-3
        np.testing.assert_allclose(found[..., axis], due, atol=0.02 * np.abs(due).max())
