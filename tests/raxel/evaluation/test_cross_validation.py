"""Errors on held-out boards: only poses are refitted."""

import numpy as np
import pytest

from raxel.calibration.pose.three_point import moved_pose
from raxel.cameras.tables.general import GeneralCamera
from raxel.errors import CalibrationError, InputError
from raxel.evaluation.cross_validation import (
    cross_validate,
    evaluate_camera,
    fit_board_pose,
)
from raxel.geometry import on_plane, pose, rotation_from_vector, transform
from tests.board_scenes import BOARD, FISHEYE, board_poses, views_of
from tests.raised import raises_code


def test_true_camera_has_zero_error_and_true_poses():
    poses = board_poses(0, 3)
    result = evaluate_camera(FISHEYE, views_of(poses))
    assert result.rms_px < 1e-9
    assert result.mean_deg < 1e-9
    assert result.share_with_ray == 1.0
    for image, T in zip(result.images, poses, strict=True):
        assert image.n_corners == len(BOARD)
        assert image.n_without_ray == 0
        assert np.abs(image.T_camera_grid - T).max() < 1e-8


def test_all_corners_have_equal_weight():
    exact, blurred = views_of(board_poses(10, 2))
    few = np.arange(0, len(BOARD), 10)
    rough = np.full_like(blurred.pixels, np.nan)
    noise = np.random.default_rng(10).normal(size=(len(few), 2))
    rough[few] = blurred.pixels[few] + noise
    result = evaluate_camera(FISHEYE, [exact, blurred._replace(pixels=rough)])
    one, other = result.images
    assert (one.n_corners, other.n_corners) == (130, 13)
    # 130 corners without an error, 13 with one of a degree or so.
    assert one.mean_deg < 1e-9
    assert other.mean_deg > 0.3
    assert result.mean_deg == pytest.approx(other.mean_deg * 13 / 143, rel=1e-6)
    assert result.rms_px == pytest.approx(other.rms_px * np.sqrt(13 / 143), rel=1e-6)
    assert result.median_px < 1e-9


def test_corners_without_a_ray_are_counted():
    table = GeneralCamera.from_camera(FISHEYE)
    mask = table.mask.copy()
    mask[:, :120] = False
    half = GeneralCamera(np.nan_to_num(table.directions), mask)
    views = views_of(board_poses(3, 3))
    result = evaluate_camera(half, views)
    for image, view in zip(result.images, views, strict=True):
        outside = np.count_nonzero(view.pixels[:, 0] < 120)
        assert 0 <= image.n_without_ray - outside <= 3  # posed just beyond the rim
        assert (
            np.count_nonzero(np.isnan(image.residuals_px[:, 0])) == image.n_without_ray
        )
    # What remains is the table's interpolation.
    assert result.rms_px < 1e-2
    lost = sum(image.n_without_ray for image in result.images)
    assert result.share_with_ray == pytest.approx(1 - lost / (3 * len(BOARD)))


def test_board_with_few_rays_has_a_reason():
    table = GeneralCamera.from_camera(FISHEYE)
    mask = np.zeros_like(table.mask)
    mask[:30, :30] = True
    corner = GeneralCamera(np.nan_to_num(table.directions), mask)
    image = evaluate_camera(corner, views_of(board_poses(4, 1))).images[0]
    assert np.isnan(image.rms_px)
    assert "corners have a ray" in image.reason
    assert image.n_without_ray == len(BOARD)


def test_missing_corners_are_not_counted():
    views = views_of(board_poses(5, 1))
    views[0].pixels[[3, 50]] = np.nan
    image = evaluate_camera(FISHEYE, views).images[0]
    assert image.n_corners == len(BOARD) - 2
    assert image.n_without_ray == 0


def test_pose_from_rays_minimises_sines():
    """A board that leans: what is near would weigh less by its distance from rays."""
    T = pose(rotation_from_vector([0.2, 1.1, 0.1]), [-60.0, -40.0, 150.0])
    rng = np.random.default_rng(16)
    directions = transform(T, on_plane(BOARD)) + 0.05 * rng.normal(size=(len(BOARD), 3))
    directions /= np.linalg.norm(directions, axis=1)[:, None]

    def squares(pose_):
        sight = transform(pose_, on_plane(BOARD))
        sines = np.cross(directions, sight) / np.linalg.norm(sight, axis=1)[:, None]
        return np.sum(sines**2)

    found = fit_board_pose(directions, BOARD)
    steps = np.concatenate([np.eye(6), -np.eye(6)]) * np.repeat([1e-5, 1e-3], 3)
    least = min(squares(moved_pose(found, step)) for step in steps)
    assert squares(found) < least


def test_every_view_is_held_out_once():
    views = views_of(board_poses(7, 5))
    trained = []

    def builder(rest):
        trained.append([view.name for view in rest])
        return FISHEYE

    result = cross_validate(builder, views, 2)
    assert [image.name for image in result.images] == [
        "0.png", "2.png", "4.png", "1.png", "3.png",
    ]  # fmt: skip
    assert [image.fold for image in result.images] == [0, 0, 0, 1, 1]
    assert trained == [["1.png", "3.png"], ["0.png", "2.png", "4.png"]]
    listed = cross_validate(builder, views, [[4], [0, 1]])
    assert [image.name for image in listed.images] == ["4.png", "0.png", "1.png"]


def test_parts_without_camera_are_excluded_with_the_reason():
    views = views_of(board_poses(8, 4))

    def builder(rest):
        if rest[0].name == "1.png":
            raise CalibrationError("boards parallel")
        return FISHEYE

    result = cross_validate(builder, views, 4)
    assert result.left_out == {0: "boards parallel"}
    assert len(result.images) == 3

    def never(rest):
        raise CalibrationError("boards parallel")

    with raises_code("no-camera"):
        cross_validate(never, views, 2)


def test_invalid_parts_and_empty_lists_are_rejected():
    views = views_of(board_poses(9, 2))
    with pytest.raises(InputError, match="found 5"):
        cross_validate(lambda rest: FISHEYE, views, 5)
    with pytest.raises(InputError, match="folds"):
        cross_validate(lambda rest: FISHEYE, views, [[0], [2]])
    with pytest.raises(InputError, match="views"):
        evaluate_camera(FISHEYE, [])


def test_error_of_the_true_camera_is_the_noise():
    result = evaluate_camera(FISHEYE, views_of(board_poses(1, 4), noise=0.2))
    # Six of 260 numbers per board go into its pose.
    assert result.rms_px == pytest.approx(0.2 * np.sqrt(2), rel=0.1)
    # One pixel is 1 / 100 rad in the middle, less at the rim along the circle.
    assert np.radians(result.mean_deg) == pytest.approx(0.25 / 100, rel=0.15)
    medians = [image.median_px for image in result.images]
    assert min(medians) <= result.median_px <= max(medians)
