"""Cameras from mirror geometry: reflection, centres, caustics."""

import math

import numpy as np
import pytest
from hypothesis import example, given, settings
from hypothesis import strategies as st

from raxel.cameras import (
    FisheyeCamera,
    QuadricMirrorCamera,
    UnifiedSphereCamera,
    centrality,
)
from raxel.cameras.core.caustic import caustic_points
from raxel.cameras.mirrors.curved import stationarity
from raxel.cameras.mirrors.quadric import ConicMirror
from raxel.geometry import inverse_pose, pose, rotation_from_vector, transform
from tests.mirror_cameras import (
    CENTRAL,
    CONCAVE,
    CONVEX,
    ELLIPSOID,
    EVERY,
    HYPERBOLOID,
    MIRRORS,
    PARABOLOID,
    PARALLEL,
    PINHOLE,
    WIDE,
    H,
    W,
    aligned,
    misaligned,
    on_axis,
    random_pixels,
)


@pytest.mark.parametrize("name", CENTRAL | CONVEX)
@given(seed=st.integers(0, 2**32 - 1))
@example(seed=347299)  # a point of the ellipsoid's rays 0.3 um from their centre
@settings(max_examples=4, deadline=None)
def test_points_on_ray_project_to_its_pixel(name, seed):
    camera, pixels = MIRRORS[name], random_pixels(seed)
    rays = camera.rays(pixels)
    assert rays.valid.mean() > 0.1
    depth = 10 ** np.random.default_rng(seed).uniform(0, 5, (len(pixels), 1))
    points = rays.origins + depth * rays.directions
    back = camera.project(points)
    np.testing.assert_array_equal(back.valid, rays.valid)
    slack = np.full(len(pixels), 1e-9)
    if camera.central:
        # Rays of an ellipsoid pass through the centre itself; so near to it the
        # rounding of the point is an angle.
        away = np.linalg.norm(points - camera.centre, axis=1)
        slack += 1e-11 / away
    assert np.all((np.abs(back.pixels - pixels).max(axis=1) < slack)[rays.valid])


@pytest.mark.parametrize("name", CONCAVE)
def test_concave_mirror_projects_points_beyond_caustic(name):
    """Points may have several images; whichever is found, its ray holds the point."""
    camera, pixels = MIRRORS[name], random_pixels(3)
    rays = camera.rays(pixels)
    far = 500 * np.random.default_rng(3).uniform(1, 100, (len(pixels), 1))
    points = rays.origins + far * rays.directions
    back = camera.project(points)
    np.testing.assert_array_equal(back.valid, rays.valid)
    again = camera.rays(back.pixels)
    reach = points - again.origins
    off = np.linalg.norm(np.cross(reach, again.directions), axis=1)
    assert np.nanmax(off / np.linalg.norm(reach, axis=1)) < 1e-11
    assert np.mean(np.abs(back.pixels - pixels)[rays.valid].max(axis=1) < 1e-9) > 0.99


@EVERY
def test_ray_origins_are_on_mirror(name):
    camera = MIRRORS[name]
    rays = camera.rays(random_pixels(1))
    on = transform(inverse_pose(camera.T_viewer_mirror), rays.origins[rays.valid])
    across = np.hypot(on[:, 0], on[:, 1])
    assert across.max() <= camera.rim_radius * (1 + 1e-9)
    assert across.min() >= camera.hole_radius * (1 - 1e-9)
    a, b = (*camera.axes, camera.axes[0])[:2]
    z = on[:, 2]
    left = {
        "hyperboloid": ((z + a) / a) ** 2 - (across / b) ** 2 - 1,
        "ellipsoid": ((z - a) / a) ** 2 + (across / b) ** 2 - 1,
        "sphere": (across**2 + (z - a) ** 2) / a**2 - 1,
        "paraboloid": across**2 / (4 * a * a) - z / a,
    }[camera.shape]
    assert np.abs(left).max() < 1e-12


@EVERY
def test_reflection_angles_are_equal(name):
    camera, pixels = MIRRORS[name], random_pixels(2)
    rays, seen = camera.rays(pixels), camera.viewer.rays(pixels)
    keep = rays.valid
    on = transform(inverse_pose(camera.T_viewer_mirror), rays.origins[keep])
    n = camera.mirror.normals(on) @ camera.T_viewer_mirror[:3, :3].T
    n /= np.linalg.norm(n, axis=1)[:, None]
    before, after = seen.directions[keep], rays.directions[keep]
    np.testing.assert_allclose(np.linalg.norm(after, axis=1), 1, atol=1e-14)
    np.testing.assert_allclose(
        np.sum(before * n, axis=1), -np.sum(after * n, axis=1), atol=1e-12
    )
    np.testing.assert_allclose(np.cross(before, n), np.cross(after, n), atol=1e-12)
    assert np.all(np.sum(after * n, axis=1) > 0)


@pytest.mark.parametrize("name", CENTRAL)
def test_aligned_camera_is_central_at_focus(name):
    camera = CENTRAL[name]
    assert camera.central
    rays = camera.rays(random_pixels(5))
    reach = camera.centre - rays.origins
    assert np.nanmax(np.linalg.norm(np.cross(reach, rays.directions), axis=1)) < 1e-9
    assert centrality(rays) < 1e-9
    caustic = caustic_points(camera, random_pixels(5, 200))
    assert np.nanmax(np.abs(caustic - camera.centre)) < 1e-7


@pytest.mark.parametrize("side", ["inside", "outside"])
def test_misalignment_rotates_about_apex(side):
    """Whichever way its own axes point."""
    turn, offset = np.array([0.02, -0.03, 0.01]), np.array([1.0, -2.0, 0.5])
    mirror = "hyperboloid", (20.0, 30.0), 25.0
    straight = aligned(PINHOLE, *mirror, side=side).T_viewer_mirror
    moved = misaligned(PINHOLE, *mirror, offset, turn, side=side).T_viewer_mirror
    R = rotation_from_vector(turn)
    np.testing.assert_allclose(moved[:3, :3], R @ straight[:3, :3], atol=1e-12)
    np.testing.assert_allclose(moved[:3, 3], straight[:3, 3] + offset)


@pytest.mark.parametrize(
    ("name", "xi", "focal", "flip"),
    [
        # e = c/a: xi = 2e / (1 + e^2), focal (e^2 - 1) / (e^2 + 1); seen backwards.
        ("hyperboloid", None, 600, -1),
        ("paraboloid", 1.0, 8 * 20, -1),
    ],
)
def test_convex_mirror_is_unified_sphere(name, xi, focal, flip):
    camera = CENTRAL[name]
    if xi is None:
        e = math.hypot(30, 20) / 30
        xi, focal = 2 * e / (1 + e * e), focal * (e * e - 1) / (e * e + 1)
    K = [[focal, 0, 319.5], [0, focal, 239.5], [0, 0, 1]]
    pixels = random_pixels(8)
    ours, theirs = camera.rays(pixels), UnifiedSphereCamera(xi, K, W, H).rays(pixels)
    keep = ours.valid
    assert theirs.valid[keep].all()
    np.testing.assert_allclose(
        ours.directions[keep], theirs.directions[keep] * [1, 1, flip], atol=1e-12
    )


def test_sphere_reflection_solves_alhazen_quartic():
    """In the plane of centre, viewer and point: a quartic in the half-angle tangent."""
    camera = CONVEX["sphere"]
    R, far = 30.0, 130.0
    rng = np.random.default_rng(9)
    for _ in range(60):
        angle, distance = rng.uniform(0.05, 2.4), rng.uniform(60, 2000)
        x, y = distance * math.sin(angle), distance * math.cos(angle)
        # With N = (sin t, cos t): cross(N, C/R - N) (P/R - N).N + the same swapped = 0.
        one = np.poly1d([1, 0, 1])
        sine, cosine = np.poly1d([2, 0]), np.poly1d([-1, 0, 1])
        across_c, along_c = far / R * sine, far / R * cosine - one
        across_p = (y * sine - x * cosine) / R
        along_p = (x * sine + y * cosine) / R - one
        roots = (across_c * along_p + across_p * along_c).roots
        t = 2 * np.arctan(roots.real[np.abs(roots.imag) < 1e-7])
        n = np.column_stack([np.sin(t), np.cos(t)])
        lit = (n @ [0, far] > R) & (n @ [x, y] > R)
        turn = rng.uniform(0, 2 * math.pi)
        unit = np.array([math.cos(turn), math.sin(turn)])
        seen = camera.project(np.array([*(x * unit), far - y])[None])
        within = lit & (R * n[:, 0] <= camera.rim_radius) & (n[:, 0] > 0)
        assert seen.valid[0] == within.any()
        if within.any():
            (m,) = n[within]
            place = np.array([*(R * m[0] * unit), far - R * m[1]])
            pixel = PINHOLE.project(place[None]).pixels
            np.testing.assert_allclose(seen.pixels, pixel, atol=1e-7)


def test_sphere_caustic_matches_closed_form():
    """At incidence i: R cos(i) / 2 behind the surface, and R / (2 cos i) across."""
    camera = CONVEX["sphere, parallel"]
    pixels = random_pixels(10, 300)
    pixels[0] = 319.5, 239.5
    rays = camera.rays(pixels)
    cosine = np.sqrt((1 - rays.directions[:, 2]) / 2)
    steps = np.stack([-15 / cosine, -15 * cosine], axis=1)
    expected = rays.origins[:, None] + steps[..., None] * rays.directions[:, None]
    sheets = caustic_points(camera, pixels)
    has = np.isfinite(sheets).all(axis=(1, 2))
    assert has.sum() > 0.9 * rays.valid.sum()
    # On the axis both are R/2 behind the apex, at z = 100.
    np.testing.assert_allclose(sheets[0], [[0, 0, 115]] * 2, atol=1e-6)
    np.testing.assert_allclose(sheets[has], expected[has], atol=1e-6)


@pytest.mark.parametrize("shape", [HYPERBOLOID, PARABOLOID, ELLIPSOID])
def test_stationarity_derivative_equals_differences(shape):
    mirror = ConicMirror(*shape, 0, "outside")
    rng = np.random.default_rng(11)
    p = rng.uniform(-0.2, 0.2, (20, 2))
    points, eye = rng.uniform(-300, -100, (20, 3)), np.array([3.0, -4, -70])

    def arrivals(M):
        distance = np.linalg.norm(M - eye, axis=1)
        return (M - eye) / distance[:, None], 1 / distance

    _, slope = stationarity(mirror, p, points, arrivals)
    for k, axis in enumerate(np.eye(2) * 1e-6):
        ahead = stationarity(mirror, p + axis, points, arrivals)[0]
        numeric = (ahead - stationarity(mirror, p - axis, points, arrivals)[0]) / 2e-6
        np.testing.assert_allclose(slope[..., k], numeric, rtol=1e-6, atol=1e-2)


@given(st.integers(0, 2**32 - 1))
@settings(max_examples=10, deadline=None)
def test_convex_mirror_finds_all_reflections(seed):
    rng = np.random.default_rng(seed)
    shape = ("hyperboloid", "ellipsoid", "sphere", "paraboloid")[rng.integers(4)]
    limits = {"hyperboloid": (1.05, 3), "ellipsoid": (0.1, 0.95)}
    R = rng.uniform(10, 60)
    axes = (R / 2,) if shape == "paraboloid" else (R,)
    if shape in limits:
        kappa = abs(1 - rng.uniform(*limits[shape]) ** 2)
        axes = (R / kappa, R / math.sqrt(kappa))
    widest = axes[-1] if shape in ("sphere", "ellipsoid") else 3 * R
    rim = widest * rng.uniform(0.3, 0.98)
    viewer = (WIDE, PARALLEL)[rng.integers(2)]
    straight = on_axis(
        viewer, shape, axes, rim, R * rng.uniform(1, 8), side="outside"
    ).T_viewer_mirror
    turn = rotation_from_vector(rng.normal(0, 0.1, 3))
    T = pose(turn, straight[:3, 3] + rng.normal(0, 0.05 * R, 3))
    camera = QuadricMirrorCamera(viewer, shape, axes, rim, T, side="outside")
    pixels = random_pixels(seed, 500)
    rays = camera.rays(pixels)
    points = rays.origins + 10 ** rng.uniform(0, 5, (500, 1)) * rays.directions
    back = camera.project(points)
    np.testing.assert_array_equal(back.valid, rays.valid)
    assert np.abs(back.pixels - pixels)[rays.valid].max(initial=0) < 1e-9


def test_points_behind_mirror_are_invalid():
    for name in ("hyperboloid", "hyperboloid off", "sphere"):
        camera = MIRRORS[name]
        behind = [[0.0, 0, 300], [5, 5, 150], [0, 0, np.nan], [np.inf, 0, 0]]
        seen = camera.project(np.array(behind))
        assert not seen.valid.any()
        assert np.isnan(seen.pixels).all()


def test_double_reflections_are_invalid():
    """A deep bowl, seen from next to its wall: past its centre light gets out."""
    fisheye = FisheyeCamera("equidistance", 180, (320, 240), W, H)
    T = pose(np.diag([1.0, -1, -1]), [20, 0, 10])
    camera = QuadricMirrorCamera(fisheye, "sphere", (30,), 30, T, side="inside")
    pixels = np.column_stack([320 + 180 * np.radians([-45, 0, 50]), np.full(3, 240)])
    np.testing.assert_array_equal(camera.rays(pixels).valid, [True, False, False])


def test_mirror_hole_has_no_pixels():
    pixels = np.array([[319.5, 239.5], [319.5 + 8 * 1.9, 239.5], [319.5 + 17, 239.5]])
    np.testing.assert_array_equal(
        CENTRAL["paraboloid"].rays(pixels).valid, [False, False, True]
    )
