"""Output is harmless to terminals, and closed pipes do not stop commands."""

import io
import json
import os
import shutil
import subprocess
import sys

import pytest

from raxel.cameras.registry import load_camera
from raxel.cli import main
from raxel.cli.terminal import Terminal, on_one_line
from tests.bad_input.changes import edit, setting
from tests.image_sets import description, write_drawn_set

# Clears the screen; the same in one character of C1; turns the direction of writing.
COMMANDS = "\x1b[2J", "\x9b2J", "a\u202egnp.exe", "a\u2066b", "\x7f\r\x08\x85\u2028"


@pytest.fixture(scope="module")
def drawn(tmp_path_factory):
    """A set of two images."""
    folder = tmp_path_factory.mktemp("drawn")
    write_drawn_set(folder, tilts=((25, 0), (0, 28)))
    return folder


@pytest.fixture
def folder(drawn, tmp_path):
    return shutil.copytree(drawn, tmp_path / "set")


def is_harmless(text):
    return all(line.isprintable() for line in text.split("\n"))


@pytest.mark.parametrize("command", COMMANDS)
def test_control_characters_of_a_set_are_escaped(folder, capsys, command):
    edit(folder, setting("camera", to=f"good {command} camera"))
    assert main(["check", str(folder)]) == 0
    printed = capsys.readouterr()
    assert is_harmless(printed.out + printed.err)
    shown = command.encode("unicode_escape").decode()
    assert f"camera     good {shown} camera\n" in printed.out


@pytest.mark.parametrize(
    "name", ["a\nb", "a\x1b[31mb", "a\x9b31mb", "\udcff", "a" * 200]
)
def test_error_is_one_line_for_any_name(tmp_path, capsys, name):
    for arguments in (
        ["check", str(tmp_path / name)],
        ["corners", str(tmp_path), "--json", str(tmp_path / name / "x.json")],
        ["evaluate", str(tmp_path / name), str(tmp_path)],
        ["check", str(tmp_path), f"--{name}"],
    ):
        assert main(arguments) == 2
        err = capsys.readouterr().err
        assert err.count("\n") == 1
        assert is_harmless(err)
        assert name.encode("unicode_escape").decode() in err or "evaluate" in arguments


def test_image_names_are_escaped(folder, capsys):
    names = "\u202egnp.png", "\x9b2J.png", "\udcff.png", "a\u2028b.png"
    for name in names:
        shutil.copy(folder / "view0.png", folder / name)
    views = [{"image": name} for name in names]
    quoted = json.dumps(description(0, views=views))  # JSON is YAML
    (folder / "set.yaml").write_text(quoted)
    assert main(["check", str(folder)]) == 0
    printed = capsys.readouterr()
    assert is_harmless(printed.out + printed.err)
    lines = printed.err.splitlines()
    assert lines == [
        f"{number}/4 {name.encode('unicode_escape').decode()}"
        for number, name in enumerate(names, 1)
    ]


def closed_pipe(buffering):
    """The end of a pipe, to write to, whose other end is closed."""
    read, write = os.pipe()
    os.close(read)
    return open(write, "w", buffering)


@pytest.mark.parametrize("buffering", [1, 8192])
def test_calibrate_survives_closed_pipe(drawn, tmp_path, monkeypatch, buffering):
    out, result = tmp_path / "camera.npz", tmp_path / "result.json"
    with closed_pipe(buffering) as pipe, closed_pipe(1) as progress:
        monkeypatch.setattr(sys, "stdout", pipe)
        monkeypatch.setattr(sys, "stderr", progress)
        arguments = ["calibrate", str(drawn), "--model", "zhang"]
        arguments += ["--detector", "opencv"]
        assert main([*arguments, "--out", str(out), "--json", str(result)]) == 0
    assert load_camera(out).K[0, 0] == pytest.approx(300, rel=0.05)
    assert json.loads(result.read_text())["model"] == "zhang"


def test_closed_pipe_ends_process_without_error(drawn):
    """Python itself complains at its end where the pipe is left as it is."""
    with closed_pipe(1) as pipe:
        command = [sys.executable, "-m", "raxel", "check", str(drawn)]
        done = subprocess.run(command, stdout=pipe, stderr=subprocess.PIPE, check=False)
    assert done.returncode == 0
    assert done.stderr == b"1/2 view0.png\n2/2 view1.png\n"


@pytest.mark.skipif(not os.path.exists("/dev/full"), reason="no such device here")
def test_full_output_device_is_reported(drawn, tmp_path, monkeypatch, capsys):
    out = tmp_path / "corners.json"
    with open("/dev/full", "w") as full:
        monkeypatch.setattr(sys, "stdout", full)
        arguments = ["corners", str(drawn), "--detector", "opencv"]
        assert main([*arguments, "--json", str(out)]) == 1
    assert out.exists()
    last = capsys.readouterr().err.splitlines()[-1]
    full = "No space left on device"
    assert last == f"raxel: standard output: {full}; results are saved"


def test_unencodable_characters_are_escaped():
    raw = io.BytesIO()
    stream = io.TextIOWrapper(raw, encoding="ascii")
    print("Mičušík \udcff", file=Terminal(stream), flush=True)
    assert raw.getvalue() == b"Mi\\u010du\\u0161\\xedk \\udcff\n"


@pytest.mark.parametrize("text", ["", "a b", "µ → é", "a\xa0b\u3000c", "日本語"])
def test_printable_text_is_unchanged(text):
    assert on_one_line(text) == text


def test_missing_streams_are_tolerated(drawn, monkeypatch):
    monkeypatch.setattr(sys, "stdout", None)
    monkeypatch.setattr(sys, "stderr", None)
    assert main(["check", str(drawn)]) == 0
    assert main(["check", str(drawn / "none")]) == 2
