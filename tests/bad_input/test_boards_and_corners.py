"""Boards that do not calibrate, and files of corners that do not match the set."""

import json
import re

import cv2
import pytest

from raxel.cli import main
from raxel.features import DETECTORS
from tests.bad_input.changes import edit, reference, setting
from tests.image_sets import write_drawn_set


def test_single_calibration_view_is_rejected(broken, calibration_fails):
    def change(data):
        for view in data["views"][1:]:
            view["use"] = "evaluate"

    edit(broken, change)
    assert "set.yaml: views: found 1 for calibration" in calibration_fails()


@pytest.mark.parametrize("model", ["zhang", "generic"])
def test_parallel_boards_are_rejected(broken, calibration_fails, model):
    write_drawn_set(broken, tilts=((0, 0),) * 6)
    line = calibration_fails("--model", model)
    assert "set.yaml: views: nearly parallel boards: their tilts" in line


def test_wrong_board_size_is_reported(broken, calibration_fails):
    edit(broken, setting("target", "columns", to=12))
    line = calibration_fails()
    assert "set.yaml: views: board found in 0 of 6 images" in line
    assert "check target.columns and target.rows" in line


@pytest.mark.parametrize("detector", ["opencv", "celect"])
def test_detector_requires_known_board_size(broken, fails, tmp_path, detector):
    edit(broken, lambda data: data["target"].update(columns=None, rows=None))
    out = "--json", tmp_path / "corners.json"
    line = fails("corners", broken, "--detector", detector, *out)
    assert "set.yaml: target.columns: found null, but --detector" in line
    assert detector in line


def test_celect_requires_clicks(broken, fails, calibration_fails, tmp_path):
    out = "--json", tmp_path / "corners.json"
    for line in (
        fails("corners", broken, "--detector", "celect", *out),
        calibration_fails("--detector", "celect"),
    ):
        assert "set.yaml: views: found no outer_corners in 6 views, but" in line


def test_corners_without_any_board_fail_with_reasons(broken, tmp_path, capsys):
    edit(broken, setting("target", "columns", to=12))
    path = tmp_path / "corners.json"
    assert main(["corners", str(broken), "--json", str(path)]) == 2
    printed = capsys.readouterr()
    assert printed.err.count("\n") == 1
    assert "set.yaml: views: no usable board in any image; check" in printed.err
    assert "view5.png: no board of 12 x 5" in printed.out
    written = json.loads(path.read_text())["images"]
    assert not any(image["found"] for image in written)
    assert len(written[0]["partial"]["corners"]) == 35


@pytest.mark.parametrize("fault", [MemoryError(), cv2.error("Insufficient memory")])
def test_image_too_large_for_memory_is_reported(broken, fails, monkeypatch, fault):
    def greedy(image, columns, rows):
        raise fault

    fault.code = cv2.Error.StsNoMem
    monkeypatch.setitem(DETECTORS, "opencv-sb", greedy)
    line = fails("corners", broken, "--detector", "opencv-sb")
    assert f"{broken / 'view0.png'}: not enough memory" in line


REFERENCES = {
    "too few": (lambda d: d["images"]["view0.png"]["corners"].pop(), "34 corners"),
    "no counts": (
        lambda d: d.pop("columns"),
        "columns: missing or invalid; give the number",
    ),
    "NaN": (
        lambda d: d["images"]["view0.png"]["corners"].__setitem__(3, [float("nan"), 1]),
        "NaN is not a finite number",
    ),
    "no point": (
        lambda d: d["images"]["view0.png"]["corners"].__setitem__(3, [1]),
        r"images\.view0\.png\.corners\[3\]: not a point",
    ),
    "index": (
        lambda d: d["images"]["view0.png"].update(uncertain=[35]),
        r"images\.view0\.png\.uncertain: not a list of indices; .* 0 to 34",
    ),
    "no corners": (
        lambda d: d["images"].update({"view0.png": {}}),
        "corners: key missing",
    ),
    "no images": (lambda d: d.update(images=[]), "images: missing or not a mapping"),
    "spread": (
        lambda d: d["images"]["view0.png"].update(spread_max_px="wide"),
        "spread_max_px: not a number",
    ),
}


@pytest.mark.parametrize("fault", REFERENCES)
def test_invalid_reference_corners_are_rejected(broken, fails, fault):
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
    "another file": ("{}", "images: not a list"),
    "truncated": ('{"images": [', "invalid JSON .*line 1"),
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
    "a list for a number": (
        json.dumps({"images": [{**found("view0.png"), "columns": [7] * 999}]}),
        r"images\[0\]\.columns: found a list of 999; give 7",
    ),
    "no truth value": (
        json.dumps({"images": [{**found("view0.png"), "found": 1}]}),
        r"images\[0\]\.found: ",
    ),
    "no point": (
        json.dumps({"images": [{**found("view0.png"), "corners": [[1, "a"]] * 35}]}),
        r"images\[0\]\.corners\[0\]: found a list of 2, not a point; give \[x, y\]",
    ),
    "a truth value for a number": (
        json.dumps({"images": [{**found("view0.png"), "corners": [[1, True]] * 35}]}),
        r"images\[0\]\.corners\[0\]: found a list of 2, not a point",
    ),
    "a text for a number": (
        json.dumps({"images": [{**found("view0.png"), "corners": [[1, "2"]] * 35}]}),
        r"images\[0\]\.corners\[0\]: found a list of 2, not a point",
    ),
    "more than a float holds": (
        json.dumps(
            {"images": [{**found("view0.png"), "corners": [[1, 10**400]] * 35}]}
        ),
        r"images\[0\]\.corners\[0\]: found a list of 2, not a point",
    ),
    "outside the image": (
        json.dumps({"images": [{**found("view0.png"), "corners": [[99999, 1]] * 35}]}),
        r"images\[0\]\.corners: found \(99999, 1\), outside the image of",
    ),
    "all at one point": (
        json.dumps({"images": [{**found("view0.png"), "corners": [[9, 8]] * 35}]}),
        r"images\[0\]\.corners: found all of them at \(9, 8\); give",
    ),
    "all that are there at one point": (
        json.dumps(
            {"images": [{**found("view0.png"), "corners": [[9, 8]] * 34 + [None]}]}
        ),
        r"images\[0\]\.corners: found all of them at \(9, 8\); give",
    ),
    "a key twice": (
        '{"images": [{"file": "view0.png", "found": true, "found": false}]}',
        "key 'found' is repeated in one object",
    ),
    "another set": (
        json.dumps({"set": "elsewhere", "images": []}),
        "set: found 'elsewhere', expected ",
    ),
    "infinity": (
        '{"images": [{"file": "view0.png", "x": Infinity}]}',
        "Infinity is not a finite number",
    ),
}


@pytest.mark.parametrize("fault", CORNERS)
def test_invalid_corners_file_is_rejected(broken, calibration_fails, tmp_path, fault):
    text, expected = CORNERS[fault]
    path = tmp_path / "found.json"
    path.write_text(text)
    line = calibration_fails("--corners", path)
    assert line.startswith(f"raxel: {path}: ")
    assert re.search(expected, line), line


def test_collinear_corners_are_attributed_to_their_file(calibration_fails, tmp_path):
    path = tmp_path / "found.json"
    images = [found(f"view{k}.png") for k in range(6)]
    for k, image in enumerate(images):  # not the same pose
        image["corners"] = [[u, v + 20 * k] for u, v in image["corners"]]
    path.write_text(json.dumps({"images": images}))
    line = calibration_fails("--corners", path, "--model", "zhang")
    assert line.startswith(f"raxel: {path}: view0.png: corners: ")


def test_missing_corners_file_is_reported(calibration_fails, tmp_path):
    path = tmp_path / "none.json"
    assert f"{path}: no such file" in calibration_fails("--corners", path)
