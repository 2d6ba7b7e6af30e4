"""A ray field on a trend: its spline, its inverse, its region, its uncertainty."""

import numpy as np
import pytest
from scipy.interpolate import BSpline

from raxel.cameras import (
    FisheyeCamera,
    KannalaBrandtCamera,
    MovingPupilCamera,
    RaySplineCamera,
    load_camera,
)
from raxel.cameras.tables.interpolation import (
    control_shape,
    field_at,
    shares,
    steepest,
    undisplaced,
)
from raxel.geometry.poses import pose, rotation_from_vector
from tests.camera_checks import assert_same_from_file
from tests.raised import raises_line

W, H, SPACING = 200, 150, 30.0
SHAPE = control_shape(W, H, SPACING)
TREND = FisheyeCamera("equidistance", 70, (99, 76), W, H)
CONTROL = np.random.default_rng(4).uniform(-2, 2, (*SHAPE, 2))


def spline(control=CONTROL, **more):
    return RaySplineCamera(TREND, SPACING, control, W, H, **more)


def positions(count, margin=0.0, seed=5):
    rng = np.random.default_rng(seed)
    low, high = -0.5 - margin, np.array([W, H]) - 0.5 + margin
    return rng.uniform(low, high, (count, 2))


def test_field_is_tensor_product_of_cubics():
    pixels = positions(500)
    found, _ = field_at(pixels, CONTROL, SPACING)
    # Knots in px: three cells before the image's corner and three after the last.
    knots = [SPACING * np.arange(-3, n + 1) - 0.5 for n in SHAPE]
    down = BSpline.design_matrix(pixels[:, 1], knots[0], 3).toarray()
    along = BSpline.design_matrix(pixels[:, 0], knots[1], 3).toarray()
    expected = np.einsum("nr,nc,rcx->nx", down, along, CONTROL)
    np.testing.assert_allclose(found, expected, atol=1e-13)


def test_field_weights_reproduce_field():
    pixels = positions(2000, margin=150)
    index, share = shares(pixels, SHAPE, SPACING)
    found, _ = field_at(pixels, CONTROL, SPACING)
    given = np.sum(share[..., None] * CONTROL.reshape(-1, 2)[index], axis=1)
    np.testing.assert_allclose(given, found, atol=1e-13)
    inside = np.all((pixels > -0.5) & (pixels < [W - 0.5, H - 0.5]), axis=1)
    np.testing.assert_allclose(share[inside].sum(axis=1), 1)


def test_steep_field_is_inverted():
    control = CONTROL * (0.89 / steepest(CONTROL, SPACING))
    pixels = positions(5000, margin=200)
    back = undisplaced(pixels + field_at(pixels, control, SPACING)[0], control, SPACING)
    np.testing.assert_allclose(back, pixels, atol=1e-11)
    assert np.isnan(undisplaced(np.full((1, 2), np.nan), control, SPACING)).all()


def test_ray_spline_keeps_pupil_shift(tmp_path):
    lens = KannalaBrandtCamera([1, -0.03], (120, 120), (W / 2, H / 2), W, H)
    moving = MovingPupilCamera(lens, [6.0])
    RaySplineCamera(moving, SPACING, CONTROL, W, H).save(tmp_path / "camera.npz")
    camera = load_camera(tmp_path / "camera.npz")
    assert not camera.central
    pixels = np.mgrid[5:W:40, 5:H:40].reshape(2, -1).T.astype(float)
    rays = camera.rays(pixels)
    assert np.ptp(rays.origins[:, 2]) > 1
    again = camera.project(rays.origins + 80 * rays.directions)
    np.testing.assert_allclose(again.pixels, pixels, atol=1e-9)


def test_ray_spline_pose_moves_rays():
    T = pose(rotation_from_vector([0.1, -0.2, 2.0]), [3.0, 4.0, -5.0])
    moved, plain = spline(T_camera_trend=T), spline()
    pixels = positions(300)
    rays, still = moved.rays(pixels), plain.rays(pixels)
    np.testing.assert_allclose(rays.origins, [T[:3, 3]] * 300)
    expected = still.directions @ T[:3, :3].T
    np.testing.assert_allclose(rays.directions, expected, atol=1e-14)
    back = moved.project(rays.origins + 700 * rays.directions)
    np.testing.assert_allclose(back.pixels, pixels, atol=1e-10)


def test_uncertainty_is_per_cell():
    cells = SHAPE[0] - 3, SHAPE[1] - 3
    covered = np.zeros(cells, bool)
    covered[1, 2] = True
    nodes = 2 * cells[0] + 1, 2 * cells[1] + 1
    v, u = np.mgrid[: nodes[0], : nodes[1]] * SPACING / 2 - 0.5
    # Linear over the image, which bilinear interpolation keeps.
    covariance = np.stack([2 + u / 100, 0.1 + v / 1000, 3 + v / 50], axis=2)
    camera = spline(covered=covered, covariance=covariance)
    pixels = positions(400)
    within = np.all((pixels >= [59.5, 29.5]) & (pixels < [89.5, 59.5]), axis=1)
    np.testing.assert_array_equal(camera.covers(pixels), within)
    assert not camera.covers(np.array([[-1, 5], [5, H], [np.nan, 5]])).any()
    found = camera.pixel_covariance(pixels)
    np.testing.assert_allclose(found[:, 0, 0], 2 + pixels[:, 0] / 100)
    np.testing.assert_allclose(found[:, 1, 0], 0.1 + pixels[:, 1] / 1000)
    assert np.isnan(camera.pixel_covariance(np.array([[-1.0, 5]]))).all()
    assert np.isnan(spline().pixel_covariance(pixels)).all()


def test_ray_spline_file_roundtrip(tmp_path):
    cells = SHAPE[0] - 3, SHAPE[1] - 3
    covered = np.random.default_rng(7).random(cells) > 0.5
    covariance = np.ones((2 * cells[0] + 1, 2 * cells[1] + 1, 3))
    T = pose(rotation_from_vector([0.1, 0, 0]), [1.0, 2, 3])
    camera = spline(covered=covered, covariance=covariance, T_camera_trend=T)
    again = assert_same_from_file(camera, positions(50), tmp_path)
    for name in ("control", "covered", "covariance", "T_camera_trend", "spacing_px"):
        np.testing.assert_array_equal(getattr(again, name), getattr(camera, name))


BAD = {
    "trend": ({"trend": 5}, "'trend': .*int"),
    "spacing": ({"spacing_px": 0.5}, "'spacing_px'"),
    "control": ({"control": np.zeros((3, 3, 2))}, r"'control': .*\(3, 3, 2\)"),
    "fold": ({"control": 40 * CONTROL}, "'control'"),
    "covered": ({"covered": np.ones((2, 2), bool)}, "'covered'"),
    "covariance": ({"covariance": np.ones((2, 2, 3))}, "'covariance'"),
    "pose": ({"T_camera_trend": 2 * np.eye(4)}, "'T_camera_trend'"),
}


@pytest.mark.parametrize("name", BAD)
def test_ray_spline_error_names_field(name):
    change, message = BAD[name]
    fields = {"trend": TREND, "spacing_px": SPACING, "control": CONTROL}
    with raises_line(message):
        RaySplineCamera(**fields | {"width": W, "height": H} | change)


def test_steepness_bound_is_valid():
    """Four slopes of 0.4 px per px along both axes; at their foot the field is zero."""
    v, u = np.mgrid[:13, :13] - 6.0
    height = 0.4 * SPACING * np.maximum(5 - np.abs(u) - np.abs(v), 0)
    control = np.stack([height, 0 * height], axis=2)
    assert steepest(control, SPACING) == pytest.approx(0.4 * np.sqrt(2))
    _, slopes = field_at(np.array([[6.0, 6]]) * SPACING, control, SPACING)
    assert np.linalg.norm(slopes[0], ord=2) == pytest.approx(0.4 * np.sqrt(2))
