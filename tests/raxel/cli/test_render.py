"""`raxel render` from a rig file to an image set, and what is in it."""

import json
from pathlib import Path

import numpy as np
import pytest
import yaml

from raxel.cameras.registry import load_camera
from raxel.cli import main
from raxel.features import find_opencv
from raxel.geometry.planes import on_plane
from raxel.sets import load_set, read_image
from tests.raxel.lab.test_rig import RIGS, changed, leaf

FEWER_PIXELS = 2


def reduced_coolpix(path):
    """Zoom 1 with half the pixels each way, without noise, few poses."""
    source = next(p for p in RIGS if p.stem == "coolpix-fce8-zoom-1")
    data = yaml.safe_load(source.read_text(encoding="utf-8"))
    camera, sensor, poses = data["camera"], data["sensor"], data["poses"]
    for name in ("width", "height"):
        camera[name]["value"] //= FEWER_PIXELS
    scale = np.array(camera["pixels_per_unit"]["value"]) / FEWER_PIXELS
    camera["pixels_per_unit"]["value"] = scale.tolist()
    point = (np.array(camera["principal_point"]["value"]) + 0.5) / FEWER_PIXELS - 0.5
    camera["principal_point"]["value"] = point.tolist()
    radii = np.array(data["optics"]["falloff"]["radius"]["value"]) / FEWER_PIXELS
    data["optics"]["falloff"]["radius"]["value"] = radii.tolist()
    sensor["white"]["value"], sensor["full_well"]["value"] = 4.0e8, 4.9e8
    sensor["read_noise"]["value"] = 0
    poses["count"]["value"], poses["evaluate"]["value"] = 2, 1
    poses["least_spacing"]["value"] = 8
    path.write_text(yaml.safe_dump(data), encoding="utf-8")
    return path


@pytest.fixture(scope="module")
def coolpix(tmp_path_factory):
    folder = tmp_path_factory.mktemp("coolpix")
    rig = reduced_coolpix(folder / "rig.yaml")
    assert main(["render", str(rig), "--out", str(folder / "set"), "--seed", "4"]) == 0
    return folder / "set"


@pytest.fixture(scope="module")
def small(tmp_path_factory):
    folder = tmp_path_factory.mktemp("small")
    rig = changed(folder / "rig.yaml", poses__evaluate=leaf(1, "1"))
    assert main(["render", str(rig), "--out", str(folder / "set")]) == 0
    return folder


def contents(folder):
    return {
        str(path.relative_to(folder)): path.read_bytes()
        for path in sorted(folder.rglob("*"))
        if path.is_file()
    }


def test_rendered_set_is_readable(coolpix):
    image_set = load_set(coolpix)
    assert (image_set.width, image_set.height) == (512, 384)
    assert (image_set.target.columns, image_set.target.rows) == (12, 9)
    assert [view.use for view in image_set.views] == ["calibrate"] * 2 + ["evaluate"]
    assert image_set.truth == "truth/"
    assert image_set.reference is None
    for view in image_set.views:
        assert read_image(image_set, view).dtype == np.uint8
    assert main(["check", str(coolpix)]) == 0


def test_detected_corners_match_truth(coolpix):
    image_set = load_set(coolpix)
    truth = json.loads((coolpix / "truth" / "corners.json").read_text())
    assert (truth["columns"], truth["rows"]) == (12, 9)
    for view in image_set.views:
        seen = find_opencv(read_image(image_set, view), 12, 9)
        assert seen.found
        true = np.array(truth["images"][view.image]["corners"])
        error = np.linalg.norm(seen.corners - true, axis=1)
        # In the board's own order: the first corner of both is the same.
        assert np.sqrt(np.mean(error**2)) < 0.1


def test_truth_projects_onto_true_corners(coolpix):
    camera = load_camera(coolpix / "truth" / "camera.npz")
    poses = json.loads((coolpix / "truth" / "poses.json").read_text())
    assert poses["unit"] == "mm"
    truth = json.loads((coolpix / "truth" / "corners.json").read_text())
    points = on_plane(load_set(coolpix).target.points())
    for name, T in poses["T_camera_target"].items():
        T = np.array(T)
        pixels = camera.project(points @ T[:3, :3].T + T[:3, 3]).pixels
        np.testing.assert_allclose(pixels, truth["images"][name]["corners"], atol=1e-9)


def test_render_is_reproducible_by_seed(small):
    rig, first = str(small / "rig.yaml"), contents(small / "set")
    for name, seed in (("again", 0), ("other", 1)):
        out = ["--out", str(small / name), "--seed", str(seed)]
        assert main(["render", rig, *out]) == 0
    assert contents(small / "again") == first
    other = contents(small / "other")
    assert other.keys() == first.keys()
    same = [name for name in first if first[name] == other[name]]
    assert same == [str(Path("truth") / "camera.npz")]


def test_render_separates_progress_and_summary(small, capsys):
    out = ["--out", str(small / "printed")]
    assert main(["render", str(small / "rig.yaml"), *out]) == 0
    printed = capsys.readouterr()
    assert "3/3 view-002.png" in printed.err
    assert printed.out.startswith("small: 3 views, 3 images of 160 x 120 px")


@pytest.mark.parametrize(
    ("out", "seed", "changes", "message"),
    [
        ("no/folder", "0", {}, "no folder"),
        ("set", "-1", {}, "found '-1', expected a whole number from 0"),
        (
            "set",
            "0",
            {"poses__distance": leaf([20, 25], "mm")},
            "rig.yaml: poses: 0 of",
        ),
        ("set", "0", {"sensor__white": leaf(0, "e")}, "rig.yaml: sensor.white.value"),
    ],
)
def test_failed_render_leaves_no_output(tmp_path, capsys, out, seed, changes, message):
    rig = changed(tmp_path / "rig.yaml", **changes)
    status = main(["render", str(rig), "--out", str(tmp_path / out), "--seed", seed])
    assert status == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    assert message in err
    assert [path.name for path in tmp_path.iterdir()] == ["rig.yaml"]
