"""From a plain folder of images or a video to a folder of results."""

import json
import os
from types import SimpleNamespace

import cv2
import numpy as np
import pytest

from raxel.cameras import load_camera
from raxel.cli import main
from raxel.cli.sets import board, length_mm, opened_set
from raxel.errors import InputError
from raxel.features import find_board
from raxel.features.boards import DETECTORS
from raxel.sets import AprilGrid, Charuco, Chessboard, CircleGrid, load_set
from raxel.sets.folder import MARK, folder_set, image_names, set_name
from raxel.sets.frames import save_frames
from tests.image_sets import COLUMNS, FOCAL, HEIGHT, ROWS, WIDTH, boards

SIZE = f"{COLUMNS}x{ROWS}"
MAX_N_LINES = 8


@pytest.fixture(scope="module")
def images():
    blurred = [cv2.GaussianBlur(board.image(), (0, 0), 0.7) for board in boards()]
    return [np.asarray(image) for image in blurred]


@pytest.fixture
def no_report(monkeypatch):
    """A page takes as long as all the rest."""
    monkeypatch.setattr("raxel.cli.calibrate.write_report", lambda folder, *_: None)


@pytest.fixture
def folder(tmp_path, images):
    """Six images, one of another size, and a damaged one."""
    path = tmp_path / "My camera"
    path.mkdir()
    for number, image in enumerate(images, 7):
        cv2.imwrite(str(path / f"view{number}.png"), image)
    cv2.imwrite(str(path / "small.png"), images[0][::2, ::2])
    (path / "broken.png").write_bytes(b"no image")
    return path


def calibrated(capsys, *words, status=0):
    command = ["calibrate", *map(str, words), "--model", "zhang", "--quiet"]
    assert main(command) == status
    return capsys.readouterr()


def test_folder_becomes_a_folder_of_results(folder, capsys):
    printed = calibrated(capsys, folder, "--board", SIZE, "--pitch", "2cm")
    out = folder.with_name("My camera-calibration")
    made = ["camera.json", "camera.npz", "corners.json", "report", "set.yaml"]
    assert sorted(os.listdir(out)) == made
    lines = printed.out.splitlines()
    assert len(lines) <= MAX_N_LINES
    assert lines[0].startswith("images: 6 of 8 used; not: broken.png (not an image")
    assert lines[-1].startswith(f"results: {os.path.relpath(out)}/report/index.html")
    assert printed.err == ""
    # The set that was used can be evaluated, and its images stay where they are.
    used = load_set(out)
    assert (used.name, used.folder.resolve()) == ("My-camera", folder)
    assert used.target.pitch_mm == 20.0
    assert main(["evaluate", str(out / "camera.npz"), str(out)]) == 0
    assert main(["calibrate", str(out), "--model", "zhang", "-q"]) == 0


@pytest.mark.usefixtures("no_report")
def test_size_of_the_board_is_found_and_corners_are_used_again(folder, capsys):
    out = folder.parent / "out"
    # A failed search leaves nothing behind.
    calibrated(capsys, folder, "--out", out, "--board", "9x8", status=2)
    calibrated(capsys, folder, "--out", out)
    found = load_set(out).target
    assert {found.columns, found.rows} == {COLUMNS, ROWS}
    assert load_camera(out / "camera.npz").K[0, 0] == pytest.approx(FOCAL, rel=0.01)
    text = (out / "corners.json").read_text()
    line = calibrated(capsys, folder, "--out", out, status=2).err
    assert "camera.npz: exists; give --force to replace" in line
    corners = json.loads(text)
    corners["images"][0] |= {"found": False, "corners": [], "reason": "by hand"}
    (out / "corners.json").write_text(json.dumps(corners))
    again = calibrated(capsys, folder, "--out", out, "--force")
    assert "not: view7.png (by hand)" in again.out
    # A new image makes them old.
    os.utime(folder / "view7.png", times=(2e9, 2e9))
    again = calibrated(capsys, folder, "--out", out, "--force")
    assert "by hand" not in again.out


def test_pattern_of_set_yaml_lists_images(folder, capsys):
    assert main(["new", str(folder), "--images", "view*.png"]) == 0
    path = folder / "set.yaml"
    assert main(["new", str(folder)]) == 2
    assert "set.yaml: exists" in capsys.readouterr().err
    text = path.read_text().partition("views:")[0]
    path.write_text(
        text + "images: view*.png\nviews: [{image: view9.png, use: evaluate}]"
    )
    image_set = load_set(folder)
    assert [view.image for view in image_set.views][:3] == [
        "view9.png", "view7.png", "view8.png",
    ]  # fmt: skip
    assert [view.image for view in image_set.views_for("evaluate")] == ["view9.png"]
    path.write_text(text)
    with pytest.raises(InputError, match="views: key missing; list the images, or"):
        load_set(folder)


def test_images_are_ordered_by_number_and_subfolders_are_searched(tmp_path):
    results = "a/report/index.html", "a/report/view-001.jpg", "b/undistorted.json"
    (tmp_path / "a/report").mkdir(parents=True)
    (tmp_path / "b/c/index.html").mkdir(parents=True)
    for name in ("a/i10.png", "a/i9.PNG", "a/.hidden.png", "b/c/new.png", *results):
        (tmp_path / name).write_text(MARK)
    assert image_names(tmp_path) == ["a/i9.PNG", "a/i10.png"]
    (tmp_path / "top.jpg").write_bytes(b"")
    assert image_names(tmp_path) == ["top.jpg"]
    assert image_names(tmp_path, "*/*9*") == ["a/i9.PNG"]


@pytest.mark.parametrize(
    ("name", "pattern", "fault"),
    [
        (
            "a.heic",
            None,
            "a.heic: .heic is not read, convert it by heif-convert; give TIFF or PNG",
        ),
        ("a.NEF", None, "convert it by dcraw -T; give"),
        ("a.txt", None, "no image; give a folder with PNG"),
        ("a.png", "*.jpg", "no image matches '*.jpg'"),
        ("a.png", None, "no file can be read as an image"),
        ("a.png", "/abs", "found pattern '/abs'"),
    ],
)
def test_folder_without_images_is_reported(tmp_path, name, pattern, fault):
    (tmp_path / name).write_bytes(b"")
    with pytest.raises(InputError) as error:
        folder_set(tmp_path, pattern=pattern)
    assert fault in str(error.value)
    assert "\n" not in str(error.value)


@pytest.mark.parametrize(
    ("words", "fault"),
    [
        ([], "SET: missing; give a folder of images, or --video FILE"),
        (["nowhere"], "nowhere: not found; correct the name"),
        (["set", "--every", "3"], "--every: found 3 without --video; remove it"),
        (["--video", "set.yaml", "--out", "x.npz"], "with --video; give a folder"),
        (["--video", "set.yaml"], "no frame can be read; convert the video to MP4"),
        ([".", "--board", "9by6"], "expected interior corners as 9x6"),
        ([".", "--board", "charuco:9x6"], "expected a dictionary of markers"),
        ([".", "--board", "charuco:9x6:5x5"], "5x5 is no dictionary of OpenCV"),
        ([".", "--board", "aprilgrid:6x6"], "has a set.yaml"),
        ([".", "--pitch", "0"], "expected a length such as 25mm"),
        ([".", "--board", "9x6"], "has a set.yaml; correct it there"),
        ([".", "--out", "set.yaml"], "is a file; give a folder, or a camera file"),
    ],
)
def test_wrong_options_are_reported_in_a_line(
    words, fault, tmp_path, capsys, monkeypatch
):
    inside = tmp_path / "set"
    inside.mkdir()
    monkeypatch.chdir(inside)
    (inside / "set.yaml").write_text("{}")
    line = calibrated(capsys, *words, status=2).err
    assert fault in line
    assert line.count("\n") == 1
    assert os.listdir(tmp_path) == ["set"]


@pytest.mark.parametrize(
    ("text", "lengths", "target"),
    [
        ("9x6", (None, None), Chessboard(9, 6)),
        ("charuco:9x6:DICT_4X4_50", (20.0, 15.0), Charuco(9, 6, 20.0, "4X4_50", 15.0)),
        (
            "charuco-legacy:9x6:4X4_50",
            (20.0, 15.0),
            Charuco(9, 6, 20.0, "4X4_50", 15.0, True),
        ),
        ("aprilgrid:6x5", (26.0, 20.0), AprilGrid(12, 10, 26.0, 20.0)),
        ("staggered:4x11", (9.0, None), CircleGrid(4, 11, 9.0, True)),
        ("circles:7x5", (None, None), CircleGrid(7, 5)),
    ],
)
def test_boards_have_kinds(tmp_path, text, lengths, target):
    cv2.imwrite(str(tmp_path / "a.png"), np.zeros((48, 64), np.uint8))
    options = SimpleNamespace(set=tmp_path, command="check", board=board(text))
    options.pitch, options.marker = lengths
    assert opened_set(options).target == target
    if options.marker:
        options.marker = None
        with pytest.raises(InputError, match="--pitch, --marker: missing"):
            opened_set(options)


@pytest.mark.parametrize(
    ("text", "mm"), [("25", 25), ("2.5cm", 25), ("0.025 m", 25), ("1in", 25.4)]
)
def test_lengths_have_units(text, mm):
    assert length_mm(text) == pytest.approx(mm)


def test_set_name_has_allowed_characters(tmp_path):
    assert set_name(tmp_path / "Größe 2") == "Gr-e-2"
    assert set_name("/") == "images"


@pytest.mark.usefixtures("no_report")
def test_sharpest_frames_that_differ_are_taken(tmp_path, images, capsys):
    path = tmp_path / "clip.avi"
    video = cv2.VideoWriter(
        str(path), cv2.VideoWriter_fourcc(*"MJPG"), 10, (WIDTH, HEIGHT)
    )
    for image in [images[0], images[0], images[1], images[2]]:
        for blur in (3.0, 2.0, 0.3, 2.0):
            frame = cv2.GaussianBlur(image, (0, 0), blur)
            video.write(cv2.cvtColor(frame, cv2.COLOR_GRAY2BGR))
    video.release()
    names = save_frames(path, tmp_path, 4)
    # The second board is that of the first.
    assert names == [f"frame-{number:06d}.png" for number in (2, 10, 14)]
    out = tmp_path / "clip-calibration"
    calibrated(capsys, "--video", path, "--every", "4", "--board", SIZE)
    assert len(os.listdir(out / "images")) == 3
    assert load_set(out).name == "clip"


@pytest.mark.usefixtures("no_report")
def test_interrupted_search_is_continued(folder, capsys, monkeypatch):
    out, names = folder.parent / "out", []

    def interrupted(image, *size):
        names.append(size)
        if len(names) == 4:
            raise KeyboardInterrupt
        return find_board(image, *size)

    monkeypatch.setitem(DETECTORS, "raxel", interrupted)
    assert calibrated(capsys, folder, "--out", out, status=130).err == (
        "raxel: interrupted\n"
    )
    assert os.listdir(out) == ["corners.json"]
    calibrated(capsys, folder, "--out", out)
    assert len(names) == 4 + 3
    assert len(json.loads((out / "corners.json").read_text())["images"]) == 6


def test_unused_images_are_named_where_too_few_remain(folder, capsys):
    for number in range(9, 13):
        (folder / f"view{number}.png").unlink()
    (folder / "view8.png").write_bytes((folder / "view8.png").read_bytes()[:-999])
    (folder / "a.heic").touch()
    cv2.imwrite(str(folder / "view9.png"), np.zeros((HEIGHT, WIDTH), np.uint8))
    line = calibrated(capsys, folder, "--board", "9x8", status=2).err
    assert "not used: broken.png, view8.png: not an image, or damaged" in line
    assert "small.png: 160 x 120 px, 2 others have 320 x 240" in line
    assert "a.heic: .heic is not read, convert it by heif-convert" in line
    assert "check --board, or try another" in line
    assert "target." not in line


def test_images_of_one_pose_are_too_few(folder, images, capsys):
    rng = np.random.default_rng(1)
    for number in range(8, 7 + len(images)):
        noisy = images[0] + rng.normal(0, 2, images[0].shape)
        cv2.imwrite(str(folder / f"view{number}.png"), noisy)
    line = calibrated(capsys, folder, "--board", SIZE, status=2).err
    assert "6 images show 1 different pose of the board, --model zhang requires" in line
