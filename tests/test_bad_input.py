"""Bad input: one line with file, field, what was found; status 2; nothing written."""

import json
import re
import shutil
import subprocess
import sys

import cv2
import numpy as np
import pytest
import yaml

from raxel.cameras.perspective import PerspectiveCamera
from raxel.cli import main
from tests.image_sets import HEIGHT, WIDTH, write_drawn_set

ACTIVE_GRID = {"kind": "active_grid", "monitor_px": [1024, 768], "monitor_mm": None}


@pytest.fixture(scope="module")
def good_set(tmp_path_factory):
    folder = tmp_path_factory.mktemp("good") / "set"
    write_drawn_set(folder)
    (folder / "corners.json").write_text(json.dumps(reference(7 * 5)))
    return folder


@pytest.fixture
def broken(good_set, tmp_path):
    """A copy of the good set, to be broken by one test."""
    return shutil.copytree(good_set, tmp_path / "set")


@pytest.fixture
def fails(capsys, tmp_path):
    """Runs a command that must fail as it should; returns its one line."""

    def run(*arguments, status=2):
        before = sorted(tmp_path.rglob("*"))
        assert main([str(argument) for argument in arguments]) == status
        printed = capsys.readouterr()
        assert printed.out == ""
        assert printed.err.count("\n") == 1
        assert printed.err.endswith("\n")
        assert "Traceback" not in printed.err
        assert sorted(tmp_path.rglob("*")) == before, "something was written"
        return printed.err

    return run


@pytest.fixture
def calibration_fails(fails, tmp_path, broken):
    """Calibrates the broken set, which must fail; returns the one line."""

    def run(*options):
        outputs = "--out", tmp_path / "camera.npz", "--json", tmp_path / "result.json"
        return fails("calibrate", broken, *outputs, *options)

    return run


def reference(count, columns=7, rows=5):
    corners = [[10.0 + i, 20.0] for i in range(count)]
    return {
        "columns": columns,
        "rows": rows,
        "images": {"view0.png": {"corners": corners}},
    }


def edit(folder, change):
    """Apply `change` to the content of set.yaml."""
    path = folder / "set.yaml"
    data = yaml.safe_load(path.read_text())
    change(data)
    path.write_text(yaml.safe_dump(data, sort_keys=False))


def setting(*path, to):
    """A change that puts a value at a path of keys and indices."""

    def change(data):
        for key in path[:-1]:
            data = data[key]
        data[path[-1]] = to

    return change


def removing(*path):
    """A change that takes away what is at a path."""

    def change(data):
        for key in path[:-1]:
            data = data[key]
        del data[path[-1]]

    return change


SQUARE = [[50, 50], [250, 50], [250, 200], [50, 200]]
GRAY = {"image": "view0.png", "axis": "x", "kind": "gray", "bit": 0, "of": 4}
PHASE = {"image": "view0.png", "axis": "x", "kind": "phase", "step": 0, "of": 3}


def active_grid(*patterns):
    """A change that makes the set one of an active grid with these patterns."""

    def change(data):
        data["target"] = ACTIVE_GRID
        data["views"] = [{"name": "pose", "patterns": list(patterns)}]

    return change


FAULTS = {
    "unknown key": (setting("colour", to="grey"), "colour: unknown key; known are"),
    "misspelt key": (
        lambda data: data["target"].update(colums=data["target"].pop("columns")),
        r"target\.colums: unknown key; did you mean columns\?",
    ),
    "misspelt key of a view": (
        setting("views", 1, "usage", to="evaluate"),
        r"views\[1\]\.usage: unknown key; did you mean use\?",
    ),
    "misspelt origin": (
        setting("origin", to={"license": "MIT"}),
        r"origin\.license: unknown key; did you mean licence\?",
    ),
    "no version": (
        removing("raxel_set"),
        "raxel_set: key missing; give .*raxel_set: 1",
    ),
    "another version": (setting("raxel_set", to=2), "raxel_set: found 2"),
    "no resolution": (removing("resolution"), "resolution: key missing; give width"),
    "no rows": (removing("target", "rows"), r"target\.rows: key missing; give"),
    "no views": (removing("views"), "views: key missing"),
    "empty views": (setting("views", to=[]), "views: found a list of 0"),
    "views of text": (setting("views", 0, to="view0.png"), r"views\[0\]: found 'view0"),
    "no image": (
        setting("views", 2, to={"use": "evaluate"}),
        r"views\[2\]\.image: key missing",
    ),
    "number as image": (
        setting("views", 0, "image", to=132),
        r"views\[0\]\.image: .*132",
    ),
    "number as name": (setting("name", to=12), "name: found 12; .*in quotes"),
    "resolution of one": (
        setting("resolution", to=[320]),
        "resolution: found a list of 1",
    ),
    "text in resolution": (
        setting("resolution", 0, to="wide"),
        r"resolution\[0\]: found 'wide'",
    ),
    "broken pixel": (
        setting("resolution", 0, to=320.5),
        r"resolution\[0\]: found 320\.5",
    ),
    "NaN": (
        setting("target", "pitch_mm", to=float("nan")),
        r"target\.pitch_mm: found nan; give a finite number",
    ),
    "infinity": (
        setting("views", 0, "motion", to={"translation_mm": [0, float("inf"), 0]}),
        r"views\[0\]\.motion\.translation_mm\[1\]: found inf",
    ),
    "pitch of zero": (
        setting("target", "pitch_mm", to=0),
        r"target\.pitch_mm: found 0",
    ),
    "pitch as text": (
        setting("target", "pitch_mm", to="25 mm"),
        r"target\.pitch_mm: found '25 mm'",
    ),
    "yes for a number": (
        setting("target", "rows", to=True),
        r"target\.rows: found true",
    ),
    "few columns": (
        setting("target", "columns", to=2),
        r"target\.columns: found 2; give",
    ),
    "few rows": (setting("target", "rows", to=2), r"target\.rows: found 2; give"),
    "half known": (
        setting("target", "rows", to=None),
        r"target\.rows: found null beside",
    ),
    "another target": (
        setting("target", "kind", to="circles"),
        r"target\.kind: .*'circles'",
    ),
    "another use": (
        setting("views", 0, "use", to="test"),
        r"views\[0\]\.use: found 'test'",
    ),
    "three clicks": (
        setting("views", 1, "outer_corners", to=SQUARE[:3]),
        r"views\[1\]\.outer_corners: found a list of 3; give four points",
    ),
    "five clicks": (
        setting("views", 1, "outer_corners", to=[*SQUARE, [1, 1]]),
        r"views\[1\]\.outer_corners: found a list of 5; give four points",
    ),
    "clicks the other way": (
        setting("views", 1, "outer_corners", to=SQUARE[::-1]),
        r"views\[1\]\.outer_corners: .*clockwise",
    ),
    "click outside": (
        setting("views", 1, "outer_corners", to=[*SQUARE[:3], [50, 240]]),
        r"views\[1\]\.outer_corners\[3\]: found \[50\.0, 240\.0\], outside",
    ),
    "missing image": (
        setting("views", 3, "image", to="veiw3.png"),
        r"views\[3\]\.image: no file 'veiw3\.png'",
    ),
    "image outside": (
        setting("views", 0, "image", to="../secret.png"),
        r"views\[0\]\.image: found '\.\./secret\.png'; name a file inside",
    ),
    "absolute image": (
        setting("views", 0, "image", to="/etc/passwd"),
        r"views\[0\]\.image: found '/etc/passwd'; name a file inside",
    ),
    "drive in image": (
        setting("views", 0, "image", to="C:\\board.png"),
        r"views\[0\]\.image: found .*; name a file inside",
    ),
    "truth outside": (setting("truth", to="../truth"), "truth: found '../truth'"),
    "missing reference": (setting("reference", to="no.json"), "reference: no file"),
    "line break in image": (
        setting("views", 0, "image", to="a\nb.png"),
        r"views\[0\]\.image: found 'a\\nb\.png'",
    ),
    "image twice": (
        setting("views", 4, "image", to="view1.png"),
        r"views\[4\]\.image: found 'view1\.png', which views\[1\] has already",
    ),
    "no patterns": (active_grid(), r"views\[0\]\.patterns: found a list of 0"),
    "no bit": (
        active_grid({k: v for k, v in GRAY.items() if k != "bit"}),
        r"views\[0\]\.patterns\[0\]\.bit: key missing; give the bit",
    ),
    "bit beyond the code": (
        active_grid(GRAY, {**GRAY, "bit": 4}),
        r"patterns\[1\]\.bit: found 4, but there are 4 \(0 to 3\)",
    ),
    "missing bit": (
        active_grid(GRAY, {**GRAY, "bit": 2}),
        r"views\[0\]\.patterns: gray code of axis x lacks bit 1 of 4",
    ),
    "missing step": (
        active_grid({**PHASE, "periods": 8}, {**PHASE, "periods": 8, "step": 2}),
        r"views\[0\]\.patterns: phase code of axis x lacks step 1 of 3",
    ),
    "bit twice": (active_grid(GRAY, GRAY), r"patterns\[1\]: the same pattern as"),
    "bit of a phase": (
        active_grid({**PHASE, "periods": 8, "bit": 1}),
        r"patterns\[0\]\.bit: unknown key",
    ),
    "image beside patterns": (
        lambda data: data.update(target=ACTIVE_GRID),
        r"views\[0\]\.image: unknown key",
    ),
}


@pytest.mark.parametrize("fault", FAULTS)
def test_a_fault_in_set_yaml_is_named(broken, calibration_fails, fault):
    change, expected = FAULTS[fault]
    edit(broken, change)
    line = calibration_fails()
    assert line.startswith(f"raxel: {broken / 'set.yaml'}: ")
    assert re.search(expected, line), line


ALIASES = "a0: &a0 [1, 1]\n" + "".join(
    f"a{n}: &a{n} [{', '.join([f'*a{n - 1}'] * 9)}]\n" for n in range(1, 20)
)
SYNTAX = {
    "unclosed list": ("raxel_set: 1\nname: [a\n", "line 3: "),
    "tab": ("raxel_set: 1\ntarget:\n\tkind: chessboard\n", "line 3: "),
    "key twice": ("raxel_set: 1\nname: a\nname: b\n", "line 3: key 'name' given twice"),
    "aliases upon aliases": (ALIASES, "aliases .* grow without bound"),
    "itself": ("a: &x [*x]\n", "aliases .* grow without bound"),
    "tag": ("raxel_set: !!python/name:os.system 1\n", "line 1: a tag"),
    "number as key": ("1: 2\n", "line 1: a key must be a word"),
    "two documents": ("raxel_set: 1\n---\nraxel_set: 1\n", "line 2: "),
    "no number": ("raxel_set: 0b_\n", "line 1: '0b_' is not a number"),
    "empty": ("", "found null; give a mapping"),
    "text": ("chessboard", "found 'chessboard'; give a mapping"),
    "deep": ("[" * 3000, "nested too deeply|line 1"),
    "control character": ("name: \x07\n", "not a YAML text"),
}


@pytest.mark.parametrize("fault", SYNTAX)
def test_yaml_that_cannot_be_read_is_named_with_its_line(broken, fails, fault):
    text, expected = SYNTAX[fault]
    (broken / "set.yaml").write_text(text)
    line = fails("check", broken)
    assert line.startswith(f"raxel: {broken / 'set.yaml'}: ")
    assert re.search(expected, line), line


def test_a_set_yaml_that_is_no_text(broken, fails):
    (broken / "set.yaml").write_bytes(b"\xff\xfe\x00name")
    assert "set.yaml: not a YAML text" in fails("check", broken)


def other_size(path):
    cv2.imwrite(str(path), np.zeros((HEIGHT, WIDTH + 1), np.uint8))


IMAGES = {
    "empty": (lambda path: path.write_bytes(b""), "the file is empty"),
    "cut": (lambda path: path.write_bytes(path.read_bytes()[:-200]), "cut off"),
    "no image": (lambda path: path.write_text("Dear reader"), "not a PNG, JPEG"),
    "other size": (other_size, rf"found {WIDTH + 1} x {HEIGHT} px, but resolution in"),
}


@pytest.mark.parametrize("fault", IMAGES)
@pytest.mark.parametrize("command", ["corners", "calibrate", "check", "undistort"])
def test_a_faulty_image_is_named(broken, fails, tmp_path, command, fault):
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


def test_a_cut_jpeg_leaves_one_line_in_a_real_process(broken, tmp_path):
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
    assert "view0.png: cut off" in done.stderr
    assert not out.exists()


def test_an_image_that_only_looks_whole_leaves_one_line(broken, tmp_path):
    """A PNG whose check sums are right and whose pixels are none."""
    good = cv2.imencode(".png", np.zeros((HEIGHT, WIDTH), np.uint8))[1].tobytes()
    start, end = good.index(b"IDAT") - 4, good.index(b"IEND") - 4
    (broken / "view0.png").write_bytes(good[:start] + good[end:])
    command = [sys.executable, "-m", "raxel", "check", str(broken)]
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    assert done.returncode == 2
    assert done.stderr.count("\n") == 1
    assert "view0.png: damaged" in done.stderr


def test_what_is_no_set(fails, tmp_path):
    assert "no set.yaml in it; not an image set" in fails("check", tmp_path)
    assert "found nothing; give the folder" in fails("check", tmp_path / "nowhere")
    (tmp_path / "file").write_text("")
    assert "found a file; give the folder" in fails("check", tmp_path / "file")


def test_one_view_only(broken, calibration_fails):
    edit(broken, lambda data: data.update(views=data["views"][:1]))
    assert "set.yaml: views: found 1 to calibrate with" in calibration_fails()


def test_one_view_left_to_calibrate(broken, calibration_fails):
    def change(data):
        for view in data["views"][1:]:
            view["use"] = "evaluate"

    edit(broken, change)
    assert "set.yaml: views: found 1 to calibrate with" in calibration_fails()


@pytest.mark.parametrize("model", ["zhang", "generic"])
def test_parallel_boards(broken, calibration_fails, model):
    write_drawn_set(broken, tilts=((0, 0),) * 6)
    line = calibration_fails("--model", model)
    assert "set.yaml: views: " in line
    assert "parallel" in line


def test_wrong_count_of_corners_in_the_target(broken, calibration_fails):
    edit(broken, setting("target", "columns", to=12))
    line = calibration_fails()
    assert "set.yaml: views: board found in 0 of 6 images" in line
    assert "check target.columns and target.rows" in line


def test_an_active_grid_has_no_corners_to_calibrate_with(broken, calibration_fails):
    view = {"name": "a", "patterns": [GRAY]}
    edit(
        broken,
        lambda data: data.update(
            target=ACTIVE_GRID, views=[view, {**view, "name": "b"}]
        ),
    )
    assert "set.yaml: target.kind: found active_grid" in calibration_fails()


REFERENCES = {
    "too few": (
        lambda d: d["images"]["view0.png"]["corners"].pop(),
        "found 34 corners",
    ),
    "no counts": (lambda d: d.pop("columns"), "columns: give the number"),
    "NaN": (
        lambda d: d["images"]["view0.png"]["corners"].__setitem__(3, [float("nan"), 1]),
        "NaN, which is no finite number",
    ),
    "no point": (
        lambda d: d["images"]["view0.png"]["corners"].__setitem__(3, [1]),
        r"images\.view0\.png\.corners\[3\]: no point",
    ),
    "index": (
        lambda d: d["images"]["view0.png"].update(uncertain=[35]),
        r"images\.view0\.png\.uncertain: give indices of corners, 0 to 34",
    ),
    "no corners": (
        lambda d: d["images"].update({"view0.png": {}}),
        "corners: key missing",
    ),
    "no images": (lambda d: d.update(images=[]), "images: give a mapping"),
    "spread": (
        lambda d: d["images"]["view0.png"].update(spread_max_px="wide"),
        "spread_max_px: no number",
    ),
}


@pytest.mark.parametrize("fault", REFERENCES)
def test_reference_corners_that_do_not_fit(broken, fails, fault):
    change, expected = REFERENCES[fault]
    data = reference(35)
    change(data)
    (broken / "corners.json").write_text(json.dumps(data))
    edit(broken, setting("reference", to="corners.json"))
    line = fails("check", broken)
    assert line.startswith(f"raxel: {broken / 'corners.json'}: ")
    assert re.search(expected, line), line


def found(name, count=35, columns=7, rows=5):
    corners = [[10.0 + i, 20.0] for i in range(count)]
    entry = {"file": name, "found": True, "columns": columns, "rows": rows}
    return {**entry, "corners": corners}


CORNERS = {
    "another file": ("{}", "images: no list found"),
    "cut off": ('{"images": [', "line 1: not JSON"),
    "unknown image": (json.dumps({"images": [found("x.png")]}), r"images\[0\]\.file"),
    "image twice": (
        json.dumps({"images": [found("view0.png")] * 2}),
        r"images\[1\]\.file: found 'view0\.png'; name each image",
    ),
    "wrong number of corners": (
        json.dumps({"images": [found("view0.png", 34)]}),
        r"images\[0\]\.corners: found 34 corners; give columns x rows = 35",
    ),
    "another board": (
        json.dumps({"images": [found("view0.png", 30, 6, 5)]}),
        r"images\[0\]\.columns: found 6; give 7, as the set's target",
    ),
    "no truth value": (
        json.dumps({"images": [{**found("view0.png"), "found": 1}]}),
        r"images\[0\]\.found: ",
    ),
    "no point": (
        json.dumps({"images": [{**found("view0.png"), "corners": [[1, "a"]] * 35}]}),
        r"images\[0\]\.corners: a corner is no point",
    ),
    "outside the image": (
        json.dumps({"images": [{**found("view0.png"), "corners": [[99999, 1]] * 35}]}),
        r"images\[0\]\.corners: found \(99999, 1\), outside the image of",
    ),
    "another set": (
        json.dumps({"set": "elsewhere", "images": []}),
        "set: found 'elsewhere', the set is ",
    ),
    "infinity": (
        '{"images": [{"file": "view0.png", "x": Infinity}]}',
        "Infinity, which is no finite number",
    ),
}


@pytest.mark.parametrize("fault", CORNERS)
def test_corner_files_that_do_not_fit(broken, calibration_fails, tmp_path, fault):
    text, expected = CORNERS[fault]
    path = tmp_path / "found.json"
    path.write_text(text)
    line = calibration_fails("--corners", path)
    assert line.startswith(f"raxel: {path}: ")
    assert re.search(expected, line), line


def test_a_missing_corner_file(calibration_fails, tmp_path):
    path = tmp_path / "none.json"
    assert f"{path}: no such file" in calibration_fails("--corners", path)


def test_places_that_cannot_be_written(broken, fails, tmp_path):
    nowhere = tmp_path / "no" / "camera.npz"
    line = fails("calibrate", broken, "--out", nowhere)
    assert f"{nowhere}: no folder {tmp_path / 'no'}" in line
    line = fails("corners", broken, "--json", tmp_path)
    assert f"{tmp_path}: this is a folder" in line


def test_one_name_for_two_outputs(broken, fails, tmp_path):
    both = tmp_path / "camera.npz"
    line = fails("calibrate", broken, "--out", both, "--json", both)
    assert "--json and --out name the same file; give two names" in line


def test_cameras_that_do_not_fit(broken, fails, tmp_path):
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


def test_undistorting_into_the_set_itself(broken, fails, tmp_path):
    path = tmp_path / "camera.npz"
    PerspectiveCamera(np.diag([300.0, 300.0, 1.0]), [], WIDTH, HEIGHT).save(path)
    line = fails("undistort", path, broken, "--out", broken)
    assert f"{broken}: this is the set itself" in line


@pytest.mark.parametrize(
    "arguments",
    [
        [],
        ["calibrate", "somewhere"],
        ["calibrate", "somewhere", "--out", "c.npz", "--model", "pinhole"],
        ["corners", "somewhere", "--detector", "magic"],
        ["conjure", "somewhere"],
    ],
)
def test_orders_that_make_no_sense(fails, arguments):
    assert "--help" in fails(*arguments)
