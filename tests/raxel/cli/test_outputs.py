"""Every option of every command that names a file or a folder."""

import shutil
from pathlib import Path

import numpy as np
import pytest

from raxel.cameras.lenses.perspective import PerspectiveCamera
from raxel.cli import main
from raxel.cli.names import read_name, written_name
from raxel.cli.parsers import parser
from tests.image_sets import HEIGHT, WIDTH, write_drawn_set

RIG = Path(__file__).parents[3] / "data/rigs/kodak-boards.yaml"
NAMES = {"FILE", "FOLDER", "SET", "CAMERA", "RIG", "WHAT"}


def commands():
    """Command -> its parser."""
    (group,) = (a for a in parser()._actions if getattr(a, "choices", None))
    return group.choices


def named(kind):
    """(command, option) of all that take a name of this kind."""
    return [
        (command, (action.option_strings or [action.dest])[0])
        for command, one in commands().items()
        for action in one._actions
        if action.type is kind
    ]


def needed(command, folder, camera, replaced):
    """Words that a command needs, to name what lies in a folder."""
    given = {
        "camera": camera, "set": folder, "rig": RIG, "what": folder,
        "--out": folder.parent / "new.npz", "--width": 64, "--height": 48,
    } | replaced  # fmt: skip
    words = []
    for action in commands()[command]._actions:
        name = (action.option_strings or [action.dest])[0]
        if name in replaced or (action.required and name in given):
            words += [name] * bool(action.option_strings) + [str(given[name])]
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


def refused(capsys, words):
    assert main(words) == 2
    err = capsys.readouterr().err
    assert err.count("\n") == 1, err
    return err


def test_every_name_is_looked_at():
    """A new option goes through the check, or this fails."""
    unchecked = [
        (command, action.dest)
        for command, one in commands().items()
        for action in one._actions
        if action.metavar in NAMES and action.type not in (read_name, written_name)
    ]
    assert unchecked == []
    writing = {"--json", "--out", "--report"}
    assert {option for _, option in named(written_name)} == writing
    assert not writing & {option for _, option in named(read_name)}
    assert len(named(written_name)) == 10


@pytest.mark.parametrize(
    ("command", "option"), [*named(written_name), *named(read_name)]
)
@pytest.mark.parametrize("name", ["", "a\0b"])
def test_an_empty_name_is_none(command, option, name, folder, camera, capsys):
    before = contents(folder.parent)
    line = refused(capsys, needed(command, folder, camera, {option: name}))
    assert f"argument {option if option[0] == '-' else option.upper()}: found" in line
    assert contents(folder.parent) == before


# What writes files, and takes one of the set for its input.
OF_SETS = [
    pair for pair in named(written_name) if pair[0] not in ("render", "patterns")
]


@pytest.mark.parametrize(("command", "option"), OF_SETS)
@pytest.mark.parametrize("spelling", ["view0.png", "set.yaml", "../set/view0.png"])
def test_no_result_takes_the_place_of_an_input(
    command, option, spelling, folder, camera, capsys
):
    before = contents(folder.parent)
    words = needed(command, folder, camera, {option: folder / spelling})
    refused(capsys, words)
    assert contents(folder.parent) == before


@pytest.mark.parametrize("command", ["render", "patterns", "decode"])
def test_a_new_folder_is_new(command, folder, camera, capsys):
    before = contents(folder.parent)
    line = refused(capsys, needed(command, folder, camera, {"--out": folder}))
    assert "exists already" in line
    assert contents(folder.parent) == before


def test_undistorted_images_do_not_leave_their_folder(folder, camera, capsys):
    (folder / "sub").mkdir()
    shutil.move(folder / "view0.png", folder / "sub" / "view0.png")
    text = (folder / "set.yaml").read_text()
    (folder / "set.yaml").write_text(text.replace("view0.png", "sub/view0.png"))
    elsewhere, out = folder.parent / "elsewhere", folder.parent / "out"
    elsewhere.mkdir()
    out.mkdir()
    (out / "sub").symlink_to(elsewhere)
    words = ["undistort", str(camera), str(folder), "--out", str(out)]
    assert "found a link that leads out of" in refused(capsys, words)
    assert list(elsewhere.iterdir()) == []
    (out / "sub").unlink()
    (folder.parent / "linked").symlink_to(out)
    words[-1] = str(folder.parent / "linked")
    assert main(words) == 0
    assert (out / "sub" / "view0.png").is_file()


def test_a_place_is_refused_before_the_work_is_done(
    folder, camera, monkeypatch, capsys
):
    """Boards are looked for by `show` where no corners are given: a minute, perhaps."""
    monkeypatch.setattr("raxel.show.cameras.set_scene", lambda *_: pytest.fail("found"))
    words = needed("show", folder, camera, {"--out": folder / "view0.png"})
    assert "choose another name" in refused(capsys, words)
    link = folder.parent / "link.html"
    link.symlink_to(folder / "set.yaml")
    words = needed("show", folder, camera, {"--out": link})
    assert "choose another name" in refused(capsys, words)
