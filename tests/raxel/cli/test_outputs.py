"""Every option of every command that names a file or a folder."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from raxel.cameras.lenses.perspective import PerspectiveCamera
from raxel.cli import main
from raxel.cli.commands import OPTION_SECTIONS, PROGRAM, file_name
from tests.image_sets import HEIGHT, WIDTH, write_drawn_set

RIG = Path(__file__).parents[3] / "data/rigs/kodak-boards.yaml"
NAMES = {"FILE", "FOLDER", "SET", "CAMERA", "RIG", "WHAT"}


def named(kind):
    """(command, option) of all that take a name of a file or folder of this kind."""
    return [
        (command, param.opts[0])
        for command, one in PROGRAM.commands.items()
        for param in one.params
        if getattr(param.type, "func", None) is file_name
        and (OPTION_SECTIONS.get(param.opts[0]) == "Output") == (kind == "output")
    ]


def needed(command, folder, camera, replaced):
    """The words of a command line with all that the command requires."""
    given = {
        "camera": camera, "set": folder, "rig": RIG, "what": folder,
        "--out": folder.parent / "new.npz", "--width": 64, "--height": 48,
        "--squares": "5x4", "--pitch": 20, "--format": "ros", "file": RIG,
    } | replaced  # fmt: skip
    words = []
    for param in PROGRAM.commands[command].params:
        name = param.opts[0]
        if name in replaced or param.required:
            words += [name] * name.startswith("--") + [str(given[name])]
    return [command, *words]


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    folder = tmp_path_factory.mktemp("drawn") / "set"
    folder.mkdir()
    write_drawn_set(folder, tilts=((25, 0), (0, 28), (-25, 5)))
    return folder


@pytest.fixture
def folder(drawn, tmp_path):
    return shutil.copytree(drawn, tmp_path / "set")


@pytest.fixture
def camera(tmp_path):
    path = tmp_path / "camera.npz"
    K = np.array([[300.0, 0, 159.5], [0, 300.0, 119.5], [0, 0, 1]])
    PerspectiveCamera(K, [], WIDTH, HEIGHT).save(path)
    return path


def contents(folder):
    return {path: path.read_bytes() for path in folder.rglob("*") if path.is_file()}


def error_line(capsys, words):
    assert main(words) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1, err
    return err


def test_every_file_option_has_the_type_of_file_names():
    untyped = [
        (command, param.name)
        for command, one in PROGRAM.commands.items()
        for param in one.params
        if param.metavar in NAMES and getattr(param.type, "func", None) is not file_name
    ]
    assert untyped == []
    writing = {"--json", "--out", "--report"}
    assert {option for _, option in named("output")} == writing
    assert not writing & {option for _, option in named("input")}
    assert len(named("output")) == 13


@pytest.mark.parametrize(("command", "option"), [*named("output"), *named("input")])
@pytest.mark.parametrize("name", ["", "a\0b"])
def test_empty_file_name_is_rejected(command, option, name, folder, camera, capsys):
    before = contents(folder.parent)
    line = error_line(capsys, needed(command, folder, camera, {option: name}))
    shown = option if option[0] == "-" else option.upper()
    assert f"invalid value for '{shown}': found" in line
    assert contents(folder.parent) == before


# What writes files, and takes one of the set for its input.
WITHOUT = "render", "patterns", "export", "import", "board"
OF_SETS = [pair for pair in named("output") if pair[0] not in WITHOUT]


@pytest.mark.parametrize(("command", "option"), OF_SETS)
@pytest.mark.parametrize("spelling", ["view0.png", "set.yaml", "../set/view0.png"])
def test_output_never_replaces_input(command, option, spelling, folder, camera, capsys):
    before = contents(folder.parent)
    words = needed(command, folder, camera, {option: folder / spelling})
    error_line(capsys, words)
    assert contents(folder.parent) == before


@pytest.mark.parametrize("command", ["render", "patterns", "decode"])
def test_output_folder_must_not_exist(command, folder, camera, capsys):
    before = contents(folder.parent)
    line = error_line(capsys, needed(command, folder, camera, {"--out": folder}))
    assert "exists" in line
    assert contents(folder.parent) == before


def test_undistort_does_not_follow_links_out_of_its_folder(folder, camera, capsys):
    (folder / "sub").mkdir()
    shutil.move(folder / "view0.png", folder / "sub" / "view0.png")
    text = (folder / "set.yaml").read_text()
    (folder / "set.yaml").write_text(text.replace("view0.png", "sub/view0.png"))
    elsewhere, out = folder.parent / "elsewhere", folder.parent / "out"
    elsewhere.mkdir()
    out.mkdir()
    (out / "sub").symlink_to(elsewhere)
    words = ["undistort", str(camera), str(folder), "--out", str(out)]
    assert "found a link that leads out of" in error_line(capsys, words)
    assert list(elsewhere.iterdir()) == []
    (out / "sub").unlink()
    (folder.parent / "linked").symlink_to(out)
    words[-1] = str(folder.parent / "linked")
    assert main(words) == 0
    assert (out / "sub" / "view0.png").is_file()


def test_show_checks_output_before_detection(folder, camera, monkeypatch, capsys):
    """Boards are looked for by `show` where no corners are given: a minute, perhaps."""
    monkeypatch.setattr("raxel.show.cameras.set_scene", lambda *_: pytest.fail("found"))
    words = needed("show", folder, camera, {"--out": folder / "view0.png"})
    assert "choose another name" in error_line(capsys, words)
    link = folder.parent / "link.html"
    link.symlink_to(folder / "set.yaml")
    words = needed("show", folder, camera, {"--out": link})
    assert "choose another name" in error_line(capsys, words)
