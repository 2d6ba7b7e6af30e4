"""The perspective view: what is straight in space is straight, and where it belongs."""

import numpy as np
import pytest

from raxel.cameras import FisheyeCamera, GeneralCamera, pixel_grid
from raxel.geometry.poses import rotation_from_vector
from raxel.multiview.views import (
    CylindricalView,
    EquirectangularView,
    PerspectiveView,
    panoramic_view,
    perspective_view,
    range_shift,
    source_pixels,
)
from tests.lab_cameras import EVERY
from tests.raised import raises_code

WIDTH, HEIGHT = 120, 90
# Its axis meets the image far from the middle, so that the view is turned and tilted.
ASIDE = FisheyeCamera("equidistance", 70.0, [90.0, 20.0], WIDTH, HEIGHT, np.pi / 2)
TILT = rotation_from_vector(np.array([0.2, -0.5, 0.3]))


@pytest.fixture(scope="module")
def chosen():
    """The view that is chosen for a camera whose axis is far from mid-image."""
    return perspective_view(ASIDE)


@pytest.fixture(scope="module")
def given():
    """A view that looks aside, turned about its axis, too large for one block."""
    K = np.array([[180.0, 0, 150.0], [0, 180.0, 120.0], [0, 0, 1]])
    return PerspectiveView(K, TILT, np.zeros(3), 3 * WIDTH, 3 * HEIGHT)


@pytest.mark.parametrize("name", ["chosen", "given"])
def test_view_pixel_has_own_direction(request, name):
    view = request.getfixturevalue(name)
    x, y, z = view.R_camera_view.T
    rows, columns = np.mgrid[: view.height, : view.width].reshape(2, -1, 1)
    across = (columns - view.K[0, 2]) / view.K[0, 0] * x
    ahead = z + across + (rows - view.K[1, 2]) / view.K[1, 1] * y
    truth, valid = ASIDE.project(1e6 * ahead)
    sources = source_pixels(ASIDE, view).reshape(-1, 2)
    assert valid.mean() > 0.5
    # float32 holds an image's pixels to a hundred-thousandth.
    np.testing.assert_allclose(sources[valid], truth[valid], atol=1e-4)


def test_view_centre_is_image_centre(chosen):
    middle = (np.array([WIDTH, HEIGHT]) - 1) / 2
    pixel = ASIDE.project(chosen.R_camera_view[:, 2][None]).pixels[0]
    # The pixel of a grid of 101 x 101 that is nearest to the middle.
    assert np.abs(pixel - middle).max() <= 0.5 * WIDTH / 100
    np.testing.assert_allclose(chosen.K[:2, 2], pixel, atol=1e-9)
    right = source_at(chosen, pixel + [4, 0]) - source_at(chosen, pixel)
    assert right[0] > 0
    assert abs(right[1]) < 0.1 * right[0]


def source_at(view, pixel):
    return ASIDE.project(1e6 * view.directions(pixel[None]) + view.centre).pixels[0]


def test_shifted_table_view_is_at_its_centre(chosen):
    table = GeneralCamera.from_camera(ASIDE)
    moved = GeneralCamera(
        np.nan_to_num(table.directions), table.mask, origins=[3.0, -2.0, 5.0]
    )
    view = perspective_view(moved)
    np.testing.assert_allclose(view.centre, [3.0, -2.0, 5.0], atol=1e-9)
    np.testing.assert_allclose(view.R_camera_view, chosen.R_camera_view, atol=2e-3)


def view_of(camera, kind, fov, size):
    if kind is PerspectiveView:
        return perspective_view(camera, fov, size)
    return panoramic_view(kind, camera, fov=fov, size=size)


@pytest.mark.parametrize(
    ("name", "kind"),
    [
        *(
            (name, kind)
            for name in ("perspective", "general", "moving pupil", "ray spline")
            for kind in (PerspectiveView, CylindricalView, EquirectangularView)
        ),
        ("spline mirror", PerspectiveView),
    ],
)
def test_view_is_exact_at_its_range(name, kind):
    """Of every kind of camera that `calibrate` writes."""
    camera, _ = EVERY[name]
    view = view_of(camera, kind, np.radians(80), (24, 16))
    sources = source_pixels(camera, view, 400.0).reshape(-1, 2).astype(float)
    seen = camera.in_image(sources)
    assert seen.mean() > 0.6
    points = view.centre + 400.0 * view.directions(pixel_grid(24, 16))[seen]
    rays = camera.rays(sources[seen])
    distances = np.linalg.norm(np.cross(points - rays.origins, rays.directions), axis=1)
    assert distances.max() < 1e-3  # float32 pixels
    assert range_shift(camera, view, 400.0, 400.0) == 0
    shift = range_shift(camera, view, 400.0, 200.0)
    assert (shift > 0.05) == (name in ("moving pupil", "spline mirror"))
    far = [range_shift(camera, view, 1e6, distance) for distance in (2e4, 4e4)]
    assert far[0] == pytest.approx(2 * far[1], rel=0.05)  # as 1/distance


def test_panorama_holds_all_rays_of_the_camera():
    """Fisheyes of 160 degrees along the horizon, and of 240 along the vertical."""
    lens, narrow = (
        FisheyeCamera("equidistance", 40.0, [90, 90], 181, 181, np.radians(angle))
        for angle in (120, 80)
    )
    level = panoramic_view(EquirectangularView, narrow)
    assert (level.width, level.height) == pytest.approx(
        [40 * np.radians(160)] * 2, abs=2
    )
    around = panoramic_view(EquirectangularView, lens, down=(0, 0, 3.0))
    assert around.width == pytest.approx(40 * 2 * np.pi, abs=1)
    ends = around.directions(np.array([[0.0, 0], [0, around.height - 1]]))[:, 2]
    np.testing.assert_allclose(np.degrees(np.arcsin(ends)), [-30, 90], atol=2)
    # The upper edge of the image is ahead.
    middle = around.directions(np.array([[(around.width - 1) / 2, around.horizon]]))
    np.testing.assert_allclose(middle, [[0, -1, 0]], atol=1e-12)


@pytest.mark.parametrize("kind", [PerspectiveView, CylindricalView])
def test_views_reject_parallel_rays(kind):
    with raises_code("parallel-rays"):
        view_of(EVERY["orthographic"][0], kind, None, None)
