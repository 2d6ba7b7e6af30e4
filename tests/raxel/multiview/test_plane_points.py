"""Points of a plane seen by pixels: exact, and as accurate as an image of a ring."""

import numpy as np
import pytest

from raxel.cameras import PerspectiveCamera
from raxel.errors import InputError
from raxel.features.edge_profiles import edge_points
from raxel.geometry import pose, rotation_from_vector
from raxel.lab.objects import BoardRing, RingedChessboard, ringed_board_scene
from raxel.lab.rendering import render
from raxel.lab.textures import ChessboardTexture
from raxel.multiview.fits.conics import fit_conic
from raxel.multiview.plane_points import (
    _moved_by_pose,
    circle_outline,
    measured_circle,
    plane_image,
    points_on_plane,
)
from raxel.sets import Chessboard
from tests.mirror_scenes import BOARD, VIEWER, board_pose, flexible_camera, posed, small

CENTRE = BOARD.mean(axis=0)
RING = BoardRing(tuple(CENTRE), 87.21, line=12.0, margin=9.0)
T_BOARD = board_pose([3, 4, 2], (-60, 0, -20))
CAMERA = flexible_camera(15.0)
SMALL = flexible_camera(15.0, viewer=small(12))


def test_circle_in_bent_mirror_is_exact():
    pixels, _, _ = circle_outline(CAMERA, T_BOARD, CENTRE, 87.21, 90)
    seen = np.isfinite(pixels).all(axis=1)
    assert seen.mean() > 0.5
    found = measured_circle(CAMERA, pixels, T_BOARD)
    np.testing.assert_array_equal(found.used, seen)
    assert abs(found.fit.radius - 87.21) < 1e-6
    np.testing.assert_allclose(found.fit.centre, CENTRE, atol=1e-6)
    # In the image it is not a conic.
    assert np.abs(fit_conic(pixels[seen]).residuals).max() > 1


def test_circle_in_flat_mirror_is_conic():
    viewer = PerspectiveCamera(VIEWER.K, [], VIEWER.width, VIEWER.height)
    camera = flexible_camera(0.0, viewer=viewer)
    pixels, _, _ = circle_outline(camera, T_BOARD, CENTRE, 87.21, 90)
    fit = fit_conic(pixels[np.isfinite(pixels).all(axis=1)])
    assert np.abs(fit.residuals).max() < 1e-6


def test_plane_points_pixel_derivatives():
    pixels, normals, scale = circle_outline(CAMERA, T_BOARD, CENTRE, 87.21, 24)
    kept = np.isfinite(scale)
    pixels, normals, scale = pixels[kept], normals[kept], scale[kept]
    found = points_on_plane(CAMERA, pixels, T_BOARD)
    ahead = points_on_plane(CAMERA, pixels + 0.1 * normals, T_BOARD).points
    moved = np.einsum("nij,nj->ni", found.per_px, 0.1 * normals)
    np.testing.assert_allclose(ahead - found.points, moved, atol=1e-5)
    # A step of 0.1 px across the outline leaves the circle by as much as scale says.
    apart = np.linalg.norm(ahead - CENTRE, axis=1) - 87.21
    np.testing.assert_allclose(apart * scale, 0.1, rtol=1e-2)
    outside = points_on_plane(CAMERA, np.array([[0.0, 0.0], [np.nan, 5]]), T_BOARD)
    assert not outside.valid.any()
    assert np.isnan(outside.points).all()


def test_plane_points_pose_derivatives():
    pixels, _, scale = circle_outline(CAMERA, T_BOARD, CENTRE, 87.21, 24)
    pixels = pixels[np.isfinite(scale)]
    directions = CAMERA.rays(pixels).directions @ T_BOARD[:3, :3]
    points = points_on_plane(CAMERA, pixels, T_BOARD).points
    by_pose = _moved_by_pose(points, directions)
    for k, step in enumerate(1e-5 * np.eye(6)):
        T = T_BOARD @ pose(rotation_from_vector(step[:3]), step[3:])
        slope = (points_on_plane(CAMERA, pixels, T).points - points) / 1e-5
        np.testing.assert_allclose(by_pose[:, :, k], slope, rtol=1e-3, atol=1e-2)


def test_circle_covariance_includes_pose():
    pixels, _, scale = circle_outline(CAMERA, T_BOARD, CENTRE, 87.21, 40)
    pixels = pixels[np.isfinite(scale)]
    h = 1e-5
    for step in np.eye(6):
        T = [
            T_BOARD @ pose(rotation_from_vector(s[:3]), s[3:])
            for s in (h * step, -h * step)
        ]
        one, other = (measured_circle(CAMERA, pixels, moved, 1e-9).fit for moved in T)
        change = np.append(one.centre - other.centre, one.radius - other.radius) / (
            2 * h
        )
        sure = measured_circle(CAMERA, pixels, T_BOARD, 1e-9).fit.covariance
        given = measured_circle(CAMERA, pixels, T_BOARD, 1e-9, np.diag(step)).fit
        expected = np.outer(change, change)
        np.testing.assert_allclose(
            given.covariance - sure, expected, atol=1e-3 * np.abs(expected).max()
        )


def test_circle_uncertainty_ignores_plane_axes():
    pinhole = PerspectiveCamera(
        [[900, 0, 320.0], [0, 700, 240], [0, 0, 1]], [], 640, 480
    )
    T = posed([35, -50, 5], [-20, 10, 500])
    found = []
    for turn in (0.0, 0.4, 1.0):
        turned = T @ pose(rotation_from_vector([0, 0, turn]), np.zeros(3))
        pixels, _, _ = circle_outline(pinhole, turned, (0.0, 0.0), 60.0, 90)
        assert np.isfinite(pixels).all()
        found.append(measured_circle(pinhole, pixels, turned, 0.2).fit.covariance)
    for one in found[1:]:
        assert one[2, 2] == pytest.approx(found[0][2, 2], rel=1e-3)
        assert np.trace(one) == pytest.approx(np.trace(found[0]), rel=1e-3)


def test_circle_radius_sd_predicts_error():
    rng = np.random.default_rng(11)
    pixels, _, scale = circle_outline(CAMERA, T_BOARD, CENTRE, 87.21, 40)
    pixels = pixels[np.isfinite(scale)]
    deviations = np.array([2e-4, 2e-4, 1e-4, 0.05, 0.05, 0.02])
    squares = []
    for _ in range(60):
        w, s = np.split(deviations * rng.normal(size=6), 2)
        T = T_BOARD @ pose(rotation_from_vector(w), s)
        edge = pixels + 0.2 * rng.normal(size=pixels.shape)
        found = measured_circle(CAMERA, edge, T, 0.2, np.diag(deviations**2)).fit
        error = np.array([*(found.centre - CENTRE), found.radius - 87.21])
        squares.append(error @ np.linalg.solve(found.covariance, error) / 3)
    assert np.mean(squares) == pytest.approx(1, abs=4 * np.sqrt(2 / 3 / 60))


@pytest.fixture(scope="module")
def ring_image():
    scene = ringed_board_scene(Chessboard(14, 13, 18.0), RING, T_BOARD)
    return render(SMALL, np.eye(4), scene)


def test_ring_is_measured_to_subpixel_accuracy(ring_image):
    radii = []
    for radius in RING.edges:
        places, normals, scale = circle_outline(SMALL, T_BOARD, CENTRE, radius, 120)
        half = np.nan_to_num(0.8 * RING.margin * scale, nan=2.0)
        edges = edge_points(ring_image, places, normals, np.maximum(half, 1.5))
        assert edges.found.mean() > 0.5
        found = measured_circle(SMALL, edges.pixels, T_BOARD, edges.sigma)
        px = 1 / np.nanmedian(scale)
        assert np.median(np.abs(found.fit.residuals)) < 0.02 * px
        radii.append(found.fit.radius)
    # A pixel is some 1.5 mm.
    np.testing.assert_allclose(radii, RING.edges, atol=0.03)
    assert np.mean(radii) == pytest.approx(87.21, abs=0.01)


def test_plane_image_shows_board(ring_image):
    size, per_px = np.array([120.0, 150.0]), 1.0
    corner = CENTRE - size / 2
    result, seen = plane_image(SMALL, ring_image, T_BOARD, corner, size, per_px)
    assert result.shape == (150, 120)
    assert seen.mean() > 0.6
    v, u = np.nonzero(seen)
    places = corner + per_px * (np.column_stack([u, v]) + 0.5)
    texture = RingedChessboard(ChessboardTexture(14, 13, 18.0, 18.0), RING)
    truth = texture.radiance(places, None)
    # Far from lines the board's own greys, which edges would betray a shift of.
    close = np.abs(result[v, u] - truth) < 0.02
    assert close.mean() > 0.7
    edge = (np.abs((places + 4) % 18 - 4) < 3).any(axis=1)
    apart = np.linalg.norm(places - CENTRE, axis=1)
    edge |= np.abs(apart[:, None] - texture.radii).min(axis=1) < 3
    assert close[~edge].mean() > 0.99


def test_plane_image_rejects_other_size(ring_image):
    with pytest.raises(InputError, match=r"256 x 100 px; .* 256 x 192"):
        plane_image(SMALL, ring_image[:100], T_BOARD, CENTRE, (9, 9), 1.0)


def test_footprint_mean_equals_image_mean():
    rng = np.random.default_rng(6)
    texture = RingedChessboard(ChessboardTexture(14, 13, 18.0, 18.0), RING)
    uv = rng.uniform(-20, 250, (4000, 2))
    across, down = rng.uniform(-0.8, 0.8, (2, 4000, 2))
    means = texture.average(uv, across, down, None)
    steps = (np.arange(12) + 0.5) / 12 - 0.5
    places = [uv + a * across + b * down for a in steps for b in steps]
    truth = np.mean([texture.radiance(place, None) for place in places], axis=0)
    known = np.isfinite(means)
    assert known.mean() > 0.95
    # 144 places tell an edge's share to some hundredths.
    np.testing.assert_allclose(means[known], truth[known], atol=0.06)
    on_edge = np.ptp([texture.radiance(p, None) for p in places], axis=0) > 0
    assert np.count_nonzero(known & on_edge) > 50


def test_ring_outside_plane_is_rejected():
    board = ChessboardTexture(14, 13, 18.0, 9.0)
    for ring in (BoardRing((0, 0), 4.0, 4.0, 3.0), BoardRing((0, 0), 40.0, 0.0)):
        with pytest.raises(InputError, match="radius"):
            RingedChessboard(board, ring)


def test_ring_keeps_colours():
    board = ChessboardTexture(4, 3, 18.0, 9.0, (0.1, 0.0, 0.0), (0.9, 0.8, 0.7))
    texture = RingedChessboard(board, BoardRing((30.0, 20.0), 15.0, 2.0, 2.0))
    uv = np.array([[45.0, 20.0], [47, 20], [30, 20]])
    small_side = np.full((3, 2), 0.01)
    found = texture.average(uv, small_side * [1, 0], small_side * [0, 1], None)
    truth = texture.radiance(uv, None)
    np.testing.assert_allclose(found, truth, atol=1e-6)
    np.testing.assert_allclose(truth[0], [0.1, 0, 0], atol=1e-6)
