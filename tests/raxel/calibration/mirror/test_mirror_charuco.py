"""A ChArUco board larger than the mirror shows: a part of it is enough."""

from types import SimpleNamespace

import numpy as np
import pytest

from chapters.shared.mirror.rigs import DYNAMIC_MM, mirror_rig
from raxel.calibration.mirror.images import _steps
from raxel.geometry import on_plane, pose, transform
from raxel.lab import ImageTexture, Laboratory, Rectangle, TexturedScene
from raxel.lab.set_rendering import write_image
from raxel.sets import Charuco, ImageSet, View
from raxel.sets.mirror_set import MirrorStep
from tests.charuco_boards import SQUARE_PX, sheet

BOARD = Charuco(24, 20, 16.0, "4X4_1000", 12.0)
NAMES = ("before.png", "after.png")


@pytest.fixture(scope="module")
def rig():
    return mirror_rig("A", small=True)


@pytest.fixture(scope="module")
def cameras(rig):
    return [rig.camera(deflection) for deflection in (0.0, 5.0)]


@pytest.fixture(scope="module")
def T_camera_board(rig):
    """The board's middle where the mirror's middle looks, facing it."""
    held = rig.board_pose(np.random.default_rng(2), DYNAMIC_MM, (0.0, 5.0))
    middle = np.ptp(rig.board.points(), axis=0) / 2 - np.ptp(BOARD.points(), axis=0) / 2
    return held @ pose(np.eye(3), [*middle, 0])


@pytest.fixture(scope="module")
def stages(rig, cameras, T_camera_board, tmp_path_factory):
    """An ImageSet of one step, rendered."""
    folder = tmp_path_factory.mktemp("stages")
    print_, mm_per_px = 0.9 * sheet(BOARD) / 255, BOARD.pitch_mm / SQUARE_PX
    height, width = mm_per_px * np.array(print_.shape)
    corner = np.full(2, -2 * BOARD.pitch_mm)
    at = T_camera_board @ pose(np.eye(3), [*corner, 0])
    paper = Rectangle(at, width, height), ImageTexture(print_, mm_per_px)
    for seed, (name, camera) in enumerate(zip(NAMES, cameras, strict=True)):
        laboratory = Laboratory(camera, rig.rig.sensor, rig.rig.optics)
        rng = np.random.default_rng(seed)
        scene = TexturedScene((paper,))
        write_image(folder / name, laboratory.render(scene, np.eye(4), rng))
    views = tuple(View(image=name) for name in NAMES)
    size = rig.viewer.width, rig.viewer.height
    return ImageSet("stages", *size, BOARD, views, folder)


def test_partial_charuco_board_keeps_corner_numbers(stages, cameras, T_camera_board):
    """Seen from behind, as in a mirror: columns count the other way, in both."""
    steps = (MirrorStep(*NAMES, deflection_mm=5.0),)
    (step,), flags = _steps(SimpleNamespace(stages=stages, steps=steps), None)
    assert flags == ()
    assert step.deflection_mm == 5.0
    points = transform(T_camera_board, on_plane(BOARD.points()))
    reversed_ = np.arange(len(points)).reshape(BOARD.rows, BOARD.columns)[:, ::-1]
    for view, camera in zip((step.before, step.after), cameras, strict=True):
        seen = np.isfinite(view.pixels[:, 0])
        assert 60 < seen.sum() < 0.7 * len(points)
        true = camera.project(points[reversed_.ravel()]).pixels
        gap = np.linalg.norm(view.pixels - true, axis=1)[seen]
        assert np.median(gap) < 0.1
        assert gap.max() < 1.0
