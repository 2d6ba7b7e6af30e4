"""Every ray has a covariance, in the file, that is that of its actual error."""

import numpy as np
import pytest

from raxel.cameras import FisheyeCamera, PerspectiveCamera, load_camera
from raxel.evaluation.misfit import with_radial_terms
from raxel.evaluation.ray_errors import (
    errors_of_formula,
    errors_of_table,
    errors_with_deviation,
    next_place,
    node_pixels,
)
from raxel.evaluation.split_half import Division, SplitHalf

K = [[300.0, 0, 160], [0, 300, 120], [0, 0, 1]]


def nodes(camera, errors):
    """The camera with these errors uu, uv, vv at all nodes."""
    shape = node_pixels(camera).shape[:2]
    camera.error_nodes = np.broadcast_to(errors, (*shape, 3)).copy()
    return camera


def test_direction_covariance_follows_from_that_in_the_image():
    camera = nodes(PerspectiveCamera(K, [], 320, 240), [0.09, 0.02, 0.04])
    rays = camera.rays([[160.0, 120.0], [400.0, 0.0]], covariance=True)
    expected = np.zeros((3, 3))
    expected[:2, :2] = np.array([[0.09, 0.02], [0.02, 0.04]]) / 300**2
    np.testing.assert_allclose(rays.covariance[0], expected, rtol=1e-4, atol=1e-12)
    assert np.isnan(rays.covariance[1]).all()
    camera.error_nodes = None
    assert np.isnan(camera.rays([[1.0, 1.0]], covariance=True).covariance).all()


def test_errors_are_stored_and_interpolated(tmp_path):
    camera = PerspectiveCamera(K, [], 320, 240)
    camera.error_nodes = np.dstack([*node_pixels(camera).T.swapaxes(1, 2)] * 2)[..., :3]
    camera.save(tmp_path / "camera.npz")
    found = load_camera(tmp_path / "camera.npz").pixel_covariance([[37.0, 101.0]])
    np.testing.assert_allclose(found, [[[37, 101], [101, 37]]])


def test_errors_of_a_formula_are_those_of_its_parameters():
    """Changes of the focal length, seen without what rotations do."""
    camera = FisheyeCamera("equidistance", 160.0, [160.0, 120.0], 321, 241)

    def slopes(points):
        return (camera.project(points).pixels - [160.0, 120.0])[..., None] / 160.0

    found = errors_of_formula(camera, 500.0, slopes, np.array([[0.25]]))
    camera.error_nodes = found
    errors = camera.pixel_covariance([[160.0, 120.0], [310.0, 120.0]])
    assert np.sqrt(errors[0, 0, 0]) < 1e-6
    assert np.sqrt(errors[1, 0, 0]) == pytest.approx(0.5 * 150 / 160, rel=1e-2)
    # Boards in the right quarter determine the rotation.
    camera.board_cells = np.arange(4)[None] == 3
    camera.error_nodes = errors_of_formula(camera, 500.0, slopes, np.array([[0.25]]))
    assert np.sqrt(camera.pixel_covariance([[280.0, 120.0]])[0, 0, 0]) < 0.1


def test_lens_may_depart_from_the_fit_where_no_board_was():
    camera = nodes(PerspectiveCamera(K, [], 320, 240), [0.01, 0, 0.01])
    camera.board_cells = np.arange(4)[None] < 2
    terms = with_radial_terms(node_pixels(camera).reshape(-1, 2), camera)
    found = errors_with_deviation(camera, 500.0, np.eye(terms.shape[2]))
    squares = found[..., 0] + found[..., 2]
    left, right = squares[:, :16], squares[:, 17:]
    np.testing.assert_allclose(left, 0.02)
    assert right.min() >= 0.02
    assert right[:, -1].min() > 1
    small = errors_with_deviation(camera, 500.0, 1e-9 * np.eye(terms.shape[2]))
    np.testing.assert_allclose(small, camera.error_nodes, atol=1e-7)


def test_errors_of_a_table_are_half_the_difference_of_halves():
    camera = PerspectiveCamera(K, [], 320, 240)
    parts = [Division("", (), size, 0.0, 0.0, 1.0, np.zeros((0, 2))) for size in (3, 1)]
    halves = SplitHalf(parts, np.zeros((0, 2)), 1.0, True, 1.0, True)
    camera.error_nodes = errors_of_table(camera, halves)
    squares = np.trace(camera.pixel_covariance([[3.0, 4.0]])[0])
    assert squares == pytest.approx((9 + 1) / 2 / 4)


def test_next_image_is_where_rays_are_least_certain():
    camera = nodes(PerspectiveCamera(K, [], 320, 240), [0.5, 0.0, 0.5])
    camera.error_nodes[-3:, :3] = [2.0, 0.0, 2.0]
    assert next_place(camera) == "lower left"
    camera.error_nodes[0, -1] = np.nan
    assert next_place(camera) == "upper right"
    camera.error_nodes = None
    assert next_place(camera) is None
