"""An invalid set.yaml: one line with file, field and problem."""

import re
import shutil

import pytest

from raxel.sets import load_set
from tests.bad_input.changes import (
    ACTIVE_GRID,
    GRAY,
    NEXT,
    PHASE,
    edit,
    removing,
    setting,
)

SQUARE = [[50, 50], [250, 50], [250, 200], [50, 200]]


def contour(name, points, size=(7, 5)):
    """A change that gives view 1 four clicks and one contour by hand."""

    def change(data):
        data["views"][1].update(outer_corners=SQUARE, contours={name: points})
        data["target"].update(columns=size[0], rows=size[1])

    return change


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
        r"target\.pitch_mm: found .\.nan.;",
    ),
    "infinity": (
        setting("views", 0, "motion", to={"translation_mm": [0, float("inf"), 0]}),
        r"views\[0\]\.motion\.translation_mm\[1\]: found .\.inf",
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
        r"target\.rows: null, but the other count is known",
    ),
    "another target": (setting("target", "kind", to="dots"), r"target\.kind: .*'dots'"),
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
        r"views\[1\]\.outer_corners\[3\]: \[50\.0, 240\.0\] is outside",
    ),
    "contour of no column": (
        contour("column 7", SQUARE[:1] * 5),
        r"views\[1\]\.contours\.column 7: not a column of the board; give 2 to 6",
    ),
    "short side": (
        contour("side 3", SQUARE[:1] * 5),
        r"views\[1\]\.contours\.side 3: 5 points; give its 7 corners",
    ),
    "long column": (
        contour("column 2", SQUARE[:1] * 7),
        r"views\[1\]\.contours\.column 2: 7 points; give its 5 corners",
    ),
    "contour outside": (
        contour("side 2", [*SQUARE, [320, 9]]),
        r"contours\.side 2\[4\]: \[320\.0, 9\.0\] is outside the image",
    ),
    "contour of an unknown board": (
        contour("side 2", SQUARE, size=(None, None)),
        r"views\[1\]\.contours: target\.columns is null",
    ),
    "missing image": (
        setting("views", 3, "image", to="veiw3.png"),
        r"views\[3\]\.image: no file 'veiw3\.png'",
    ),
    "image outside": (
        setting("views", 0, "image", to="../secret.png"),
        r"views\[0\]\.image: '\.\./secret\.png' is outside the set's folder",
    ),
    "absolute image": (
        setting("views", 0, "image", to="/etc/passwd"),
        r"views\[0\]\.image: '/etc/passwd' is outside the set's folder",
    ),
    "drive in image": (
        setting("views", 0, "image", to="C:\\board.png"),
        r"views\[0\]\.image: .* is outside the set's folder",
    ),
    "truth outside": (setting("truth", to="../truth"), "truth: '../truth'"),
    "missing reference": (setting("reference", to="no.json"), "reference: no file"),
    "folders as Windows writes them": (
        setting("views", 0, "image", to="sub\\view0.png"),
        r"views\[0\]\.image: no file .*; add the file .* with / between fold",
    ),
    "line break in image": (
        setting("views", 0, "image", to="a\nb.png"),
        r"views\[0\]\.image: found 'a\\nb\.png'",
    ),
    "image twice": (
        setting("views", 4, "image", to="view1.png"),
        r"views\[4\]\.image: 'view1\.png' is the image of views\[1\] as well",
    ),
    "no patterns": (active_grid(), r"views\[0\]\.patterns: found a list of 0"),
    "no bit": (
        active_grid({k: v for k, v in GRAY.items() if k != "bit"}),
        r"views\[0\]\.patterns\[0\]\.bit: key missing; give the bit",
    ),
    "bit beyond the code": (
        active_grid(GRAY, {**GRAY, **NEXT, "bit": 4}),
        r"patterns\[1\]\.bit: 4 is not one of 0 to 3",
    ),
    "missing bit": (
        active_grid(GRAY, {**GRAY, **NEXT, "bit": 2}),
        r"views\[0\]\.patterns: gray code of axis x lacks bit 1 of 4",
    ),
    "missing step": (
        active_grid(
            {**PHASE, "periods": 8}, {**PHASE, **NEXT, "periods": 8, "step": 2}
        ),
        r"views\[0\]\.patterns: phase code of axis x lacks step 1 of 3",
    ),
    "bit twice": (
        active_grid(GRAY, {**GRAY, **NEXT}),
        r"patterns\[1\]: same pattern as",
    ),
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
def test_invalid_set_yaml_is_rejected(broken, calibration_fails, fault):
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
    "key twice": ("raxel_set: 1\nname: a\nname: b\n", "line 3: key 'name' is repeated"),
    "aliases upon aliases": (ALIASES, "aliases .* expand without bound"),
    "itself": ("a: &x [*x]\n", "Circular reference"),
    "tag": ("raxel_set: !!python/name:os.system 1\n", "line 1: tags"),
    "number as key": ("1: 2\n", "line 1: a key must be a quoted word"),
    "two documents": ("raxel_set: 1\n---\nraxel_set: 1\n", "line 2: "),
    "empty": ("", "found null; give a mapping"),
    "text": ("chessboard", "found 'chessboard'; give a mapping"),
    "deep": ("[" * 3000, "recursion depth"),
    "deeper": ("[" * 1_000_000, "recursion depth"),
    "control character": ("name: \x07\n", "special characters are not allowed"),
}


@pytest.mark.parametrize("fault", SYNTAX)
def test_unreadable_yaml_is_reported_with_line(broken, fails, fault):
    text, expected = SYNTAX[fault]
    (broken / "set.yaml").write_text(text)
    line = fails("check", broken)
    assert line.startswith(f"raxel: {broken / 'set.yaml'}: ")
    assert re.search(expected, line), line


def test_binary_set_yaml_is_rejected(broken, fails):
    (broken / "set.yaml").write_bytes(b"\xff\xfe\x00name")
    assert "save it as UTF-8" in fails("check", broken)


def test_folder_without_set_is_rejected(fails, tmp_path):
    assert "no image; give a folder with PNG" in fails("check", tmp_path)
    assert "no such folder; give the folder" in fails("check", tmp_path / "nowhere")
    (tmp_path / "file").write_text("")
    assert "is a file; give the folder" in fails("check", tmp_path / "file")


def by_detour(folder):
    return "./view1.png"


def by_folder(folder):
    (folder / "sub").symlink_to(folder)
    return "sub/view1.png"


def by_link(folder):
    (folder / "link.png").symlink_to("view1.png")
    return "link.png"


def by_hard_link(folder):
    (folder / "hard.png").hardlink_to(folder / "view1.png")
    return "hard.png"


@pytest.mark.parametrize("way", [by_detour, by_folder, by_link, by_hard_link])
def test_same_file_under_two_names_is_rejected(broken, calibration_fails, way):
    name = way(broken)
    edit(broken, setting("views", 4, to={"image": name, "use": "evaluate"}))
    wanted = f"views[4].image: '{name}' is the same file as 'view1.png' of views[1]"
    assert f"{broken / 'set.yaml'}: {wanted}; list it once" in calibration_fails()


def test_copied_image_is_accepted(broken):
    shutil.copy(broken / "view1.png", broken / "copy.png")
    edit(broken, setting("views", 4, "image", to="copy.png"))
    assert [view.label for view in load_set(broken).views][4] == "copy.png"
