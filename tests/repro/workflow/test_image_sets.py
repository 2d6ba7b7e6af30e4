"""Image sets of the report: which they are, their results, and their messages."""

import json
import subprocess
from pathlib import Path
from types import SimpleNamespace

import pytest

from repro.run.jobs import Size
from repro.run.reach import Reach
from repro.workflow import build as orders
from repro.workflow.image_sets import ImageSets, calibrate_set, image_sets, sets_in
from repro.workflow.terminal import say
from tests import mirror_sets
from tests.active_grids import drawn
from tests.image_sets import description, write_description, write_drawn_set
from tests.raxel.cli.test_cli_active_grid import recorded
from tests.sample_files import write
from tests.small_checkouts import ROOT

ODD = "b {set}; $x 'q"


def add_set(folder, image="a {0} $x.png"):
    """A set whose only image is in its folder."""
    folder.mkdir(parents=True)
    (folder / image).write_bytes(b"x")
    write_description(folder, description(0, views=[{"image": image}]))
    return folder


def test_sets_of_report_are_all_kinds_with_images(tmp_path):
    own = tmp_path / "data" / "recorded"
    add_set(own / ODD)
    mirror_sets.write_mirror_set(own / "wing")
    (add_set(own / "not fetched") / "a {0} $x.png").unlink()
    assert image_sets(tmp_path, "") == {
        "b-set-x-q": f"data/recorded/{ODD}",
        "wing": "data/recorded/wing",
    }
    given = tmp_path / "given"
    given.mkdir()
    recorded(given / "grid", drawn(noise=1.0))
    write_drawn_set(given / "board", tilts=((0, 0), (25, 0)))
    assert list(image_sets(tmp_path, str(given)))[2:] == ["board", "grid"]
    assert list(image_sets(tmp_path, str(given / "grid")))[2:] == ["grid"]
    assert len(image_sets(tmp_path, str(own / ODD))) == 2
    (given / "board" / "set.yaml").unlink()
    assert sets_in(given / "board") == [given / "board"]


def test_sets_with_equal_name_are_rejected(tmp_path):
    for name in ("a b", "a+b"):
        add_set(tmp_path / "data" / "recorded" / name)
    with pytest.raises(ValueError, match=r"the name a-b is also .*rename the folder$"):
        image_sets(tmp_path, "")


@pytest.mark.parametrize(
    ("given", "reason"), [("none", "no such folder"), ("empty", "no images in it")]
)
def test_folder_without_images_is_rejected(tmp_path, given, reason):
    (tmp_path / "empty").mkdir()
    with pytest.raises(orders.OrderError, match=reason):
        orders._checked_recorded(str(tmp_path / given))


def test_key_covers_all_files_of_set(tmp_path):
    reach = Reach(ROOT)

    def key():
        sets = ImageSets(tmp_path, reach, {"one": "one", "two": "two"})
        return [sets.key(name) for name in ("one", "two")]

    first, second = (add_set(tmp_path / name) for name in ("one", "two"))
    before = key()
    (second / "a {0} $x.png").write_bytes(b"y")
    assert key()[0] == before[0]
    assert key()[1] != before[1]
    (first / "grid").mkdir()
    (first / "grid" / "more.yaml").write_text("")
    assert key()[0] != before[0]
    before = key()
    write(tmp_path / "lib/raxel/sets/image_set.schema.json", "{}")
    assert key()[0] != before[0]


@pytest.fixture
def calibrated(tmp_path, monkeypatch):
    """The record of a set after its job, and the folder of its results."""
    monkeypatch.chdir(tmp_path)

    def run(folder):
        calibrate_set(str(folder), "my-set")
        record = Path("report/build/sets/my-set.json")
        return json.loads(record.read_text()), record.with_suffix("")

    return run


def test_set_has_results_of_command(tmp_path, calibrated):
    tilts = ((0, 0), (25, 0), (0, 25), (-25, 10))
    write_drawn_set(tmp_path / ODD, tilts=tilts)
    record, folder = calibrated(tmp_path / ODD)
    assert record["message"] == ""
    wanted = {"camera.npz", "camera.json", "report/index.html"}
    assert wanted < set(record["files"])
    # It names the folder of the images.
    assert "set.yaml" not in record["files"]
    assert all((folder / name).is_file() for name in record["files"])


def test_rejected_set_has_message_without_folder(tmp_path, calibrated):
    record, _ = calibrated(add_set(tmp_path / ODD))
    assert record["files"] == []
    assert record["message"].startswith("my-set/")
    sets = ImageSets(tmp_path, None, {"my-set": ""})
    assert sets.messages() == [f"not calibrated: {record['message']}"]


def test_control_characters_are_not_printed(capsys):
    say("left out: \x1b[2Ja\u202eb\x07: é")
    assert capsys.readouterr().err == "left out:  [2Ja b : é\n"


@pytest.mark.parametrize(
    "name", ["a: b", "a #b", "{x}", "$HOME `id` \"'", "[1]", "12", "~"]
)
def test_make_passes_set_folder_unchanged(tmp_path, name):
    from snakemake.cli import parse_config

    make = ["make", "-f", ROOT / "Makefile", "-o", "setup"]
    shown = 'BUILD=printf "%s\\n"'
    done = subprocess.run(
        [*make, shown, "quick", f"RECORDED={name}", "SCALE=2", "READINGS=all"],
        cwd=tmp_path, capture_output=True, text=True, check=True,
    )  # fmt: skip
    assert {name, "quick", "2", "all"} <= set(done.stdout.splitlines())
    plan = SimpleNamespace(
        size=Size("quick"), target="report", readings="open", recorded=name
    )
    assert parse_config(orders._config(plan))["recorded"] == name
