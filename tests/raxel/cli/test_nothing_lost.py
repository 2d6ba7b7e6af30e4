"""No command overwrites a file that is still needed."""

import json
import resource
import shutil

import cv2
import numpy as np
import pytest

from raxel.cameras.lenses.perspective import PerspectiveCamera
from raxel.cli import main
from raxel.io.files import png_names
from tests.bad_input.changes import edit, setting
from tests.image_sets import (
    HEIGHT,
    WIDTH,
    description,
    write_description,
    write_drawn_set,
)


@pytest.fixture
def camera(tmp_path):
    path = tmp_path / "camera.npz"
    K = np.array([[300.0, 0, 159.5], [0, 300.0, 119.5], [0, 0, 1]])
    PerspectiveCamera(K, [], WIDTH, HEIGHT).save(path)
    return path


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """A set of one image in its folder and two in a folder below."""
    folder = tmp_path_factory.mktemp("drawn")
    write_drawn_set(folder, tilts=((25, 0), (0, 28), (-25, 5)))
    (folder / "sub").mkdir()
    shutil.move(folder / "view0.png", folder / "a.png")
    shutil.move(folder / "view1.png", folder / "sub" / "a.png")
    shutil.move(folder / "view2.png", folder / "sub" / "b.png")
    names = "a.png", "sub/a.png", "sub/b.png"
    views = [{"image": name} for name in names]
    views[2]["use"] = "evaluate"
    write_description(folder, description(0, views=views))
    return folder


@pytest.fixture
def folder(drawn, tmp_path):
    """A copy of that set, for one test."""
    return shutil.copytree(drawn, tmp_path / "set")


def contents(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def error_line(capsys, *arguments):
    """Return the error line of a command that must fail."""
    assert main([str(argument) for argument in arguments]) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1
    return err


def by_link(folder):
    (folder.parent / "link").symlink_to(folder / "sub")
    return folder.parent / "link"


def by_link_inside(folder):
    """--out is another folder, and `sub` in it leads back to the set."""
    out = folder.parent / "out"
    out.mkdir()
    (out / "sub").symlink_to(folder / "sub")
    return out


def by_hard_link(folder):
    out = folder.parent / "out"
    out.mkdir()
    (out / "a.png").hardlink_to(folder / "sub" / "a.png")
    return out


@pytest.mark.parametrize(
    "way",
    [
        lambda folder: folder / "sub",
        lambda folder: folder / "sub" / ".." / "sub",
        by_link,
        by_link_inside,
        by_hard_link,
    ],
    ids=["name", "detour", "link", "link-inside", "hard-link"],
)
def test_undistort_keeps_images_of_the_set(folder, camera, capsys, way):
    out, before = way(folder), contents(folder)
    line = error_line(capsys, "undistort", camera, folder, "--out", out)
    assert "a.png: belongs to the image set" in line
    assert contents(folder) == before


def over_the_reference(folder, camera):
    """The name of an image of --out is that of the reference corners."""
    (folder / "kept").mkdir()
    (folder / "kept" / "a.png").write_text("{}")
    edit(folder, setting("reference", to="kept/a.png"))
    return folder / "kept", camera


def over_the_camera(folder, camera):
    out = folder.parent / "out"
    out.mkdir()
    return out, shutil.move(camera, out / "a.png")


def over_another_sidecar(folder, camera):
    out = folder.parent / "out"
    out.mkdir()
    (out / "undistorted.json").write_text("{}")
    return out, camera


def into_a_file_as_a_folder(folder, camera):
    out = folder.parent / "out"
    out.mkdir()
    (out / "sub").write_text("a note")
    return out, camera


@pytest.mark.parametrize(
    "place",
    [
        over_the_reference,
        over_the_camera,
        lambda folder, camera: (
            shutil.copytree(folder, folder.parent / "other"),
            camera,
        ),
        over_another_sidecar,
        into_a_file_as_a_folder,
    ],
    ids=["reference", "camera", "set", "sidecar", "file-as-folder"],
)
def test_undistort_keeps_other_files(folder, camera, capsys, place):
    out, camera = place(folder, camera)
    before = contents(folder.parent)
    assert str(out) in error_line(capsys, "undistort", camera, folder, "--out", out)
    assert contents(folder.parent) == before


def test_undistort_replaces_its_own_images(folder, camera):
    out = folder.parent / "out"
    assert main(["undistort", str(camera), str(folder), "--out", str(out)]) == 0
    first = contents(out)
    names = sorted(str(path.relative_to(out)) for path in first)
    assert names == ["a.png", "sub/a.png", "sub/b.png", "undistorted.json"]
    for path in set(first) - {out / "undistorted.json"}:
        assert cv2.imread(str(path), cv2.IMREAD_UNCHANGED).shape == (HEIGHT, WIDTH)
    (out / "a note").write_text("kept")
    (out / "maps.npz").write_text("of an earlier run")
    narrow = PerspectiveCamera(
        np.array([[200.0, 0, 159.5], [0, 200.0, 119.5], [0, 0, 1]]),
        [-0.2],
        WIDTH,
        HEIGHT,
    )
    narrow.save(camera)
    assert main(["undistort", str(camera), str(folder), "--out", str(out)]) == 0
    second = contents(out)
    assert second.pop(out / "a note") == b"kept"
    assert second.keys() == first.keys()
    assert all(second[path] != first[path] for path in first)


NAMES = {
    ("a.png", "b.jpg"): ["a.png", "b.png"],
    ("a.png", "a.jpg"): ["a.png.png", "a.jpg.png"],
    ("a.png", "a.jpg", "a.jpg.png"): ["a.png.png", "a.jpg.png", "a.jpg.png.png"],
    ("a.jpg.png", "a.jpg", "a.png"): ["a.jpg.png", "a.jpg-2.png", "a.png.png"],
    ("a.png", "a.PNG"): ["a.png.png", "a.PNG-2.png"],
    ("a.png", "A.jpg"): ["a.png.png", "A.jpg.png"],
    ("é.png", "e\u0301.jpg"): ["é.png.png", "e\u0301.jpg.png"],
    ("a.jpg", "a.png/b.jpg"): ["a.jpg.png", "a.png/b.png"],
    ("sub/a.jpg", "a.jpg", "./b.jpg"): ["sub/a.png", "a.png", "b.png"],
    ("photograph", "photograph.tif"): ["photograph.png", "photograph.tif.png"],
}


@pytest.mark.parametrize("names", NAMES)
def test_undistort_targets_are_distinct(names):
    assert [str(path) for path in png_names(names)] == NAMES[names]


def test_corners_without_board_keep_existing_file(folder, capsys):
    path = folder.parent / "corners.json"
    command = "corners", str(folder), "--detector", "opencv", "--json"
    assert main([*command, str(path)]) == 0
    good = path.read_bytes()
    edit(folder, setting("target", "columns", to=12))
    capsys.readouterr()
    assert f"({path} is kept)" in error_line(capsys, *command, path)
    assert path.read_bytes() == good
    new = folder.parent / "new.json"
    assert "kept" not in error_line(capsys, *command, new)
    assert not any(entry["found"] for entry in json.loads(new.read_text())["images"])


def test_calibrate_on_full_disk_keeps_old_camera(drawn, tmp_path, capsys):
    """A limit on the size of files: the camera is below it, the JSON beyond."""
    (tmp_path / "set").mkdir()
    names = [f"{'long' * 50}{view}.png" for view in range(15)]
    for name, known in zip(names, 5 * ("a.png", "sub/a.png", "sub/b.png"), strict=True):
        shutil.copy(drawn / known, tmp_path / "set" / name)
    views = [{"image": name} for name in names]
    write_description(tmp_path / "set", description(0, views=views))
    camera, result = tmp_path / "camera.npz", tmp_path / "result.json"
    command = ["calibrate", str(tmp_path / "set"), "--model", "zhang"]
    command += ["--detector", "opencv", "--out", str(camera), "--json", str(result)]
    assert main(command) == 0
    sizes = camera.stat().st_size, result.stat().st_size
    assert sizes[0] < sizes[1]
    result.unlink()
    camera.write_text("the old one")
    capsys.readouterr()
    usual = resource.getrlimit(resource.RLIMIT_FSIZE)
    resource.setrlimit(resource.RLIMIT_FSIZE, (sum(sizes) // 2, usual[1]))
    try:
        status = main(command)
    finally:
        resource.setrlimit(resource.RLIMIT_FSIZE, usual)
    assert status == 1
    err = capsys.readouterr().err
    assert err == f"raxel: {camera}, {result}: File too large; not written\n"
    assert camera.read_text() == "the old one"
    assert not result.exists()


def test_all_commands_accept_images_in_subfolders(folder):
    made = folder.parent / "made"
    made.mkdir()
    corners, camera, out = made / "corners.json", made / "camera.npz", made / "out"
    known = "--corners", str(corners)
    for arguments in (
        ("check", folder),
        ("corners", folder, "--detector", "opencv", "--json", corners),
        ("calibrate", folder, "--model", "zhang", "--out", camera, *known),
        ("evaluate", camera, folder, *known),
        ("undistort", camera, folder, "--out", out),
    ):
        assert main([str(argument) for argument in arguments]) == 0, arguments
    names = ["a.png", "sub/a.png", "sub/b.png"]
    entries = json.loads(corners.read_text())["images"]
    assert [entry["file"] for entry in entries if entry["found"]] == names
    assert sorted(str(path.relative_to(out)) for path in out.rglob("*.png")) == names
