"""The distortion residual, the corrected view and the angular residual."""

import numpy as np
import pytest

from raxel.cameras import FisheyeCamera, GeneralCamera, PerspectiveCamera
from raxel.errors import InputError
from raxel.evaluation.distortion import (
    angular_residual,
    corrected_view,
    distortion_residual,
    synthetic_plane,
)
from raxel.geometry import (
    apply_homography,
    on_plane,
    pose,
    rotate,
    rotation_from_vector,
    transform,
)

GRID = 10.0 * np.stack(np.meshgrid(np.arange(9), np.arange(7)), -1).reshape(-1, 2)
H = np.array([[3.0, 0.2, 100.0], [-0.3, 2.8, 80.0], [1e-3, -5e-4, 1.0]])
FISHEYE = FisheyeCamera("equidistance", 160.0, [201.0, 148.0], 400, 300)
K = np.array([[300.0, 0.0, 190.0], [0.0, 300.0, 155.0], [0.0, 0.0, 1.0]])


def grid_pose():
    T = pose(rotation_from_vector([0.3, -0.2, 0.1]), [0.0, 0.0, 90.0])
    T[:3, 3] -= T[:3, :3] @ [40.0, 30.0, 0.0]
    return T


def test_homography_has_no_distortion_residual():
    residual = distortion_residual(apply_homography(H, GRID), GRID)
    assert np.abs(residual).max() < 1e-9


def test_distortion_residual_is_independent_of_the_metric_frame():
    rng = np.random.default_rng(1)
    corrected = apply_homography(H, GRID) + 0.3 * rng.normal(size=GRID.shape)
    turned = GRID @ np.array([[0.6, 0.8], [-0.8, 0.6]]) * 7.0 + [500.0, -30.0]
    difference = distortion_residual(corrected, GRID) - distortion_residual(
        corrected, turned
    )
    assert np.abs(difference).max() < 1e-6


@pytest.mark.parametrize("camera", [FISHEYE, PerspectiveCamera(K, [-0.2], 400, 300)])
def test_corrected_view_has_straight_lines_and_image_scale(camera):
    plane = synthetic_plane(camera)
    middle = np.array([199.5, 149.5])
    steps = 0.5 * np.array([[1, 0], [-1, 0], [0, 1], [0, -1], [0, 0]])
    view, valid = corrected_view(camera.rays(middle + steps).directions, plane)
    assert valid.all()
    assert np.abs(view[4] - middle).max() < 1e-9
    magnification = np.abs(
        np.linalg.det(np.stack([view[0] - view[1], view[2] - view[3]]))
    )
    assert magnification == pytest.approx(1.0, abs=1e-9)
    assert view[0, 0] > view[1, 0]
    assert view[2, 1] > view[3, 1]
    pixels = camera.project(transform(grid_pose(), on_plane(GRID))).pixels
    bent = np.abs(distortion_residual(pixels, GRID)).max()
    view, _ = corrected_view(camera.rays(pixels).directions, plane)
    assert np.abs(distortion_residual(view, GRID)).max() < 1e-6
    assert bent > 0.5


def test_corrected_view_flags_rays_that_miss_the_plane():
    plane = synthetic_plane(FISHEYE)
    back = -plane.T_camera_plane[:3, 2]
    view, valid = corrected_view(np.stack([back, -back]), plane)
    assert valid.tolist() == [False, True]
    assert np.isnan(view[0]).all()


def test_principal_pixel_without_rays_is_rejected():
    camera = GeneralCamera.from_camera(FISHEYE)
    mask = camera.mask.copy()
    mask[140:160, 190:210] = False
    holed = GeneralCamera(np.nan_to_num(camera.directions), mask)
    with pytest.raises(InputError, match="pixel"):
        synthetic_plane(holed)
    assert synthetic_plane(holed, (100, 100)).px_per_unit > 0


def test_angular_residual_with_and_without_alignment():
    rng = np.random.default_rng(2)
    reference = rng.normal(size=(200, 3))
    reference /= np.linalg.norm(reference, axis=1)[:, None]
    R = rotation_from_vector([0.0, 0.02, 0.0])
    turned = rotate(R, reference)
    plain = angular_residual(turned, reference, aligned=False)
    expected = 0.02 * np.sqrt(1 - reference[:, 1] ** 2)
    assert np.allclose(plain, expected, rtol=1e-4)
    assert angular_residual(turned, reference).max() < 1e-12
    spoilt = turned + 1e-3 * rng.normal(size=turned.shape)
    spoilt /= np.linalg.norm(spoilt, axis=1)[:, None]
    assert np.mean(angular_residual(spoilt, reference)) < 2e-3
