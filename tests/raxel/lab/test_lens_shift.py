"""A lens that moves on its camera: pixels, images, truth, and one-line refusals."""

import json

import numpy as np
import pytest
import yaml

from raxel.errors import InputError
from raxel.lab import load_rig, render_set
from raxel.lab.rig import ShiftedLens
from raxel.sets import load_set, read_image
from tests.raised import raises_code
from tests.raxel.lab.test_rig import leaf, small_rig

PLACE = {"translation": leaf([-30, -20, 150], "mm"), "rotation": leaf([0, 0, 0], "deg")}
SHIFT = [3, -2]


def shifted_rig(tmp_path, shift):
    """A rig whose second view is the first through a lens that moved."""
    data = small_rig()
    second = PLACE | {"lens_shift": leaf(shift, "px")}
    data["poses"] = {
        "kind": "listed",
        "margin": leaf(8, "px"),
        "least_spacing": leaf(3, "px"),
        "list": [PLACE, second],
    }
    data["sensor"] |= {
        "white": leaf(4e8, "e"),
        "full_well": leaf(5e8, "e"),
        "read_noise": leaf(0, "e"),
    }
    path = tmp_path / "small.yaml"
    path.write_text(yaml.safe_dump(data), "utf-8")
    return path


def test_lens_shift_moves_image_and_truth(tmp_path):
    folder = tmp_path / "set"
    shown = render_set(load_rig(shifted_rig(tmp_path, SHIFT)), folder, 0)
    first, second = (
        read_image(load_set(folder), view).astype(float) for view in shown.views
    )
    moved = np.roll(first, SHIFT[::-1], (0, 1))
    inner = np.s_[16:-16, 16:-16]
    assert np.abs(second - first)[inner].max() > 50
    assert np.abs(second - moved)[inner].max() <= 1
    images = json.loads((folder / "truth" / "corners.json").read_text("utf-8"))
    corners = [np.array(one["corners"]) for one in images["images"].values()]
    np.testing.assert_allclose(corners[1] - corners[0], [SHIFT] * len(corners[0]))


def test_lens_shift_moves_rays(tmp_path):
    rig = load_rig(shifted_rig(tmp_path, SHIFT))
    assert rig.at_view(0) is rig
    camera = rig.at_view(1).camera
    pixels = np.array([[60.0, 50.0], [80.0, 40.0]])
    rays = camera.rays(pixels)
    np.testing.assert_array_equal(
        rays.directions, rig.camera.rays(pixels - SHIFT).directions
    )
    there = rays.origins + 200 * rays.directions
    np.testing.assert_allclose(camera.project(there).pixels, pixels, atol=1e-9)
    assert (camera.central, camera.parameters) == (True, rig.camera.parameters)
    with raises_code("moved-lens"):
        camera.save(tmp_path / "camera.npz")


def test_excessive_lens_shift_is_rejected(tmp_path):
    with pytest.raises(InputError, match=r"poses\.list\[1\]\.lens_shift\.value: found"):
        load_rig(shifted_rig(tmp_path, [90, 0]))
    with pytest.raises(InputError, match="lens_shift"):
        ShiftedLens(load_rig(shifted_rig(tmp_path, SHIFT)).camera, [np.nan, 0])
