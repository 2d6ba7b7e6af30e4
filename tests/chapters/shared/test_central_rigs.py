"""The rigs of chapter 4: one camera in several files, and what its mount does."""

import numpy as np
import pytest

from chapters.shared.rigs import rig_named

POINTS = np.random.default_rng(5).normal(size=(200, 3)) * [200, 200, 60] + [0, 0, 66.1]
OMNI, FISH = "onevr-d70", "coolpix-4500-fce8"


@pytest.mark.parametrize("name", [OMNI, FISH])
@pytest.mark.parametrize(
    ("other", "binned"), [("-boards", 1), ("-small", 4), ("-boards-small", 2)]
)
def test_rig_files_of_one_camera_agree(name, other, binned):
    whole = rig_named(name).camera.project(POINTS)
    seen = rig_named(name + other).camera.project(POINTS)
    both = whole.valid & seen.valid
    assert both.sum() > 50
    np.testing.assert_allclose(
        seen.pixels[both], (whole.pixels[both] + 0.5) / binned - 0.5, atol=2e-3
    )


@pytest.mark.parametrize(
    ("name", "offset_mm"),
    [("aligned-small", 0), ("half-small", 0.5), ("small", 1), ("double-small", 2)],
)
def test_bracket_offset_matches_its_file(name, offset_mm):
    camera = rig_named(f"{OMNI}-{name}").camera
    aligned = rig_named(f"{OMNI}-aligned-small").camera
    moved = camera.T_viewer_mirror[:3, 3] - aligned.T_viewer_mirror[:3, 3]
    assert np.linalg.norm(moved) == pytest.approx(offset_mm, abs=1e-3)
    assert camera.central == (offset_mm == 0)
