"""Tilts of boards determine the focal length, or nothing does, whatever the model."""

import numpy as np
import pytest

from raxel.calibration import BoardView, calibrate_zhang
from raxel.calibration.parametric.lens_bundle import adjusted, stacked
from raxel.calibration.parametric.lens_formula import PINHOLE
from raxel.cameras import KannalaBrandtCamera, PerspectiveCamera
from raxel.evaluation import evaluate_camera
from raxel.evaluation.focal_length import focal_length_sd, focal_length_warnings
from raxel.geometry import on_plane, pose, rotation_from_vector, transform
from raxel.sets.model import BOARDS
from tests.lens_scenes import BOARD, COLUMNS, ROWS
from tests.raised import raises_code

K = np.array([[600.0, 0, 322], [0, 600, 237], [0, 0, 1]])
VALUES = np.array([600.0, 600, 322, 237, 0, 0])
TRUE = PerspectiveCamera(K, [], 640, 480)
NOISE_PX = 0.1


def turned(n, common_deg, tilt_deg):
    """Rotations (n, 3, 3): all by the one angle, then each by the other elsewhere."""
    rng = np.random.default_rng(4)
    spins, ways = rng.uniform(-0.6, 0.6, n), rng.uniform(0, 2 * np.pi, n)
    tilts = np.radians(tilt_deg) * np.stack([np.cos(ways), np.sin(ways), 0 * ways], 1)
    common = rotation_from_vector(np.radians([common_deg, common_deg / 2, 0.0]))
    spins = rotation_from_vector(spins[:, None] * [[0, 0, 1.0]])
    return rotation_from_vector(tilts) @ common @ spins


def views_of(rotations, camera=TRUE, middles=None, noise=NOISE_PX):
    """BoardViews of boards with their middles at points (n, 3)."""
    rng = np.random.default_rng(5)
    if middles is None:
        middles = rng.uniform([-60, -45, 300], [60, 45, 500], (len(rotations), 3))
    views, solid = [], on_plane(BOARD)
    for k, (R, middle) in enumerate(zip(rotations, middles, strict=True)):
        points = transform(pose(R, middle - R @ solid.mean(axis=0)), solid)
        pixels = camera.project(points).pixels
        pixels = pixels + noise * rng.normal(size=pixels.shape)
        views.append(BoardView(pixels, BOARD, COLUMNS, ROWS, f"{k}.png"))
    return views


def sd_of(camera, views):
    images = evaluate_camera(camera, views).images
    return focal_length_sd(camera, images, views, None, np.sqrt(2) * NOISE_PX)


@pytest.mark.parametrize("common_deg", [0, 25])
def test_parallel_boards_are_rejected(common_deg):
    views = views_of(turned(5, common_deg, 0))
    sd = sd_of(calibrate_zhang(views, 640, 480).camera, views)
    with raises_code("focal-undetermined"):
        list(focal_length_warnings(sd, BOARDS))


def test_sd_of_hardly_tilted_boards_is_that_of_focal_lengths():
    sd = sd_of(TRUE, views_of(turned(10, 0, 3)))
    views = views_of(turned(10, 0, 3), noise=0.0)
    (found,) = focal_length_warnings(sd, BOARDS)
    assert "20 to 45 degrees" in found.what_to_do
    poses = np.array([i.T_camera_grid for i in evaluate_camera(TRUE, views).images])
    boards = stacked([(view.pixels, view.points) for view in views])
    rng, errors = np.random.default_rng(6), []
    for _ in range(40):
        pixels = boards.pixels + NOISE_PX * rng.normal(size=boards.pixels.shape)
        noisy = boards._replace(pixels=pixels)
        errors.append(adjusted(PINHOLE, VALUES, poses, noisy, "tukey").values[0] - 600)
    assert 0.8 < 600 * sd / np.sqrt(np.mean(np.square(errors))) < 1.25


def test_boards_that_face_a_fisheye_determine_its_focal_length():
    fisheye = KannalaBrandtCamera([1.0, -0.02], (180, 180), (322, 237), 640, 480)
    ways = [[0, 0, 0], [1, 0, 0], [-1, 0, 0], [0, 1, 0], [0, -1, 0], [1, 1, 0]]
    rotations = rotation_from_vector(np.radians(45) * np.array(ways))
    views = views_of(rotations, fisheye, 150 * rotations[:, :, 2])
    assert not list(focal_length_warnings(sd_of(fisheye, views), BOARDS))
