"""The camera whose mirror is a spline: exact both ways, law of reflection, its box."""

import numpy as np
import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from raxel.cameras import (
    BentMirrorCamera,
    BrownCamera,
    OrthographicCamera,
    SplineMirrorCamera,
    camera_from,
    load_camera,
)
from raxel.cameras.mirrors.spline import SplineMirror
from raxel.errors import InputError
from raxel.geometry.spline_grids import spline_grid
from tests.camera_checks import assert_points_come_back

W, H = 640, 480
K = [[690, 0, 319.5], [0, 690, 239.5], [0, 0, 1]]
VIEWER = BrownCamera(K, [-0.1, 0.02], [0.001, -0.002], W, H)
QUANTITIES = ("distance", "inverse depth")


def bent(heights, degrees=35.0):
    turn = (0, np.radians(degrees), 0)
    return BentMirrorCamera(VIEWER, (400, 300), heights, (0, 0, 280), turn)


BULGE = bent([[0, 0, 4], [0, 3, 0], [16, 0, 0], [4, 0, 0]])


def pixels_of(seed, count=300):
    return np.random.default_rng(seed).uniform([60, 50], [W - 60, H - 50], (count, 2))


def like(camera, quantity, shape=(7, 5), degree=(2, 2), angle=0.2):
    """The spline closest to a mirror over most of the image."""
    seen = VIEWER.rays(pixels_of(1, 4000)).directions
    grid = spline_grid(seen[:, :2] / seen[:, 2:], shape, degree, angle)
    points = camera.rays(pixels_of(2, 4000)).origins
    return SplineMirrorCamera.fitted(VIEWER, grid, points[np.isfinite(points[:, 0])],
                                     quantity)  # fmt: skip


@pytest.mark.parametrize("quantity", QUANTITIES)
@pytest.mark.parametrize("degree", [(2, 2), (3, 4)])
@given(seed=st.integers(0, 2**32 - 1))
@settings(max_examples=2, deadline=None)
def test_points_on_ray_project_to_its_pixel(quantity, degree, seed):
    camera, pixels = like(BULGE, quantity, degree=degree), pixels_of(seed)
    depth = 10 ** np.random.default_rng(seed).uniform(1, 3.5, (len(pixels), 1))
    assert assert_points_come_back(camera, pixels, depth).valid.mean() > 0.95


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_derivatives_of_surface_agree_with_differences_and_its_normals(quantity):
    mirror, step = like(BULGE, quantity, degree=(4, 4)).mirror, 1e-5
    chart = np.random.default_rng(3).uniform(-0.5, 0.5, (40, 2))
    M, first, second = mirror.point(chart)
    for k in range(2):
        up, down = (mirror.point(chart + s * step * np.eye(2)[k]) for s in (1, -1))
        slope = (up[0] - down[0]) / (2 * step)
        np.testing.assert_allclose(first[:, :, k], slope, atol=1e-4)
        slope = (up[1] - down[1]) / (2 * step)
        np.testing.assert_allclose(second[:, :, :, k], slope, atol=1e-3)
    normals = mirror.normals(M)
    normals /= np.linalg.norm(normals, axis=1, keepdims=True)
    assert np.abs(np.einsum("nik,ni->nk", first, normals)).max() < 1e-9
    assert np.all(np.sum(normals * M, axis=1) < 0)
    np.testing.assert_allclose(mirror.chart(M), chart, atol=1e-12)


def test_flat_mirror_is_exact_in_inverse_depth():
    flat, pixels = bent([[0.0]]), pixels_of(4)
    true = flat.rays(pixels)

    def worst(quantity):
        rays = like(flat, quantity).rays(pixels)
        both = rays.valid & true.valid
        return np.abs(rays.directions - true.directions)[both].max()

    assert worst("inverse depth") < 1e-11
    assert 1e-4 < worst("distance") < 0.02


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_spline_mirror_fits_bent_sheet(quantity):
    camera, pixels = like(BULGE, quantity, (14, 9), angle=0), pixels_of(5)
    ours, true = camera.rays(pixels), BULGE.rays(pixels)
    both = ours.valid & true.valid
    assert np.abs(ours.origins - true.origins)[both].max() < 0.02
    assert np.abs(ours.directions - true.directions)[both].max() < 5e-3


def test_no_ray_outside_knots():
    camera = like(BULGE, "distance")
    pixels = np.array([[320, 240], [5, 5], [635, 240], [np.nan, 3], [1e300, 0]])
    rays = camera.rays(pixels)
    np.testing.assert_array_equal(rays.valid, [1, 0, 0, 0, 0])
    assert np.isnan(rays.directions[1:]).all()
    assert not camera.project(np.array([[np.nan, 1, 1], [0, 0, 1e5]])).valid.any()
    assert not camera.central


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_camera_roundtrips_through_file_and_fields(quantity, tmp_path):
    camera = like(BULGE, quantity, (7, 4), (2, 3))
    camera.save(tmp_path / "camera.npz")
    names = ("viewer", "knots_u", "knots_v", "coefficients", "quantity")
    fields = {name: getattr(camera, name) for name in names}
    fields |= {"degree": [2, 3], "angle": camera.grid.angle}
    for again in (
        load_camera(tmp_path / "camera.npz"),
        camera_from(camera.kind, fields),
    ):
        np.testing.assert_array_equal(
            again.rays(pixels_of(7)).directions, camera.rays(pixels_of(7)).directions
        )
        assert again.parameters == camera.parameters == 9 + 28


KNOTS = {"knots_u": [0, 0, 0, 1, 1, 1], "knots_v": [0, 0, 0, 1, 1, 1]}


@pytest.mark.parametrize(
    ("change", "words"),
    [
        ({"degree": (1, 2), "knots_u": [0, 0, 1, 1]}, "field 'degree'"),
        ({"coefficients": np.ones((3, 4))}, "field 'coefficients'"),
        ({"coefficients": -np.ones((3, 3))}, " -1"),
        ({"quantity": "depth"}, "field 'quantity': found 'depth'"),
        ({"knots_v": [0, 0, 1, 1, 1, 1]}, "field 'knots_v'"),
        ({"viewer": OrthographicCamera(2, (0, 0), W, H)}, "field 'viewer'"),
    ],
)
def test_impossible_mirrors_are_rejected(change, words):
    fields = {"viewer": VIEWER, "coefficients": np.full((3, 3), 0.01)} | KNOTS | change
    with pytest.raises(InputError, match=words):
        camera_from("spline mirror", fields)


def test_undetermined_coefficients_are_rejected():
    grid = spline_grid([[0, 0], [0.1, 0.1]], (7, 3))
    points = np.column_stack([np.random.default_rng(0).uniform(0, 5, (50, 2)),
                              np.full(50, 100)])  # fmt: skip
    with pytest.raises(InputError, match=r"50 points .* 6 of 21"):
        SplineMirrorCamera.fitted(VIEWER, grid, points)
    assert SplineMirror(grid, np.ones(21), "distance").radius > 0


@pytest.mark.parametrize("quantity", QUANTITIES)
def test_points_behind_viewer_are_invalid(quantity):
    """Points there have the image position of points in front."""
    rays = BULGE.rays(pixels_of(2, 500))
    points = rays.origins[rays.valid]
    grid = spline_grid(points[:, :2] / points[:, 2:], (4, 4))
    wanted = SplineMirrorCamera.fitted(VIEWER, grid, points, quantity)
    more = np.vstack([points, -3 * points[::7]])
    found = SplineMirrorCamera.fitted(VIEWER, grid, more, quantity)
    np.testing.assert_array_equal(found.coefficients, wanted.coefficients)
