"""Several planar mirrors before one viewer: catadioptric stereo."""

import math

import numpy as np
import pytest

from raxel.cameras import (
    FisheyeCamera,
    OrthographicCamera,
    PerspectiveCamera,
    PlanarMirrorsCamera,
    centrality,
)
from raxel.cameras.mirrors.bent import ball_facets
from raxel.errors import InputError
from raxel.geometry import (
    intersect_rays_plane,
    pose,
    rotation_from_vector,
    vector_from_rotation,
)
from tests.camera_checks import assert_same_from_file

W, H = 640, 480
WIDE = PerspectiveCamera([[300, 0, 319.5], [0, 300, 239.5], [0, 0, 1]], [], W, H)
BEHIND = pose(np.eye(3), [0, 0, -50])


def random_pixels(seed, count=1500):
    return np.random.default_rng(seed).uniform(0, [W - 1, H - 1], (count, 2))


def facet(turn_deg, x, depth=200.0, half=60.0):
    """A square mirror at (x, 0, depth) turned about y."""
    R = rotation_from_vector([0, math.radians(turn_deg), 0])
    square = [[-half, -half], [half, -half], [half, half], [-half, half]]
    return pose(R, [x, 0, depth]), square


def mirrors_of(*facets):
    poses, outlines = zip(*facets, strict=True)
    return PlanarMirrorsCamera(WIDE, np.array(poses), outlines)


STEREO = mirrors_of(facet(150, -55), facet(-150, 55))


def test_facet_equals_mirrored_viewer():
    pixels = random_pixels(13)
    facets, rays = STEREO.facet_of(pixels), STEREO.rays(pixels)
    assert (rays.valid <= (facets >= 0)).all()
    for k, T in enumerate(STEREO.T_viewer_facets):
        mine = rays.valid & (facets == k)
        assert mine.sum() > 50
        centre = 2 * T[:3, 3] @ T[:3, 2] * T[:3, 2]
        reach = centre - rays.origins[mine]
        assert np.abs(np.cross(reach, rays.directions[mine])).max() < 1e-10
    assert centrality(rays) > 10
    assert not STEREO.central
    assert STEREO.parameters == 5 + 6


def test_planar_mirrors_roundtrip_per_facet():
    pixels = random_pixels(14)
    facets, rays = STEREO.facet_of(pixels), STEREO.rays(pixels)
    depth = np.random.default_rng(14).uniform(1, 5000, (len(pixels), 1))
    points = rays.origins + depth * rays.directions
    for k in range(STEREO.facets):
        mine = rays.valid & (facets == k)
        seen = STEREO.project_facet(points[mine], k)
        assert seen.valid.all()
        assert np.abs(seen.pixels - pixels[mine]).max() < 1e-9
        assert not STEREO.project_facet(2 * STEREO.T_viewer_facets[k, :3, 3][None], k)[
            1
        ].any()
    assert STEREO.project(points).valid[rays.valid].all()


def test_point_in_two_facets_has_two_pixels():
    camera = mirrors_of(facet(172, -60), facet(-172, 60))
    point = np.array([[0.0, 10, -300]])
    first, second = (camera.project_facet(point, k) for k in range(2))
    assert first.valid.all()
    assert second.valid.all()
    assert first.pixels[0, 0] < W / 2 < second.pixels[0, 0]
    np.testing.assert_array_equal(camera.project(point).pixels, first.pixels)


@pytest.mark.parametrize("turned", [0, 180])
def test_orthographic_viewer_sees_facets(turned):
    """Whichever way their z axes point."""
    viewer = OrthographicCamera(2.0, (319.5, 239.5), W, H)
    facets = [facet(turned + 30, -70), facet(turned - 25, 70)]
    poses, outlines = zip(*facets, strict=True)
    camera = PlanarMirrorsCamera(viewer, np.array(poses), outlines)
    pixels = random_pixels(15)
    rays, shown = camera.rays(pixels), camera.facet_of(pixels)
    points = rays.origins + 100 * rays.directions
    for k, T in enumerate(camera.T_viewer_facets):
        mine = rays.valid & (shown == k)
        assert mine.sum() > 200
        seen = camera.project_facet(points[mine], k)
        assert seen.valid.all()
        assert np.abs(seen.pixels - pixels[mine]).max() < 1e-9
        normal = T[:3, 2] * -np.sign(T[2, 2])
        assert not camera.project_facet(rays.origins[mine] - 50 * normal, k).valid.any()


def test_planar_mirrors_file_roundtrip_is_bit_identical(tmp_path):
    triangle = [[0, 0], [30, 5], [10, 40]]
    camera = PlanarMirrorsCamera(
        FisheyeCamera("equidistance", 200, (320, 240), W, H),
        [facet(150, -55)[0], facet(-150, 55)[0]],
        [triangle, facet(0, 0)[1]],
    )
    pixels = random_pixels(15, 300)
    assert camera.rays(pixels).valid.any()
    assert_same_from_file(camera, pixels, tmp_path)


T_FRONT, SQUARE = facet(150, 0)


@pytest.mark.parametrize(
    ("poses", "outlines", "words"),
    [
        ([], [], "'outlines'"),
        ([T_FRONT], [SQUARE, SQUARE], "2 outlines for 1 poses"),
        ([T_FRONT], [[[0, 0], [1, 1], [2, 2]]], r"outlines\[0\]"),
        ([T_FRONT], [[[0, 0], [1, 1]]], r"outlines\[0\].* 2 "),
        ([BEHIND], [SQUARE], r"T_viewer_facets\[0\]"),
        ([facet(90, 0)[0]], [SQUARE], r"T_viewer_facets\[0\]"),
        ([np.ones((4, 4))], [SQUARE], "T_viewer_facets"),
    ],
)
def test_impossible_facets_are_rejected(poses, outlines, words):
    with pytest.raises(InputError, match=words):
        PlanarMirrorsCamera(WIDE, poses, outlines)


BALL = {
    "ball_radius": 100,
    "distance": 250,
    "facet_size": 18,
    "gap": 2,
    "cap": math.radians(70),
}


def test_mirror_ball_equals_its_facets():
    """Rays and facets of many mirrors against all of them asked one by one."""
    camera = PlanarMirrorsCamera.on_ball(WIDE, **BALL, tilt_sd=0.02, specimen=3)
    assert camera.facets > 100
    pixels = random_pixels(16, 4000)
    seen = WIDE.rays(pixels)
    nearest, found = np.full(len(pixels), np.inf), np.full(len(pixels), -1)
    for k, T in enumerate(camera.T_viewer_facets):
        met = intersect_rays_plane(seen.origins, seen.directions, T)
        with np.errstate(invalid="ignore"):
            hit = (np.abs(met.points) < 9).all(axis=1) & (met.range < nearest)
        nearest[hit], found[hit] = met.range[hit], k
    np.testing.assert_array_equal(camera.facet_of(pixels), found)
    rays = camera.rays(pixels)
    assert 0.05 < rays.valid.mean() < 0.5
    point = rays.origins + 300 * rays.directions
    for k in np.unique(found[rays.valid])[::15]:
        mine = rays.valid & (found == k)
        back = camera.project_facet(point[mine], k)
        np.testing.assert_allclose(back.pixels, pixels[mine], atol=1e-9)


@pytest.mark.parametrize(
    ("field", "value"),
    [
        ("cap", 2.0),
        ("gap", -1),
        ("facet_size", 0.5),
        ("tilt_sd", math.nan),
        ("specimen", 0.5),
        ("ball_radius", 0),
    ],
)
def test_invalid_ball_is_rejected(field, value):
    with pytest.raises(InputError, match=f"field '{field}'"):
        ball_facets(**BALL | {field: value})


def test_facet_tilt_is_about_own_sides():
    """Nowhere on the ball does glueing turn a facet in its own plane."""
    straight, _ = ball_facets(**BALL)
    tilted, _ = ball_facets(**BALL, tilt_sd=0.02, specimen=3)
    turns = vector_from_rotation(
        np.swapaxes(straight[:, :3, :3], 1, 2) @ tilted[:, :3, :3]
    )
    np.testing.assert_allclose(turns[:, 2], 0, atol=1e-12)
    np.testing.assert_allclose(turns[:, :2].std(axis=0), 0.02, rtol=0.2)
