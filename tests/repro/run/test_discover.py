"""Producers are found by parsing: literals, and names of literals in modules."""

import importlib.util
import sys
from pathlib import Path

import pytest

from repro.run import discover, names
from repro.run.discover import producers
from repro.run.jobs import function_of
from repro.run.reach import Reach
from tests.sample_files import write

SHARED = 'WIDE = ("one", "two")\nMADE = tuple(sorted(WIDE))\n'
RESULTS = """
from chapters.shared.rigs import WIDE

GRIDS: tuple = ("grid_a", "grid_b")
EVIDENCE = "rendered"
"""
FIGURE = """
{imports}

{before}

@figure("fig_9_1", needs={needs}, evidence="synthetic")
def fig_9_1(results):
    return len(results)
"""
FOLDER = "chapters/ch09_x/s9_1_y"


def checkout(root: Path, needs: str, imports: str = "", before: str = "") -> Path:
    """A page whose figure names its needs; return the file of the figure."""
    write(root / "chapters/__init__.py", "")
    write(root / "chapters/shared/rigs.py", SHARED)
    write(root / f"{FOLDER}/page.py", "# %% [markdown]\n")
    write(root / f"{FOLDER}/results.py", RESULTS)
    text = FIGURE.format(needs=needs, imports=imports, before=before)
    return write(root / f"{FOLDER}/figures.py", text)


@pytest.mark.parametrize(
    ("needs", "imports", "before"),
    [
        ('("grid_a", "grid_b")', "", ""),
        ("GRIDS", "", 'GRIDS = ("grid_a", "grid_b")'),
        ("GRIDS", "from chapters.ch09_x.s9_1_y.results import GRIDS", ""),
        ("G", "from chapters.ch09_x.s9_1_y.results import GRIDS as G", ""),
        ("results.GRIDS", "from chapters.ch09_x.s9_1_y import results", ""),
    ],
)
def test_needs_may_be_literal_or_its_name(tmp_path, needs, imports, before):
    checkout(tmp_path, needs, imports, before)
    (found,) = producers(tmp_path)
    assert found.needs == ("grid_a", "grid_b")
    assert found.details["evidence"] == "synthetic"


@pytest.mark.parametrize(
    ("needs", "imports", "before"),
    [
        ("GRIDS", "", ""),
        ("[one, two]", "", 'one = "grid_a"\ntwo = "grid_b"'),
        ("GRIDS", "", 'GRIDS = tuple("ab")'),
        ("MADE", "from chapters.shared.rigs import MADE", ""),
        ("gone", "from chapters.ch09_x.s9_1_y.results import gone", ""),
        ("sqrt", "from math import sqrt", ""),
        ("fig_9_1", "", ""),
        ("other()", "", "def other():\n    return ()"),
    ],
)
def test_non_literal_is_rejected_in_one_line(tmp_path, needs, imports, before):
    path = checkout(tmp_path, needs, imports, before)
    line = (
        path.read_text()
        .splitlines()
        .index(f'@figure("fig_9_1", needs={needs}, evidence="synthetic")')
    )
    with pytest.raises(ValueError, match="is not a literal") as caught:
        producers(tmp_path)
    output = str(caught.value)
    assert output.startswith(f"{path}:{line + 1}: ")
    assert f"{needs} is" in output
    assert "\n" not in output


def test_decorator_arguments_do_not_enter_key(tmp_path):
    where = (FOLDER.replace("/", ".") + ".figures", "fig_9_1")
    path = checkout(tmp_path, "GRIDS", before='GRIDS = ("grid_a", "grid_b")')
    before = Reach(tmp_path).key(where)
    path.write_text(path.read_text().replace('"grid_b")', '"grid_c")'))
    assert producers(tmp_path)[0].needs == ("grid_a", "grid_c")
    assert Reach(tmp_path).key(where) == before
    path.write_text(path.read_text().replace("len(results)", "len(GRIDS)"))
    changed = Reach(tmp_path).key(where)
    assert changed != before
    path.write_text(path.read_text().replace('"grid_c")', '"grid_b")'))
    assert Reach(tmp_path).key(where) not in (before, changed)


FAMILY = """
from repro.run.marks import experiments, figures

SETS = {"quick": ("ball/7",), "full": ("ball/7", "cup/8")}


@experiments({"one_runs": "table_9_1", "two_runs": "table_9_2"}, rendered=SETS)
def runs(effort, identifier):
    return effort, identifier


@figures(("fig_9_2", "fig_9_3"), needs=("one_runs",), evidence="analytic")
def drawn(results, identifier):
    return results, identifier


@figures(
    {"fig_9_4": ("one_runs",), "fig_9_5": ("one_runs", "two_runs")},
    evidence="analytic",
)
def other_figure(results, identifier):
    return results, identifier
"""


def test_family_has_one_function(tmp_path, monkeypatch):
    checkout(tmp_path, "()")
    write(tmp_path / f"{FOLDER}/trials.py", FAMILY)
    one, two = (p for p in producers(tmp_path) if p.kind == "experiment")
    drawn = [p for p in producers(tmp_path) if p.function == "drawn"]
    assert [(p.kind, p.id) for p in drawn] == [
        ("figure", "fig_9_2"),
        ("figure", "fig_9_3"),
    ]
    other_figure = [p for p in producers(tmp_path) if p.function == "other_figure"]
    assert [(p.kind, p.id, p.needs) for p in other_figure] == [
        ("figure", "fig_9_4", ("one_runs",)),
        ("figure", "fig_9_5", ("one_runs", "two_runs")),
    ]
    assert [one.id, two.id] == ["one_runs", "two_runs"]
    assert [p.details["artefact"] for p in (one, two)] == ["table_9_1", "table_9_2"]
    module = importlib.util.module_from_spec(
        importlib.util.spec_from_file_location(
            one.module, tmp_path / FOLDER / "trials.py"
        )
    )
    module.__spec__.loader.exec_module(module)
    monkeypatch.setitem(sys.modules, one.module, module)
    assert function_of(two)("quick") == ("quick", "two_runs")
    assert function_of(drawn[1])({}) == ({}, "fig_9_3")
    marks = {mark["id"]: mark["needs"] for mark in module.other_figure.repro_marks}
    assert marks == {p.id: p.needs for p in other_figure}


def test_rigs_of_rendered_sets_are_inputs(tmp_path):
    checkout(tmp_path, "()")
    write(tmp_path / f"{FOLDER}/trials.py", FAMILY)
    made = next(p for p in producers(tmp_path) if p.kind == "experiment")
    assert made.inputs == ("data/rigs/ball.yaml", "data/rigs/cup.yaml")


def test_only_changed_files_are_parsed_again(tmp_path, monkeypatch):
    path = checkout(tmp_path, "WIDE", "from chapters.shared.rigs import WIDE")
    other = write(tmp_path / f"{FOLDER}/trials.py", FAMILY)
    rigs = tmp_path / "chapters/shared/rigs.py"
    parsed = []
    plainly = names.parsed

    def parse(path, text):
        parsed.append(path)
        return plainly(path, text)

    def found():
        parsed.clear()
        discover._producers.cache_clear()
        return producers(tmp_path)

    before = found()
    monkeypatch.setattr(names, "parsed", parse)
    assert found() == before
    assert not parsed
    rigs.write_text(f"{rigs.read_text()}\nLIMIT = 3\n")
    assert found() == before
    assert set(parsed) == {path, rigs}
    other.write_text(other.read_text().replace("one_runs", "first_runs"))
    assert {p.id for p in found()} - {p.id for p in before} == {"first_runs"}
    assert parsed == [other]
    (tmp_path / ".cache/producers.json").write_text("[]")
    assert len(found()) == len(before)
