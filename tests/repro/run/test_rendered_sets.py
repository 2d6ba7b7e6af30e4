"""Rendered sets: their keys, who may open them, and how one takes its place."""

import json
import shutil
from functools import partial

import pytest
import yaml

from raxel.errors import InputError
from repro.run import rendered, where
from repro.run.discover import Producer, producers
from repro.run.jobs import Size
from repro.run.reach import Reach
from repro.run.rendered import declared, manifest, rendered_set
from repro.workflow import rendering
from repro.workflow.job import run
from repro.workflow.plan import BuildPlan, BuildTask
from repro.workflow.records import drop_damaged
from repro.workflow.rendering import RenderedSets, render_set
from tests.raxel.lab.test_rig import small_rig
from tests.sample_files import write
from tests.small_checkouts import ROOT

NAME, OTHER = "small/3", "small/4"


def experiment(*names):
    return Producer(
        "experiment", "x", "chapters.a.b.page", "f", "a/b", 7,
        {"rendered": {"quick": names}},
    )  # fmt: skip


def sets(root, *names):
    return RenderedSets(root, Reach(root), [experiment(*names)], "quick")


def key(root, name=NAME):
    return sets(root).key(name)


def written(root, name, text):
    write(root / name, text)


@pytest.fixture
def checkout(tmp_path, monkeypatch):
    """A folder with one small rig, where jobs run."""
    written(tmp_path, "data/rigs/small.yaml", yaml.safe_dump(small_rig()))
    written(tmp_path, rendering.SCHEMA, "{}")
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(rendered, "CHECKOUT", tmp_path)
    return tmp_path


def test_set_key_follows_rig_and_simulator(checkout):
    code = (
        'from raxel.lab.take import take\ndef render(o):\n    """One."""\n    take(o)'
    )
    written(checkout, "lib/raxel/cli/images.py", code)
    written(checkout, "lib/raxel/lab/take.py", "def take(o):\n    return 1\n")
    first = key(checkout)
    written(checkout, "lib/raxel/cli/images.py", code.replace("One", "Two"))
    written(checkout, "lib/raxel/lab/other.py", "def other():\n    return 1\n")
    assert key(checkout) == first
    written(checkout, "lib/raxel/lab/take.py", "def take(o):\n    return 2\n")
    second = key(checkout)
    rig = checkout / "data/rigs/small.yaml"
    rig.write_text(rig.read_text() + "# a word\n")
    third = key(checkout)
    written(checkout, rendering.SCHEMA, '{"type": "object"}')
    assert len({first, second, third, key(checkout)}) == 4


def test_set_key_reaches_simulator():
    reached = {":".join(place) for place in Reach(ROOT).reached(rendering.CODE)}
    wanted = ["lab.set_rendering:render_set", "lab.rig:Rig", "lab.sensor:Sensor"]
    assert {f"raxel.{one}" for one in wanted} <= reached


def test_declared_set_names_are_validated(checkout):
    assert sets(checkout, NAME, OTHER, NAME).names == [NAME, OTHER]
    for name in ("small", "small/-1", "small/03", "../small/3", "small/3/4"):
        with pytest.raises(ValueError, match=r"page\.py:7: rendered set .*RIG/SEED"):
            _ = sets(checkout, name).names
    with pytest.raises(ValueError, match=r"'big/3': no rig data/rigs/big\.yaml"):
        _ = sets(checkout, "big/3").names


def test_undeclared_set_is_rejected(checkout):
    with pytest.raises(FileNotFoundError, match=r"raxel render data/rigs/small\.yaml"):
        rendered_set("small", 3)
    written(checkout, "data/synthetic/small/3/set.yaml", "")
    folder = checkout / "data/synthetic/small/3"
    assert rendered_set("small", 3) == folder
    with declared([NAME]):
        assert rendered_set("small", 3) == folder
        with pytest.raises(LookupError, match=f"{OTHER}: not declared.*: {NAME}"):
            rendered_set("small", 4)
    with declared(()), pytest.raises(LookupError, match=f"{NAME}: not declared.*none"):
        rendered_set("small", 3)


def test_pages_declare_their_rigs():
    """Some of its experiments may only be near the code that reads it."""
    reach = Reach(ROOT)
    readers = {
        (f"chapters.shared.{name}", "rig_named") for name in ("rigs", "grid_rigs")
    }
    made = [p for p in producers(ROOT) if p.kind == "experiment"]
    declaring = {
        p.page
        for p in made
        if "data/rigs" in str(p.details.get("inputs")) or p.details.get("rendered")
    }
    reading = {
        p.page for p in made if readers & {*reach.reached((p.module, p.function))}
    }
    assert len(reading) > 5
    assert reading <= declaring


PAGE = """
SETS = {"quick": ("small/3",), "full": ("small/3", "small/4")}


@experiment("rolled", artefact="ext_x", rendered=SETS)
def rolled(effort):
    return BuildPlan(one_roll, [{}], 1)
"""


def test_where_links_experiments_and_sets(checkout):
    written(checkout, "chapters/ch09_x/s1_y/page.py", PAGE)
    shutil.copytree(ROOT / "data/published", checkout / "data/published")
    written(checkout, manifest(OTHER), "{}")
    lines = where.Whereabouts(checkout).lines("rolled")
    assert lines == where.Whereabouts(checkout).lines(OTHER)
    rig = "data/rigs/small.yaml:1"
    assert [line for line in lines if line.word == "set"] == [
        ("set", rig, NAME),
        ("set", rig, OTHER),
    ]


def made(checkout):
    """The plan of the set's job, and its files after it."""
    plan = BuildPlan(checkout, Size("quick"))
    task = BuildTask(f"set/{NAME}", "sets", partial(render_set, NAME), lambda: "1")
    plan.tasks = {task.name: task}
    plan.final = [task.name]
    (job,) = plan.jobs.values()
    run(plan, job)
    folder = checkout / "data/synthetic/small/3"
    files = [path for path in folder.rglob("*") if path.is_file()]
    return plan, {p.relative_to(folder).as_posix(): p.read_bytes() for p in files}


def test_truncated_set_is_rendered_again(checkout, monkeypatch, capsys):
    plan, first = made(checkout)
    described = checkout / manifest(NAME)
    text = described.read_text()
    assert json.loads(text)["files"].keys() == first.keys()
    drop_damaged(plan)
    cut = checkout / "data/synthetic/small/3/view-001.png"
    cut.write_bytes(cut.read_bytes()[:100])
    drop_damaged(plan)
    assert "small/3/view-001.png: damaged" in capsys.readouterr().err
    assert made(checkout)[1] == first
    assert described.read_text() == text

    shutil.copytree(cut.parent, cut.parent.with_name(".3"))  # as of a killed job
    rig = checkout / "data/rigs/small.yaml"
    rig.write_text(rig.read_text().replace("chessboard", "chess"))
    with pytest.raises(InputError, match="raxel render failed"):
        render_set(NAME)
    assert rig.name in capsys.readouterr().err
    assert [path.name for path in cut.parents[1].iterdir()] == ["3.json"]
