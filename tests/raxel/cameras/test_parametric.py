"""Perspective and fisheye cameras (2.1 to 2.8): each map is the other's inverse."""

import math

import cv2
import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from raxel.cameras import FisheyeCamera, PerspectiveCamera, UnifiedSphereCamera
from raxel.errors import InputError
from raxel.evaluation.coverage import field_of_view
from tests.camera_checks import (
    assert_extreme_values_are_flagged,
    assert_points_come_back,
)
from tests.camera_zoo import assert_pixels_come_back

K = np.array([[810, 2.5, 330], [0, 760, 250], [0, 0, 1.0]])
# A quarter of the focal length: the corners of the image pass the turning point.
K_WIDE = K / [[4], [4], [1]] + [[0, 0, 240], [0, 0, 180], [0, 0, 0]]
PERSPECTIVE = {
    "pinhole": PerspectiveCamera(K, [], 640, 480),
    "barrel": PerspectiveCamera(K, [-0.3, 0.1], 640, 480),
    "pincushion": PerspectiveCamera(K, [0.2], 640, 480),
    "four terms": PerspectiveCamera(K, [0.3, -0.2, 0.1, 0.4], 640, 480),
    "beyond the turn": PerspectiveCamera(K_WIDE, [-0.3, 0.05], 640, 480),
}
PROJECTIONS = ("equidistance", "equisolid", "stereographic")
FISHEYE = {
    f"{name} {degrees}": FisheyeCamera(
        name, 120, (310.5, 242.25), 640, 480, math.radians(degrees)
    )
    for name in PROJECTIONS
    for degrees in (60, 110, 175)
}
CAMERAS = PERSPECTIVE | FISHEYE


@pytest.mark.parametrize("name", CAMERAS)
def test_points_on_pixel_ray_project_to_it(name):
    camera = CAMERAS[name]
    rng = np.random.default_rng(0)
    pixels = np.vstack([rng.uniform(-0.5, 639.5, (4000, 2)), [[330, 250]]])
    assert assert_pixels_come_back(camera, pixels, rng).mean() > 0.1


@pytest.mark.parametrize("name", CAMERAS)
def test_ray_of_projected_pixel_meets_point(name):
    camera = CAMERAS[name]
    points = np.random.default_rng(1).normal(0, 100, (4000, 3))
    pixels, valid = camera.project(points)
    assert 0.02 < valid.mean() <= 1
    rays = camera.rays(pixels[valid])
    assert rays.valid.all()
    unit = points[valid] / np.linalg.norm(points[valid], axis=1, keepdims=True)
    # Next to a turning point a pixel determines its ray only to the root of rounding.
    np.testing.assert_allclose(rays.directions, unit, atol=1e-7)


@given(
    st.lists(st.integers(-5000, 5000).map(lambda k: k / 1e4), max_size=4),
    st.floats(200, 2000),
    st.floats(0.7, 1.4),
    st.floats(-20, 20),
    st.integers(0, 2**32 - 1),
)
@settings(max_examples=60, deadline=None)
def test_perspective_camera_roundtrip(radial, f, aspect, skew, seed):
    camera = PerspectiveCamera(
        [[aspect * f, skew, 320], [0, f, 240], [0, 0, 1]], radial, 640, 480
    )
    pixels = np.random.default_rng(seed).uniform(0, [639, 479], (200, 2))
    assert_points_come_back(camera, pixels, 5)


def test_perspective_agrees_with_opencv():
    points = np.random.default_rng(2).uniform([-2, -1.5, 4], [2, 1.5, 6], (100, 3))
    straight = K * [[1, 0, 1], [1, 1, 1], [1, 1, 1]]
    camera = PerspectiveCamera(straight, [-0.3, 0.1], 640, 480)
    expected, _ = cv2.projectPoints(
        points, np.zeros(3), np.zeros(3), straight, np.array([-0.3, 0.1, 0, 0])
    )
    np.testing.assert_allclose(
        camera.project(points).pixels, expected[:, 0], rtol=0, atol=1e-10
    )


def test_turning_point_limits_field_of_view():
    camera = PerspectiveCamera(np.diag([100.0, 100, 1]), [-1 / 3], 640, 480)
    # r - r^3/3 turns at r = 1, where it is 2/3.
    assert camera.max_radius == pytest.approx(1, abs=1e-15)
    points = np.array([[0.999, 0, 1], [1.001, 0, 1], [1.5, 0, 1]])
    assert camera.project(points).valid.tolist() == [True, False, False]
    pixels = np.array([[66.6, 0], [66.7, 0], [0, -66.6], [0, -66.7]])
    assert camera.rays(pixels).valid.tolist() == [True, False, True, False]


def test_points_behind_camera_are_invalid():
    points = np.array([[0, 0, -1.0], [0.1, 0, 0], [1, 1, -1e-9], [0, 0, np.nan]])
    pixels, valid = PERSPECTIVE["pinhole"].project(points)
    assert not valid.any()
    assert np.isnan(pixels).all()


@pytest.mark.parametrize("name", PROJECTIONS)
def test_projection_functions_match_thesis(name):
    camera = FisheyeCamera(name, 200, (50, 60), 101, 121)
    theta, phi = np.radians([0, 1e-7, 30, 89.9999, 90, 120, 179]), 0.7
    azimuth = np.array([math.cos(phi), math.sin(phi)])
    points = np.column_stack([np.outer(np.sin(theta), azimuth), np.cos(theta)])
    radius = {
        "equidistance": 200 * theta,
        "equisolid": 400 * np.sin(theta / 2),
        "stereographic": 400 * np.tan(theta / 2),
    }[name]
    pixels, valid = camera.project(7 * points)
    assert valid.all()
    np.testing.assert_allclose(
        pixels, np.outer(radius, azimuth) + [50, 60], rtol=1e-12, atol=1e-12
    )


@pytest.mark.parametrize("name", CAMERAS)
def test_extreme_values_are_flagged_without_warning(name):
    assert_extreme_values_are_flagged(CAMERAS[name])


@pytest.mark.parametrize(
    ("field", "make"),
    [
        ("K", lambda: PerspectiveCamera(np.eye(2), [], 4, 4)),
        ("K", lambda: PerspectiveCamera(-np.eye(3), [], 4, 4)),
        ("K", lambda: PerspectiveCamera(np.eye(3) * np.nan, [], 4, 4)),
        ("K", lambda: PerspectiveCamera(np.ones((3, 3)), [], 4, 4)),
        ("radial", lambda: PerspectiveCamera(np.eye(3), [np.inf], 4, 4)),
        ("radial", lambda: PerspectiveCamera(np.eye(3), 0.1, 4, 4)),
        ("width", lambda: PerspectiveCamera(np.eye(3), [], 0, 4)),
        ("height", lambda: PerspectiveCamera(np.eye(3), [], 4, 4.5)),
        ("height", lambda: PerspectiveCamera(np.eye(3), [], 4, np.nan)),
        ("projection", lambda: FisheyeCamera("orthographic", 1, (0, 0), 4, 4)),
        ("focal_px", lambda: FisheyeCamera("equisolid", -1, (0, 0), 4, 4)),
        ("principal_point", lambda: FisheyeCamera("equisolid", 1, (0,), 4, 4)),
        ("max_angle", lambda: FisheyeCamera("equisolid", 1, (0, 0), 4, 4, 180)),
    ],
)
def test_impossible_parameters_are_rejected_by_name(field, make):
    with pytest.raises(InputError, match=f"^field '{field}': "):
        make()


@pytest.mark.parametrize("xi", [1.2, 1.5, 2.0])
def test_negative_k_limits_pixels_at_turning_point(xi):
    """dr / dtheta = 0 at cos theta = -1 / xi, where r = 1 / sqrt(xi^2 - 1)."""
    camera = UnifiedSphereCamera(
        xi, [[100.0, 0, 300], [0, 100.0, 300], [0, 0, 1]], 601, 601
    )
    theta = np.linspace(0, np.arccos(-1 / xi), 100_001)
    most = 100 * np.max(np.sin(theta) / (np.cos(theta) + xi))
    turn = np.linspace(0, 2 * np.pi, 12)
    around = np.column_stack([np.cos(turn), np.sin(turn)])
    inside = camera.rays(300 + 0.999 * most * around)
    assert inside.valid.all()
    angle = np.arccos(inside.directions[:, 2])
    # Near its largest the radius hardly changes with the angle.
    assert angle == pytest.approx(np.arccos(-1 / xi), abs=0.12)
    assert not camera.rays(300 + 1.001 * most * around).valid.any()


def test_field_of_view_includes_outer_pixels():
    camera = PerspectiveCamera([[50.0, 0, 9.5], [0, 50.0, 4.5], [0, 0, 1]], [], 20, 10)
    found = field_of_view(camera)
    assert found["horizontal"] == pytest.approx(2 * math.degrees(math.atan(10 / 50)))
    assert found["vertical"] == pytest.approx(2 * math.degrees(math.atan(5 / 50)))
