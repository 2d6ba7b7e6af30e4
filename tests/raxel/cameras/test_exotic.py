"""Cameras without a centre: parallel, crossed slits, pushbroom, axial; caustics."""

import math
from types import SimpleNamespace

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from raxel.cameras import (
    AxialCamera,
    FisheyeCamera,
    KannalaBrandtCamera,
    MovingPupilCamera,
    OrthographicCamera,
    PushbroomCamera,
    Rays,
    XSlitsCamera,
    camera_from,
    centrality,
    closest_point,
)
from raxel.cameras.core.caustic import caustic_points
from tests.camera_checks import (
    assert_extreme_values_are_flagged,
    assert_points_come_back,
    assert_same_from_file,
)
from tests.lab_cameras import EVERY
from tests.raised import raises_line

W, H = 64, 48
SLITS = {
    "slit_points": [[0, 0, 2.0], [1, 0, -30.0]],
    "slit_directions": [[0.1, 1, 0], [1, 0.05, 0.1]],
    "image_distance": 8.0,
    "pixels_per_mm": [10, 11],
    "principal_point": [31, 24],
    "width": W,
    "height": H,
}
XSLITS = XSlitsCamera(**SLITS)
PUSHBROOM = PushbroomCamera(50, 31.5, [0.3, 2.0, -0.4], W, H, 20)
AXIAL = AxialCamera("equisolid", 28, [31.2, 23.1], [2.5, -0.3], W, H, 1.7)
ORTHOGRAPHIC = OrthographicCamera(4, [31, 22.5], W, H)
CAMERAS = [ORTHOGRAPHIC, XSLITS, PUSHBROOM, AXIAL]
BY_KIND = pytest.mark.parametrize("camera", CAMERAS, ids=lambda c: c.kind)


def on_lines(points, rays):
    """Distance of points (N, 3) from the lines of rays."""
    return np.linalg.norm(np.cross(points - rays.origins, rays.directions), axis=1)


@BY_KIND
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=10, deadline=None)
def test_points_on_ray_project_to_its_pixel(camera, seed):
    rng = np.random.default_rng(seed)
    pixels = rng.uniform(0, [W - 1, H - 1], (300, 2))
    depth = 10 ** rng.uniform(1.5, 5, (300, 1))
    rays = assert_points_come_back(camera, pixels, depth)
    assert rays.valid.all()
    np.testing.assert_allclose(np.linalg.norm(rays.directions, axis=1), 1, atol=1e-15)


@BY_KIND
def test_points_behind_origin_are_invalid(camera):
    rays = camera.rays(np.array([[30.0, 20], [10, 40], [50, 7]]))
    assert not camera.project(rays.origins - 50 * rays.directions).valid.any()


@BY_KIND
def test_non_finite_values_are_invalid(camera):
    assert not camera.rays(np.array([[np.nan, 1], [1, np.inf]])).valid.any()
    points = np.array([[np.nan, 0, 50], [0, 0, np.inf]])
    assert not camera.project(points).valid.any()


@pytest.mark.parametrize("name", EVERY)
def test_extreme_values_are_flagged_without_warning(name):
    assert_extreme_values_are_flagged(EVERY[name][0])


@BY_KIND
def test_camera_file_roundtrip_is_bit_identical(camera, tmp_path):
    pixels = np.random.default_rng(0).uniform(0, [W, H], (50, 2))
    assert_same_from_file(camera, pixels, tmp_path)
    assert not camera.central


def test_rays_of_crossed_slits_meet_both_slits():
    rays = XSLITS.rays(np.random.default_rng(1).uniform(0, [W, H], (200, 2)))
    for point, slit in zip(XSLITS.slit_points, XSLITS.slit_directions, strict=True):
        across = np.cross(rays.directions, slit)
        gap = np.sum((rays.origins - point) * across, axis=1)
        assert np.abs(gap / np.linalg.norm(across, axis=1)).max() < 1e-12
    # The slit ahead, at z near 2, is where rays begin.
    assert np.abs(rays.origins[:, 2] - 2).max() < 1e-12


def test_points_between_slits_are_invalid():
    """Rays begin at the slit ahead, z = 2; the other one is at z = -30."""
    rays = XSLITS.rays(np.random.default_rng(8).uniform(0, [W, H], (50, 2)))
    assert not XSLITS.project(rays.origins - 5 * rays.directions).valid.any()


def test_axial_rays_cross_axis():
    pixels = np.random.default_rng(4).uniform(0, [W - 1, H - 1], (200, 2))
    rays = AXIAL.rays(pixels)
    assert not rays.origins[:, :2].any()
    still = AxialCamera("equisolid", 28, [31.2, 23.1], [], W, H, 1.7)
    assert still.central
    assert still.parameters == 3
    lens = FisheyeCamera("equisolid", 28, [31.2, 23.1], W, H, 1.7)
    for ours, theirs in zip(still.rays(pixels), lens.rays(pixels), strict=True):
        np.testing.assert_array_equal(ours, theirs)
    np.testing.assert_array_equal(rays.directions, lens.rays(pixels).directions)


def test_points_before_axial_caustic_use_other_ray():
    pixel = np.array([[58.0, 24.0]])
    rays = AXIAL.rays(pixel)
    point = rays.origins + 0.95 * caustic_reach(rays) * rays.directions
    near = AXIAL.project(point)
    assert near.valid.all()
    assert np.abs(near.pixels - pixel).max() > 1e-3
    again = AXIAL.rays(near.pixels)
    assert on_lines(point, again)[0] < 1e-12
    assert np.sum((point - again.origins) * again.directions) > caustic_reach(again)[0]


def caustic_reach(rays):
    """Where neighbouring axial rays meet: (N,) along them from the axis."""
    angle = np.arccos(rays.directions[:, 2])
    return AXIAL.pupil(angle)[1] * np.sin(angle)


def test_axial_caustic_matches_closed_form():
    """One sheet on the axis, the other at z0'(theta) sin(theta) along the ray."""
    pixels = np.array([[55.0, 30], [12, 40], [33, 30]])
    rays = AXIAL.rays(pixels)
    sheets = caustic_points(AXIAL, pixels)
    reach = caustic_reach(rays)
    np.testing.assert_allclose(sheets[:, 0], rays.origins, atol=1e-8)
    meridional = rays.origins + reach[:, None] * rays.directions
    np.testing.assert_allclose(sheets[:, 1], meridional, atol=1e-7)


def test_xslits_caustic_is_slits():
    pixels = np.random.default_rng(5).uniform(5, [W - 5, H - 5], (50, 2))
    sheets = caustic_points(XSLITS, pixels)
    for k, slit in ((1, 0), (0, 1)):
        unit = XSLITS.slit_directions[slit] / np.linalg.norm(
            XSLITS.slit_directions[slit]
        )
        off = np.cross(sheets[:, k] - XSLITS.slit_points[slit], unit)
        assert np.linalg.norm(off, axis=1).max() < 1e-7


def test_caustic_at_centre_and_infinity():
    pixels = np.array([[10.0, 20], [40, 30], [np.nan, 3]])
    sheets = caustic_points(FisheyeCamera("equidistance", 20, [31, 24], W, H), pixels)
    assert not sheets[:2].any()
    assert np.isnan(sheets[2]).all()
    assert np.isnan(caustic_points(ORTHOGRAPHIC, pixels)).all()
    # Rows of a pushbroom meet at their centre; its columns meet nowhere.
    sheets = caustic_points(PushbroomCamera(50, 31, [0, 2, 0], W, H), pixels)
    np.testing.assert_allclose(sheets[:2, 0], [[0, 40, 0], [0, 60, 0]], atol=1e-9)
    assert np.isnan(sheets[:, 1]).all()


def test_centrality_is_distance_from_best_point():
    rng = np.random.default_rng(6)
    d = rng.normal(size=(500, 3))
    d /= np.linalg.norm(d, axis=1)[:, None]
    centre = np.array([300.0, -20, 1e3])
    origins = centre + rng.uniform(-1e3, 1e3, (500, 1)) * d
    valid = rng.random(500) < 0.9
    origins[~valid] = np.nan
    rays = Rays(origins, d, valid)
    np.testing.assert_allclose(closest_point(rays), centre, atol=1e-10)
    assert centrality(rays) < 1e-10
    # Two skew lines, a distance 2 apart: each passes their middle at 1.
    skew = Rays(
        np.array([[5.0, 0, 1], [0, 7, -1]]), np.eye(3)[:2], np.array([True, True])
    )
    assert centrality(skew) == pytest.approx(1, abs=1e-12)
    parallel = ORTHOGRAPHIC.rays(np.array([[29.0, 22.5], [33, 22.5]]))
    assert centrality(parallel) == pytest.approx(0.5, abs=1e-12)


@pytest.mark.parametrize(
    ("kind", "field", "value"),
    [
        ("x-slits", "slit_directions", [[0, 1, 0], [0, 2, 0]]),
        ("x-slits", "slit_points", [[0, 0, 1], [0, 0, 1]]),
        ("x-slits", "slit_directions", [[0, 0, 0], [1, 0, 0]]),
        ("x-slits", "pixels_per_mm", [1, -1]),
        ("x-slits", "image_distance", math.nan),
        ("pushbroom", "velocity", [1, 0, 0]),
        ("pushbroom", "focal_px", 0),
        ("axial", "max_angle", math.pi),
        ("axial", "pupil_shift", [[1]]),
        ("orthographic", "pixels_per_mm", -2),
    ],
)
def test_impossible_cameras_are_rejected(kind, field, value):
    camera = next(c for c in CAMERAS if c.kind == kind)
    fields = {n: getattr(camera, n) for n in camera._fields()}
    fields |= {"width": W, "height": H, field: value}
    with raises_line(f"field '{field}'"):
        camera_from(kind, fields)


def test_image_plane_through_slit_is_rejected():
    fields = SLITS | {"slit_directions": [[0, 1, 0], [1, 0, 0]], "image_distance": 2}
    with raises_line("field 'image_distance'"):
        XSlitsCamera(**fields)


def test_axial_points_beyond_caustic_are_seen():
    pixels = np.array([[33.0, 24.0], [38, 20], [45, 30], [58, 24]])
    reach = 1.05 * caustic_reach(AXIAL.rays(pixels))[:, None]
    assert assert_points_come_back(AXIAL, pixels, reach).valid.all()


def test_moving_pupil_projects_points_beyond_caustic():
    lens = KannalaBrandtCamera([1, 0.02], [28, 28], [31, 24], W, H)
    camera = MovingPupilCamera(lens, [4.0, 1.0])
    pixels = np.random.default_rng(9).uniform([40, 30], [60, 45], (50, 2))
    rays = camera.rays(pixels)
    # Its rays cross the axis, where they begin, and then their neighbours further out.
    reach = np.linalg.norm(caustic_points(camera, pixels)[:, 1] - rays.origins, axis=1)
    beyond = camera.project(rays.origins + 1.05 * reach[:, None] * rays.directions)
    assert np.abs(beyond.pixels - pixels).max() < 1e-6
    before = camera.project(rays.origins + 0.8 * reach[:, None] * rays.directions)
    assert not (np.linalg.norm(before.pixels - pixels, axis=1) < 1e-3).any()


@pytest.mark.parametrize("sign", [1, -1])
def test_moving_pupil_projection_is_independent_per_point(sign):
    lens = KannalaBrandtCamera([1, 0.02], [28, 28], [31, 24], W, H)
    camera = MovingPupilCamera(lens, [sign * 4.0, sign * 1.0])
    for pixel in ([40.0, 30], [58, 12], [3, 40]):
        rays = camera.rays([pixel])
        found = camera.project(rays.origins + 40 * rays.directions)
        np.testing.assert_allclose(found.pixels, [pixel], atol=1e-8)


@BY_KIND
def test_caustic_is_independent_of_ray_origins(camera):
    def later(pixels):
        rays = camera.rays(pixels)
        return rays._replace(origins=rays.origins + 7 * rays.directions)

    pixels = np.array([[10.0, 20], [40, 30], [52, 8]])
    sheets = caustic_points(SimpleNamespace(rays=later), pixels)
    np.testing.assert_allclose(sheets, caustic_points(camera, pixels), atol=1e-7)


def test_centrality_uses_all_components():
    """Pairs of lines to both sides of a point, 3 and 4 mm off across each other."""
    rng, middle = np.random.default_rng(10), np.array([5.0, -2.0, 7.0])
    first = np.linalg.qr(rng.normal(size=(40, 3, 3)))[0]
    d = first[:, :, 2]
    off = 3 * first[:, :, 0] + 4 * first[:, :, 1]
    along = rng.uniform(-9, 9, (80, 1)) * np.concatenate([d, d])
    origins = middle + np.concatenate([off, -off]) + along
    rays = Rays(origins, np.concatenate([d, d]), np.ones(80, bool))
    np.testing.assert_allclose(closest_point(rays), middle, atol=1e-9)
    assert centrality(rays) == pytest.approx(5.0)
