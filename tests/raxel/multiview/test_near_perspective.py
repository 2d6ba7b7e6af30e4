"""Near-perspective views: exact where the guess of the scene is, better elsewhere."""

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.s3_4_distortion.scenes import Bust
from raxel.cameras.core.base import closest_point
from raxel.errors import InputError
from raxel.evaluation.distortion import distortion_residual
from raxel.geometry import intersect_rays_plane, inverse_pose, on_plane, pose, transform
from raxel.multiview.plane_points import (
    facing_plane,
    shown_in_view,
    view_of_plane,
    view_over_plane,
    view_pixels,
)
from tests.mirror_scenes import BOARD, board_pose, flexible_camera, posed, small

CAMERA = flexible_camera(12.0)
SMALL = flexible_camera(12.0, viewer=small(12))
# A relief of a twentieth of its distance from the mirror.
BUST = Bust(130.0, 20.0)
# A 180-degree rotation turns its face to the mirror.
T_BUST = (
    board_pose([3, 4, 2], (-120, 0, -40))
    @ pose(np.eye(3), [*BOARD.mean(axis=0), 0.0])
    @ posed([0, 180, 0], [0, 0, 0])
)
CORNER, SIZE = -np.array(BUST.size) / 2, np.array(BUST.size)


def rms(residual):
    return np.sqrt(np.mean(np.sum(np.square(residual), axis=-1)))


@pytest.fixture(scope="module")
def view():
    return view_of_plane(SMALL, T_BUST, 1.0, CORNER, SIZE)


def test_plane_view_contains_part_at_scale(view):
    ring = CORNER + SIZE * np.array([[0, 0], [1, 0], [1, 1], [0, 1]])
    places = view_pixels(view, transform(T_BUST, on_plane(ring)))
    assert (places >= 0).all()
    assert (places <= [view.width - 1, view.height - 1]).all()
    sides = np.diff(places, axis=0)
    assert sides[0, 0] > 0.7 * SIZE[0]
    assert sides[1, 1] > 0.7 * SIZE[1]
    middle = transform(T_BUST, np.array([[-0.5, 0, 0], [0.5, 0, 0], [0, 0.5, 0]]))
    step = view_pixels(view, middle)
    assert np.hypot(*(step[1] - step[0])) == pytest.approx(1, abs=0.15)
    R = view.R_camera_view
    np.testing.assert_allclose(R.T @ R, np.eye(3), atol=1e-12)
    behind = view.centre - R[:, 2]
    assert np.isnan(view_pixels(view, behind[None])).all()


def test_plane_view_centre_uses_chosen_part(view):
    pixels = np.mgrid[: SMALL.width : 4, : SMALL.height : 4].reshape(2, -1).T
    rays = SMALL.rays(pixels.astype(float))
    met = intersect_rays_plane(rays.origins, rays.directions, T_BUST)
    inside = (np.abs(met.points) < SIZE / 2).all(axis=1) & met.valid & rays.valid
    near = closest_point(rays._replace(valid=inside))
    assert np.linalg.norm(view.centre - near) < 1
    assert np.linalg.norm(closest_point(rays) - near) > 3


def test_plane_view_is_perspective_on_plane(view):
    rng = np.random.default_rng(3)
    points = transform(T_BUST, on_plane(CORNER + SIZE * rng.uniform(0, 1, (60, 2))))
    pixels, valid = SMALL.project(points)
    shown = shown_in_view(SMALL, view, pixels[valid], T_BUST)
    np.testing.assert_allclose(shown, view_pixels(view, points[valid]), atol=1e-6)
    assert valid.mean() > 0.5


def test_plane_view_reduces_relief_distortion():
    points = transform(T_BUST, BUST.landmarks()[1])
    pixels, valid = CAMERA.project(points)
    points, pixels = points[valid], pixels[valid]
    assert len(points) > 15
    plane = facing_plane(T_BUST, closest_point(CAMERA.rays(pixels)), 0.3 * BUST.relief)
    off = transform(inverse_pose(T_BUST), plane[None, :3, 3])[0]
    np.testing.assert_allclose(off, [0, 0, -0.3 * BUST.relief], atol=1e-9)
    view = view_of_plane(CAMERA, plane, 0.1, CORNER, SIZE)
    truth = view_pixels(view, points)
    near = shown_in_view(CAMERA, view, pixels, plane)
    # The same homography's freedom for both; scales are alike.
    raw = rms(distortion_residual(pixels, truth)) / np.ptp(pixels)
    left = rms(distortion_residual(near, truth)) / np.ptp(near)
    assert left < 0.2 * raw


def test_view_over_plane_maps_pixels_to_themselves(view):
    pixels = np.mgrid[: SMALL.height, : SMALL.width][::-1].reshape(2, -1).T
    own = shown_in_view(SMALL, view, pixels.astype(float), T_BUST)
    image = np.nan_to_num(own).reshape(SMALL.height, SMALL.width, 2)
    result, seen = view_over_plane(SMALL, image, view, T_BUST)
    v, u = np.nonzero(seen)
    inside = (u > 2) & (v > 2) & (u < view.width - 3) & (v < view.height - 3)
    v, u = v[inside], u[inside]
    assert len(u) > 0.5 * seen.size
    np.testing.assert_allclose(result[v, u], np.column_stack([u, v]), atol=0.02)


def test_unseen_plane_is_rejected(view):
    with pytest.raises(InputError, match="near-perspective view"):
        view_of_plane(SMALL, T_BUST, 1.0, np.array([900.0, 900]), SIZE)
