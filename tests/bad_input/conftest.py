"""A good set, a copy to break, and commands that must fail with one line."""

import json
import shutil

import pytest

from raxel.cli import main, terminal
from tests.bad_input.changes import reference
from tests.image_sets import write_drawn_set


@pytest.fixture(autouse=True)
def patient(monkeypatch):
    """Progress is held back however busy the machine is: one line is one line."""
    monkeypatch.setattr(terminal, "PATIENCE_S", 600.0)


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
