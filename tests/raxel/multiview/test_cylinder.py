"""The cylindrical view: uprights become columns, the horizon a row, points land."""

import numpy as np
import pytest

from raxel.cameras import (
    FisheyeCamera,
    OrthographicCamera,
    PerspectiveCamera,
    QuadricMirrorCamera,
)
from raxel.multiview.views import cylindrical_view, resample, source_pixels
from tests.raised import raises_code

DOWN, AHEAD = (0.0, 0.0, -1.0), (0.0, -1.0, 0.0)
A, B, FOCAL = 29.3, 15.3, 350.0
WIDTH = 400


def mirror_camera(**optional):
    K = [[FOCAL, 0, 159.5], [0, FOCAL, 119.5], [0, 0, 1]]
    viewer = PerspectiveCamera(K, [], 320, 240)
    return QuadricMirrorCamera.aligned(
        viewer, "hyperboloid", [A, B], 37.5, hole_radius=2.75, **optional
    )


@pytest.fixture(scope="module")
def camera():
    return mirror_camera()


@pytest.fixture(scope="module")
def view(camera):
    return cylindrical_view(camera, DOWN, AHEAD, WIDTH)


def in_camera(view, azimuth, height, distance=2000.0):
    """A point of the camera frame: azimuth rad, height and distance mm."""
    azimuth = np.asarray(azimuth, float)
    level = np.zeros_like(azimuth)
    x, z = distance * np.sin(azimuth), distance * np.cos(azimuth)
    own = np.column_stack(np.broadcast_arrays(x, level - height, z))
    return own @ view.R_camera_view.T + view.centre


def test_panorama_centre_is_inner_focus(camera, view):
    assert view.radius == pytest.approx(WIDTH / (2 * np.pi))
    np.testing.assert_allclose(view.centre, camera.centre, atol=1e-8)
    np.testing.assert_allclose(view.R_camera_view @ [0, 1, 0], DOWN, atol=1e-12)
    np.testing.assert_allclose(view.R_camera_view @ [0, 0, 1], AHEAD, atol=1e-12)
    assert np.linalg.det(view.R_camera_view) == pytest.approx(1.0)


def test_panorama_vertical_line_is_column(view):
    heights = np.linspace(-1500, 1500, 31)
    for azimuth in (-3.0, -1.0, 0.0, 2.2):
        u, v = view.project(in_camera(view, np.full(31, azimuth), heights)).T
        np.testing.assert_allclose(u, view.middle + view.radius * azimuth, atol=1e-9)
        wanted = view.horizon - view.radius * heights / 2000.0
        np.testing.assert_allclose(v, wanted, atol=1e-9)


def test_panorama_horizon_is_horizontal(view):
    azimuths = np.linspace(-3.1, 3.1, 25)
    for distance in (300.0, 9000.0):
        u, v = view.project(in_camera(view, azimuths, 0.0, distance)).T
        np.testing.assert_allclose(v, view.horizon, atol=1e-9)
        assert np.all(np.diff(u) > 0)
    assert view.elevations([view.horizon])[0] == 0.0
    np.testing.assert_allclose(
        view.elevations([view.horizon - view.radius]), np.pi / 4, atol=1e-12
    )


def test_panorama_directions_invert_projection(view):
    rng = np.random.default_rng(0)
    size = [view.width, view.height]
    pixels = rng.uniform(-0.49, 0.49, (200, 2)) + rng.integers(0, size, (200, 2))
    directions = view.directions(pixels)
    np.testing.assert_allclose(np.linalg.norm(directions, axis=1), 1.0)
    back = view.project(view.centre + 700.0 * directions)
    np.testing.assert_allclose(back, pixels, atol=1e-9)


def test_panorama_projects_mirror_point(camera, view):
    rng = np.random.default_rng(1)
    azimuth = rng.uniform(-np.pi, np.pi, 100)
    points = in_camera(view, azimuth, rng.uniform(-1800, 1800, 100))
    seen = camera.project(points)
    assert seen.valid.all()
    rays = camera.rays(seen.pixels)
    landed = view.project(rays.origins + 400.0 * rays.directions)
    np.testing.assert_allclose(landed, view.project(points), atol=1e-7)
    sources = source_pixels(camera, view)
    u, v = np.round(landed).astype(int).T
    inside = (v >= 0) & (v < view.height)
    far = 1e4 * view.directions(np.column_stack([u, v]).astype(float))
    again = camera.project(view.centre + far)
    np.testing.assert_allclose(
        sources[v, u % WIDTH][inside], again.pixels[inside], atol=1e-4
    )


def test_panorama_sources_match_closed_form(camera, view):
    e = np.hypot(A, B) / A
    sources = source_pixels(camera, view)[:, 17].astype(float)
    radius = np.linalg.norm(sources - [159.5, 119.5], axis=1)
    nadir = np.pi / 2 + view.elevations(np.arange(view.height))
    angle = 2 * np.arctan((e - 1) / (e + 1) * np.tan(nadir / 2))
    inner = slice(1, -1)
    np.testing.assert_allclose(radius[inner], (FOCAL * np.tan(angle))[inner], atol=1e-4)


def test_panorama_contains_horizon_rays(camera, view):
    v, u = np.mgrid[:240, :320]
    rays = camera.rays(np.column_stack([u.ravel(), v.ravel()]).astype(float))
    landed = view.project(rays.origins[rays.valid] + rays.directions[rays.valid])
    assert landed[:, 1].min() > -1.5
    assert landed[:, 1].max() < view.height + 0.5
    assert np.degrees(view.elevations([0, view.height - 1])) == pytest.approx(
        [50, -50], abs=1.0
    )


def test_panorama_is_black_without_rays(camera, view):
    taller = view._replace(
        height=view.height + 80, horizon=view.horizon + 40, centre=camera.centre
    )
    result = resample(
        np.full((240, 320, 3), 200, np.uint8), source_pixels(camera, taller)
    )
    assert result.shape == (taller.height, WIDTH, 3)
    assert not result[:30].any()
    assert not result[-30:].any()
    assert np.all(result[60:-60] == 200)


def test_upward_fisheye_has_horizon_at_edge():
    lens = FisheyeCamera("equidistance", 60.0, (99.5, 99.5), 200, 200, np.radians(92))
    view = cylindrical_view(lens, (0, 0, -2), (0, -3, 1), 360)
    below = view.height - 1 - view.horizon
    assert below == pytest.approx(view.radius * np.tan(np.radians(2)), abs=1.5)
    np.testing.assert_allclose(view.centre, 0, atol=1e-8)
    sources = source_pixels(lens, view)
    row = int(view.horizon)
    outward = np.linalg.norm(sources[row] - 99.5, axis=1)
    np.testing.assert_allclose(outward, 60 * np.pi / 2, atol=1e-3)


def test_panorama_rejects_invalid_input(camera):
    narrow = PerspectiveCamera([[900, 0, 50], [0, 900, 50], [0, 0, 1]], [], 100, 100)
    for code, arguments in (
        ("parallel-directions", (camera, DOWN, (0, 0, 5), WIDTH)),
        ("outside-image", (narrow, DOWN, AHEAD, WIDTH)),
    ):
        with raises_code(code):
            cylindrical_view(*arguments)


def test_paraboloid_camera_has_panorama():
    viewer = OrthographicCamera(6.0, (159.5, 119.5), 320, 240)
    camera = QuadricMirrorCamera.aligned(viewer, "paraboloid", [7.0], 19.0)
    view = cylindrical_view(camera, DOWN, AHEAD, WIDTH)
    row = int(view.horizon)
    radius = np.linalg.norm(source_pixels(camera, view)[row] - [159.5, 119.5], axis=1)
    np.testing.assert_allclose(radius, 6.0 * 14.0, atol=1e-3)


@pytest.mark.parametrize("width", [400, 401])
def test_panorama_is_symmetric_about_ahead(camera, width):
    view = cylindrical_view(camera, DOWN, AHEAD, width)
    pixels = np.column_stack([np.arange(width), np.full(width, view.horizon)])
    across = view.directions(pixels) @ view.R_camera_view
    np.testing.assert_allclose(across[:, 0], -across[::-1, 0], atol=1e-12)
    assert np.argmax(across[:, 2]) in ((width - 1) // 2, width // 2)
