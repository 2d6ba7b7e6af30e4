"""Producers are found by parsing: literals, and names of literals in modules."""

from pathlib import Path

import pytest

from repro.run.discover import producers
from repro.run.reach import Reach

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


def write(root: Path, name: str, text: str) -> Path:
    path = root / name
    path.parent.mkdir(parents=True, exist_ok=True)
    path.write_text(text)
    return path


def checkout(root: Path, needs: str, imports: str = "", before: str = "") -> Path:
    """A page whose figure names its needs; return the file of the figure."""
    write(root, "chapters/__init__.py", "")
    write(root, "chapters/shared/rigs.py", SHARED)
    write(root, f"{FOLDER}/page.py", "# %% [markdown]\n")
    write(root, f"{FOLDER}/results.py", RESULTS)
    text = FIGURE.format(needs=needs, imports=imports, before=before)
    return write(root, f"{FOLDER}/figures.py", text)


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
def test_needs_may_be_a_literal_or_the_name_of_one(tmp_path, needs, imports, before):
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
def test_what_is_no_literal_is_refused_in_one_line(tmp_path, needs, imports, before):
    path = checkout(tmp_path, needs, imports, before)
    line = (
        path.read_text()
        .splitlines()
        .index(f'@figure("fig_9_1", needs={needs}, evidence="synthetic")')
    )
    with pytest.raises(ValueError, match="are literals") as caught:
        producers(tmp_path)
    said = str(caught.value)
    assert said.startswith(f"{path}:{line + 1}: ")
    assert f"found {needs};" in said
    assert "\n" not in said


def test_what_a_mark_names_does_not_reach_the_key_of_the_function(tmp_path):
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
