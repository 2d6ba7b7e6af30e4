"""Extrapolated rays outside the boards: their uncertainty, and when it is reported."""

import numpy as np
import pytest

from raxel.calibration import BoardView, calibrate_zhang
from raxel.cameras import PerspectiveCamera
from raxel.evaluation.coverage import BeyondBoards, beyond_boards
from raxel.evaluation.cross_validation import evaluate_camera
from raxel.evaluation.misfit import CorrectionFields
from raxel.evaluation.split_half import split_half
from raxel.geometry import on_plane, pose, rotation_from_vector, transform

SIZE = np.array([640, 480])
MIDDLE = (SIZE - 1) / 2
CAMERA = PerspectiveCamera(
    [[500.0, 0, 322.0], [0, 500.0, 236.0], [0, 0, 1]], [-0.1, 0.02], *SIZE
)
POINTS = 20.0 * np.stack(np.meshgrid(np.arange(9.0), np.arange(7.0)), -1).reshape(-1, 2)


def views_within(share, count=12, noise=0.1, camera=CAMERA):
    """Boards whose corners lie in the middle `share` of the image each way."""
    rng = np.random.default_rng(4)
    half, views = share * SIZE / 2, []
    while len(views) < count:
        R = rotation_from_vector(rng.uniform(-0.5, 0.5, 3))
        sight = camera.rays(rng.uniform(MIDDLE - half, MIDDLE + half)[None]).directions
        t = rng.uniform(300, 500) / share * sight[0]
        points = transform(pose(R, t - R @ [80.0, 60.0, 0.0]), on_plane(POINTS))
        pixels = camera.project(points).pixels
        if np.all(np.abs(pixels - MIDDLE) <= half):
            pixels = pixels + noise * rng.normal(size=pixels.shape)
            views.append(BoardView(pixels, POINTS, 9, 7, f"{len(views)}.png"))
    return views


def found_in(views):
    camera = calibrate_zhang(views, *SIZE).camera
    return split_half(camera, evaluate_camera(camera, views).images, views).beyond


def test_uncertainty_outside_boards_of_a_growing_field():
    """Of one shape, by (u, 0) / 100 px, with SD 0.5: a ray at u is known to u / 200."""
    u = np.arange(0.0, 1000.0, 10.0)
    pixels = np.column_stack([u, np.full(100, 5.0)])
    shapes = np.zeros((100, 2, 1))
    shapes[:, 0, 0] = u / 100
    fields = CorrectionFields(pixels, shapes, np.zeros((100, 2, 3)), np.eye(1))
    corners = np.array([[0.0, 0], [195.0, 0], [195.0, 10], [0.0, 10], [np.nan, np.nan]])
    views = [BoardView(corners, corners, 5, 1)]
    seen = u < 195
    own = np.full(100, np.nan)
    found = beyond_boards(fields, np.array([[0.25]]), views, seen, own)
    under = np.sqrt(np.mean((u[seen] / 200) ** 2))
    assert 2 * under > 1
    unknown = np.mean(u / 200 > 2 * under)
    assert found == pytest.approx(BeyondBoards(0.8, unknown, 990 / 200, under))
    found = beyond_boards(fields, np.array([[0.0025]]), views, seen, own)
    assert found == pytest.approx(BeyondBoards(0.8, 0.0, 99 / 200, under / 10))
    assert beyond_boards(fields, np.eye(1), views, np.zeros(100, bool), own) is None


def test_only_central_boards_give_a_large_unknown_area():
    middle, all_over = found_in(views_within(0.5)), found_in(views_within(1.0))
    assert middle.matters
    assert middle.share > 0.75  # half of either side is a quarter
    assert not all_over.matters
    assert all_over.share < 0.4
    assert middle.largest_px > 3 * all_over.largest_px


def test_unmodelled_radial_terms_give_a_large_unknown_area():
    """The residuals are noise, and rays in the corners have errors of some px."""
    webcam = PerspectiveCamera(
        [[520.0, 0, 322.0], [0, 520.0, 236.0], [0, 0, 1]], [-0.3, 0.14, -0.04], *SIZE
    )
    views = views_within(0.8, camera=webcam)
    found = calibrate_zhang(views, *SIZE).camera
    scores = evaluate_camera(found, views)
    assert scores.rms_px < 1.5 * 0.1 * 2**0.5
    corner = np.array([[0.0, 0.0]])
    off = webcam.project(found.rays(corner).directions).pixels - corner
    assert np.linalg.norm(off) > 3
    beyond = split_half(found, scores.images, views).beyond
    assert beyond.matters
    assert beyond.largest_px > 3
