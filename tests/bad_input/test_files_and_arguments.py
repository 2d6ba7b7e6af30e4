"""Invalid images, cameras, outputs and command lines: one line, nothing written."""

import os
import re
import subprocess
import sys

import cv2
import numpy as np
import pytest
from PIL import Image

from raxel.cameras.lenses.perspective import PerspectiveCamera
from tests.image_sets import HEIGHT, WIDTH

IMAGES = {
    "empty": (lambda path: path.write_bytes(b""), "file is empty"),
    "cut": (lambda path: path.write_bytes(path.read_bytes()[:-200]), "truncated"),
    "no image": (lambda path: path.write_text("Dear reader"), "not an image"),
}


@pytest.mark.parametrize("fault", IMAGES)
@pytest.mark.parametrize("command", ["corners", "calibrate", "check", "undistort"])
def test_invalid_image_is_named(broken, fails, tmp_path, command, fault):
    spoil, expected = IMAGES[fault]
    spoil(broken / "view4.png")
    PerspectiveCamera(np.diag([300.0, 300.0, 1.0]), [], WIDTH, HEIGHT).save(
        tmp_path / "camera.npz"
    )
    arguments = {
        "corners": ("corners", broken, "--json", tmp_path / "corners.json"),
        "calibrate": ("calibrate", broken, "--out", tmp_path / "new.npz"),
        "check": ("check", broken),
        "undistort": (
            "undistort",
            tmp_path / "camera.npz",
            broken,
            "--out",
            tmp_path / "o",
        ),
    }
    line = fails(*arguments[command])
    assert line.startswith(f"raxel: {broken / 'view4.png'}: ")
    assert re.search(expected, line), line


@pytest.mark.parametrize("command", ["corners", "calibrate", "evaluate", "check"])
def test_images_of_wrong_sizes_are_grouped(broken, fails, tmp_path, command):
    """With --corners, too; an EXIF orientation changes no size."""
    for index, shape in {1: (240, 321), 2: (320, 240), 4: (240, 321)}.items():
        depth = np.uint16 if index == 4 else np.uint8
        cv2.imwrite(str(broken / f"view{index}.png"), np.zeros(shape, depth))
    upright, exif = Image.open(broken / "view0.png"), Image.Exif()
    exif[274] = 6
    upright.save(broken / "view0.png", exif=exif)
    camera, corners = tmp_path / "camera.npz", ("--corners", broken / "corners.json")
    arguments = {
        "calibrate": (broken, "--out", camera, *corners),
        "evaluate": (camera, broken, *corners),
    }
    line = fails(command, *arguments.get(command, (broken,)))
    assert line == (
        f"raxel: {broken / 'set.yaml'}: resolution: 320 x 240 px fits 3 of 6 images, 2 "
        "are 321 x 240 (view1.png, view4.png), 1 is 240 x 320, rotated (view2.png); "
        "remove or rotate these, or correct resolution\n"
    )


def test_truncated_jpeg_gives_one_line_in_process(broken, tmp_path):
    """OpenCV's own libraries write to the process's standard error."""
    data = cv2.imencode(".jpg", cv2.imread(str(broken / "view0.png")))[1].tobytes()
    (broken / "view0.png").write_bytes(data[: len(data) // 2])
    out = tmp_path / "camera.npz"
    command = [
        sys.executable,
        "-m",
        "raxel",
        "calibrate",
        str(broken),
        "--out",
        str(out),
    ]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "view0.png: file is truncated" in done.stderr
    assert not out.exists()


def test_png_without_data_gives_one_line_in_process(broken, tmp_path):
    """A PNG with valid checksums but without pixels."""
    good = cv2.imencode(".png", np.zeros((HEIGHT, WIDTH), np.uint8))[1].tobytes()
    start, end = good.index(b"IDAT") - 4, good.index(b"IEND") - 4
    (broken / "view0.png").write_bytes(good[:start] + good[end:])
    command = [sys.executable, "-m", "raxel", "check", str(broken)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "view0.png: file is truncated or damaged" in done.stderr


def test_unwritable_outputs_are_rejected(broken, fails, tmp_path):
    nowhere = tmp_path / "no" / "camera.npz"
    line = fails("calibrate", broken, "--out", nowhere)
    assert f"{nowhere}: no folder {tmp_path / 'no'}" in line
    line = fails("corners", broken, "--json", tmp_path)
    assert f"{tmp_path}: is a folder" in line


def test_outputs_require_distinct_names(broken, fails, tmp_path):
    both = tmp_path / "camera.npz"
    line = fails("calibrate", broken, "--out", both, "--json", both)
    assert "--json and --out name the same file; give two names" in line


def test_device_as_output_is_rejected(broken, fails, tmp_path):
    """A pipe stands for it; whoever may, would put a file in place of /dev/stdout."""
    pipe, link = tmp_path / "pipe", tmp_path / "link"
    os.mkfifo(pipe)
    link.symlink_to(pipe)
    for path in (pipe, link):
        assert f"{path}: not a regular file; give" in fails(
            "corners", broken, "--json", path
        )
        assert path.is_fifo()


def test_input_as_output_is_rejected(broken, fails, tmp_path):
    camera, corners = tmp_path / "camera.npz", tmp_path / "corners.json"
    PerspectiveCamera(np.diag([300.0, 300.0, 1.0]), [], WIDTH, HEIGHT).save(camera)
    corners.write_text("{}")
    read = "--corners", corners
    for arguments, name in (
        (("evaluate", camera, broken, "--json", camera), camera),
        (("evaluate", camera, broken, *read, "--json", corners), corners),
    ):
        assert f"{name}: is an input of this command" in fails(*arguments)


def test_unsuitable_cameras_are_rejected(broken, fails, tmp_path):
    path = tmp_path / "camera.npz"
    result = "--json", tmp_path / "result.json"
    assert f"{path}: " in fails("evaluate", path, broken, *result)
    path.write_bytes(b"PK\x03\x04")
    assert f"{path}: " in fails("evaluate", path, broken, *result)
    PerspectiveCamera(np.diag([300.0, 300.0, 1.0]), [], 640, 480).save(path)
    line = fails("evaluate", path, broken, *result)
    assert f"{path}: width, height: found 640 x 480, but resolution in" in line
    line = fails("undistort", path, broken, "--out", tmp_path / "out")
    assert f"{path}: width, height: found 640 x 480, but resolution in" in line


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["decode", "somewhere"],
        ["calibrate", "somewhere", "--out", "c.npz", "--model", "pinhole"],
        ["corners", "somewhere", "--detector", "magic"],
        ["conjure", "somewhere"],
    ],
)
def test_usage_errors_refer_to_help(fails, arguments):
    assert "--help" in fails(*arguments)
