"""A rendered mirror set: complete, readable, and true to the rig."""

from dataclasses import replace

import cv2
import numpy as np
import pytest

from chapters.shared.mirror.rigs import mirror_rig
from raxel.cameras import load_camera
from raxel.features import find_board
from raxel.geometry import transform
from raxel.geometry.planes import on_plane
from raxel.io.files import read_json
from raxel.sets import PatternPlan
from raxel.sets.mirror_set import load_mirror_set
from tests import rendered_mirror_sets
from tests.rendered_mirror_sets import STEP_BOARD, write_mirror_set


@pytest.fixture(scope="module")
def rig():
    """Few patterns: here nothing is decoded."""
    rig = mirror_rig("A", small=True)
    few = PatternPlan(phase_steps=3, phase_periods=(8, 0))
    return replace(rig, monitor=replace(rig.monitor, patterns=few))


@pytest.fixture(scope="module")
def written(rig, tmp_path_factory):
    folder = tmp_path_factory.mktemp("mirror") / "set"
    with pytest.MonkeyPatch.context() as patch:
        patch.setattr(rendered_mirror_sets, "VIEWER_VIEWS", 2)
        write_mirror_set(rig, folder, 3, (0.0, 5.0), holder_mm=3.0)
    return load_mirror_set(folder)


def test_mirror_set_describes_its_steps(written):
    assert written.size == (768, 576)
    (step,) = written.steps
    assert step.deflection_mm == 5.0
    assert written.clamp.hidden_mm == 3.0
    assert [view.label for view in written.grids.views] == ["near", "far"]
    assert len(written.plate.views) == 2


def test_clamp_points_lie_on_the_first_visible_line(rig, written):
    camera = load_camera(written.folder / "truth" / "stage-0.npz")
    line = rig.clamp_pixels(camera, 5)
    gap = np.linalg.norm(np.array(written.clamp.points) - line, axis=1)
    assert 0 < gap.max() < 2


def test_boards_are_detected_at_their_true_positions(written):
    poses = read_json(written.folder / "truth" / "poses.json")["T_camera_target"]
    (step,) = written.steps
    size = STEP_BOARD.columns, STEP_BOARD.rows
    for name, stage in ((step.before, 0), (step.after, 1)):
        camera = load_camera(written.folder / "truth" / f"stage-{stage}.npz")
        points = transform(np.array(poses[name]), on_plane(STEP_BOARD.points()))
        true = camera.project(points).pixels
        image = cv2.imread(str(written.stages.folder / name), cv2.IMREAD_GRAYSCALE)
        found = find_board(image, *size)
        assert found.found
        gap = np.linalg.norm(found.corners[:, None] - true, axis=2).min(axis=1)
        assert np.median(gap) < 0.05
    plate = written.plate
    for view in plate.views:
        image = cv2.imread(str(plate.folder / view.image), cv2.IMREAD_GRAYSCALE)
        assert find_board(image, plate.target.columns, plate.target.rows).found
