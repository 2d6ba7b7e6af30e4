"""raxel patterns and raxel decode: patterns are decoded to their positions."""

import json

import cv2
import numpy as np
import pytest
import yaml

from raxel.cli import main
from raxel.errors import InputError
from raxel.features import find_board
from raxel.sets import ImageSet, View, load_set, write_set
from tests.active_grids import drawn
from tests.raxel.lab.test_rig import changed, leaf


def recorded(folder, scene, **fields):
    """The images of a scene as an image set on disk."""
    folder.mkdir()
    for pattern, image in zip(scene.patterns, scene.images, strict=True):
        cv2.imwrite(str(folder / pattern.image), image)
    height, width = scene.images.shape[1:]
    view = View(name="pose", patterns=tuple(scene.patterns), **fields)
    image_set = ImageSet("drawn", width, height, scene.grid, (view,), folder)
    write_set(image_set)
    return folder


def error_line(capsys, *words):
    assert main(list(map(str, words))) == 2
    err = capsys.readouterr().err
    line = [text for text in err.splitlines() if text.startswith("raxel: ")]
    assert len(line) == 1
    return line[0]


def test_decode_recovers_rendered_positions(tmp_path, capsys):
    target = {
        "kind": "active_grid",
        "monitor_px": leaf([64, 48], "px"),
        "monitor_mm": leaf([64, 48], "mm"),
        "gamma": leaf(1.0, "1"),
        "gray_bits": leaf([3, 3], "1"),
        "gray_inverse": True,
        "phase_steps": leaf(4, "1"),
        "phase_periods": leaf([8, 8], "1"),
    }
    distance = leaf([90, 110], "mm")
    rig = changed(tmp_path / "rig.yaml", target=target, poses__distance=distance)
    rendered, out = str(tmp_path / "set"), str(tmp_path / "points")
    assert main(["render", str(rig), "--out", rendered]) == 0
    assert main(["decode", rendered, "--out", out]) == 0
    for view in load_set(rendered).views:
        with np.load(tmp_path / "set" / "truth" / f"{view.label}.npz") as truth:
            true = truth["points_mm"]
        with np.load(tmp_path / "points" / f"{view.label}.npz") as found:
            known = np.isfinite(found["points_mm"]).all(axis=2)
            np.testing.assert_array_equal(known, found["mask"])
            off = np.linalg.norm(found["points_mm"] - true, axis=2)
            on = np.isfinite(true[..., 0])
            assert not (known & ~on).any()
            assert known.sum() > 0.5 * on.sum()  # the rim takes a good part
            assert np.sqrt(np.mean(off[known] ** 2)) < 0.05
            assert found["sigma_mm"].shape == found["points_mm"].shape
        plot = cv2.imread(str(tmp_path / "points" / f"{view.label}.png"))
        assert plot.shape[1] > 300
    summary = json.loads((tmp_path / "points" / "decoded.json").read_text())
    assert [view["unit"] for view in summary["views"]] == ["mm"] * len(summary["views"])
    assert "median sigma x" in capsys.readouterr().out


def test_patterns_are_decoded_to_their_positions(tmp_path, capsys):
    out = tmp_path / "patterns"
    size = ["--width", "203", "--height", "151"]
    words = [*size, "--cells", "5", "--steps", "6", "--out", str(out)]
    assert main(["patterns", *words]) == 0
    assert "24 patterns with cells of 41 x 31 px" in capsys.readouterr().out
    stub = yaml.safe_load((out / "set.yaml").read_text())
    listed = [entry["image"] for entry in stub["views"][0]["patterns"]]
    files = {path.name for path in out.iterdir()}
    assert files == {*listed, "white.png", "black.png", "preview.png", "set.yaml"}
    for name in (*listed, "white.png", "black.png"):
        assert cv2.imread(str(out / name), -1).shape == (151, 203)
    with pytest.raises(InputError, match="resolution"):
        load_set(out)
    # Images with a little less contrast, pixel on pixel, and the file filled in.
    for name in listed:
        sent = cv2.imread(str(out / name), -1)
        cv2.imwrite(str(out / name), (20 + 0.8 * sent).astype(np.uint8))
    stub["resolution"], stub["target"]["monitor_mm"] = [203, 151], [406.0, 302.0]
    (out / "set.yaml").write_text(yaml.safe_dump(stub))
    for name in ("white.png", "black.png"):
        assert (out / name).is_file()
    assert main(["decode", str(out), "--out", str(tmp_path / "points")]) == 0
    with np.load(tmp_path / "points" / "pose-1.npz") as found:
        points, mask = found["points_mm"], found["mask"]
    v, u = np.indices((151, 203))
    true = 2 * (np.stack([u, v], axis=-1) + 0.5)
    # The monitor ends with the image: six pixels along its border are left out.
    assert mask.mean() > 0.95 * 191 * 139 / (203 * 151)
    assert np.abs(points - true)[mask].max() < 0.5


def test_patterns_describe_several_poses(tmp_path, capsys):
    """Each in a folder of its own; six steps need no word of low harmonics."""
    words = ["--width", "203", "--height", "151", "--cells", "2"]
    four, six = tmp_path / "four", tmp_path / "six"
    assert main(["patterns", *words, "--steps", "4", "--out", str(four)]) == 0
    more = ["--size-mm", "406", "302", "--poses", "2"]
    assert main(["patterns", *words, *more, "--out", str(six)]) == 0
    texts = [(folder / "set.yaml").read_text() for folder in (four, six)]
    assert ["low harmonics" in text for text in texts] == [True, False]
    stub = yaml.safe_load(texts[1])
    assert stub["target"]["monitor_mm"] == [406.0, 302.0]
    photographed = tmp_path / "photographs"
    photographed.mkdir()
    stub["resolution"] = [203, 151]
    (photographed / "set.yaml").write_text(yaml.safe_dump(stub))
    for view in stub["views"]:
        (photographed / view["name"]).mkdir()
        for name in [view["white"], view["black"]] + [
            entry["image"] for entry in view["patterns"]
        ]:
            path = six / name.partition("/")[2]
            (photographed / name).write_bytes(path.read_bytes())
    assert [view.name for view in load_set(photographed).views] == ["pose-1", "pose-2"]
    assert main(["patterns", *words, "--size-mm", "1", "x", "--out", "y"]) == 2
    assert "'--size-mm': found 'x', expected a length in mm" in capsys.readouterr().err


def test_patterns_include_chessboard(tmp_path, capsys):
    """Its corners are where set.yaml says; too many for the monitor are error_line."""
    words = ["patterns", "--width", "203", "--height", "151", "--cells", "2"]
    out = tmp_path / "shown"
    assert main([*words, "--chessboard", "7", "5", "--out", str(out)]) == 0
    assert "chessboard.png" in capsys.readouterr().out
    stub = yaml.safe_load((out / "set.yaml").read_text())
    board = stub["target"]["chessboard"]
    assert stub["views"][0]["chessboard"] == "chessboard.png"
    found = find_board(cv2.imread(str(out / "chessboard.png"), 0), 7, 5)
    lattice = np.indices((5, 7))[::-1].reshape(2, -1).T
    true = board["origin_px"] + board["pitch_px"] * lattice - 0.5
    assert np.abs(np.sort(found.corners, axis=0) - np.sort(true, axis=0)).max() < 0.1
    many = [*words, "--chessboard", "90", "5", "--out", str(tmp_path / "many")]
    assert main(many) == 2
    assert "chessboard: 90 x 5 corners" in capsys.readouterr().err
    assert not (tmp_path / "many").exists()


def test_decode_single_axis_in_px(tmp_path, capsys):
    scene = drawn(noise=1.0)
    own = [k for k, p in enumerate(scene.patterns) if p.axis == "y"]
    scene.images, scene.patterns = scene.images[own], [scene.patterns[k] for k in own]
    scene.grid = type(scene.grid)(scene.grid.monitor_px)
    folder = recorded(tmp_path / "set", scene)
    out = tmp_path / "points"
    options = ["--raw", "--neighbours", "--fill", "--margin", "3"]
    assert main(["decode", str(folder), "--out", str(out), *options]) == 0
    with np.load(out / "pose.npz") as found:
        assert np.isnan(found["points_px"][..., 0]).all()
        assert np.isfinite(found["points_px"][..., 1]).mean() > 0.4
    assert "median sigma y" in capsys.readouterr().out


def test_decode_dark_images_fails_without_output(tmp_path, capsys):
    scene = drawn(noise=1.0)
    scene.images = scene.images // 150
    folder = recorded(tmp_path / "set", scene)
    line = error_line(capsys, "decode", folder, "--out", tmp_path / "points")
    assert "set.yaml: views: pose: no pixel could be decoded (19200 too little" in line
    assert [path.name for path in tmp_path.iterdir()] == ["set"]


def test_impossible_requests_fail(tmp_path, capsys):
    folder = recorded(tmp_path / "set", drawn(noise=1.0))
    line = error_line(capsys, "decode", folder, "--out", folder)
    assert "already exists; give the name of a new" in line
    size = "--width", 64, "--height", 48
    out = tmp_path / "out"
    line = error_line(capsys, "patterns", *size, "--cells", 13, "--out", out)
    assert "cells: 13 along y on 48 px" in line
    line = error_line(capsys, "patterns", *size, "--steps", 2, "--out", out)
    assert "steps: 2 phase steps" in line
    assert not out.exists()
    data = yaml.safe_load((folder / "set.yaml").read_text())
    data["views"][0]["name"] = "../pose"
    (folder / "set.yaml").write_text(yaml.safe_dump(data))
    line = error_line(capsys, "decode", folder, "--out", out)
    assert "views[0].name: found '../pose', not possible as a file name" in line
