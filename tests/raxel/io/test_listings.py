"""What CONTRIBUTING and README list is there, and what they show runs."""

import importlib
import json
import re
import shlex
import subprocess
from pathlib import Path

import jupytext
import pytest

from raxel.cli.commands import PROGRAM
from raxel.io.documents import faults, read_yaml
from raxel.sets.image_set import SCHEMA
from repro.judge.ledger import load
from repro.judge.readings import open_questions
from repro.page import reader
from repro.page.style import new_figure
from repro.run import marks, outcomes
from repro.run.discover import producers
from repro.run.judging import in_every_reading
from tests.image_sets import COLUMNS, ROWS, write_drawn_set
from tests.sample_files import write

ROOT = Path(__file__).resolve().parents[3]
CONTRIBUTING, README = (
    (ROOT / name).read_text("utf-8") for name in ("CONTRIBUTING.md", "README.md")
)
BOTH = CONTRIBUTING + README
PAGE, PRODUCERS = re.findall(r"```python\n(.*?)```", CONTRIBUTING, re.DOTALL)
(LIBRARY,) = re.findall(r"```python\n(.*?)```", README, re.DOTALL)
# What is there only when it was built.
BUILT = (
    ".cache/", ".snakemake/", ".venv/", "data/synthetic/", "figures/full/",
    "report/site", "report/notebooks/", "report/answers/", "report/raxel-report",
    "report/raxel-crate",
)  # fmt: skip
# Examples of what a reader has: places that stand for any.
ANY = ("path/to/", "my-", "rendered/", "points/", "calibration/")


def quoted(text):
    """What stands between single backquotes, but for what stands for anything."""
    prose = re.sub(r"```.*?```", "", text, flags=re.DOTALL)
    return [word for word in re.findall(r"`([^`]+)`", prose) if "..." not in word]


def test_example_decorators_match_workflow(tmp_path):
    write(tmp_path / "chapters/ch02_x/s5_y/page.py", PRODUCERS)
    found = {
        made.function: {"kind": made.kind, "id": made.id} | as_read(made.details)
        for made in producers(tmp_path)
    }
    marks = {
        name: mark
        for name, function in run_producers().items()
        for mark in getattr(function, "repro_marks", ())
    }
    assert (list(found), len(found)) == (list(marks), 3)
    for name, mark in marks.items():
        assert found[name].items() <= as_read(mark).items()


def as_read(mark):
    """A mark as its words in a file give it, lists for tuples."""
    return json.loads(json.dumps(mark))


def run_producers():
    """The names of the example, whose trials and drawings are made up."""
    drawn, axes = new_figure()
    axes.set(xlabel="u (px)", ylabel="v (px)")
    names = vars(outcomes) | vars(marks)
    names |= {"trial": None, "conditions": [{}], "TRIALS": {"quick": 1}, "settings": {}}
    names |= {"drawn": drawn, "data": {"u_px": [0.0]}}
    names |= {"verdict": "reproduced", "regenerated": 1.0, "interval": (0.9, 1.1)}
    before = set(names)
    exec(compile(PRODUCERS, "CONTRIBUTING.md", "exec"), names)
    return {
        name: names[name] for name in names if name not in before | {"__builtins__"}
    }


def test_example_producers_run():
    made = run_producers()
    assert isinstance(made["noise_sweep"]("quick"), outcomes.Plan)
    assert isinstance(made["fig_2_3"]({}), outcomes.Drawing)
    judge = made["judge_noise_linear"]
    (mark,) = judge.repro_marks
    assert len(in_every_reading(judge, {}, open_questions(ROOT), mark["readings"])) == 4
    book = load(ROOT)
    assert mark["id"] in book.claims
    assert "fig_2_3" in book.artefacts


def test_example_page_displays():
    cells = jupytext.reads(PAGE, fmt="py:percent").cells
    assert [cell.cell_type for cell in cells] == ["markdown", "code", "code", "code"]
    names = {}
    exec(compile(cells[1].source, "CONTRIBUTING.md", "exec"), names)
    assert names["show"] is reader.show
    for cell in cells[2:]:
        assert cell.metadata["tags"] == ["active-ipynb"]
        call = re.fullmatch(r"(?:# )?(\w+)\(.*\)", cell.source)
        assert callable(names[call.group(1)])


def test_example_library_code_runs(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    write_drawn_set(tmp_path / "my-images")
    size = f"columns={COLUMNS}, rows={ROWS}"
    code = LIBRARY.replace("columns=9, rows=6", size).replace("320.0, 240.0", "90, 80")
    exec(compile(code, "README.md", "exec"), names := {})
    assert capsys.readouterr().out.startswith("[[90. 80.]\n [10. 10.]]")
    assert names["camera"].k[0] == pytest.approx(1)
    assert Path("cameras.txt").exists()


def test_example_set_is_valid(tmp_path):
    (text,) = re.findall(r"```yaml\n(.*?)```", README, re.DOTALL)
    (tmp_path / "set.yaml").write_text(text, "utf-8")
    given = read_yaml(tmp_path / "set.yaml")
    assert faults(given, "README.md", SCHEMA) == []
    # The schema looks at it: a key that no set has is a fault.
    assert faults(given | {"no such key": 1}, "README.md", SCHEMA)


def test_named_files_exist():
    tree = README.split("## Layout\n\n```\n")[1].split("```")[0]
    top = [line.split("  ")[0].split() for line in tree.splitlines() if line[0] != " "]
    named = [name for names in top for name in names if name != "figures/"]
    named += [f"lib/raxel/{name}" for name in re.findall(r"^  (\w+)/ ", tree, re.M)]
    named += re.findall(r"\]\(([\w./-]+)\)", BOTH)
    named += [
        word
        for word in quoted(BOTH)
        if re.fullmatch(r"(?:[\w.-]+/)+[\w.-]*|\w+\.(?:py|yaml)", word)
        and not word.startswith(ANY)
    ]
    assert len(named) > 60
    there = [
        f"/{path.relative_to(ROOT).as_posix()}"
        for folder in ("chapters", "data/published", "data/recorded")
        for path in (ROOT / folder).rglob("*")
    ]
    missing = [
        name
        for name in named
        if not f"{name}/".startswith(BUILT)
        and not (ROOT / name).exists()
        and not any(path.endswith(f"/{name}") for path in there)
    ]
    assert not missing


def test_dotted_names_are_importable():
    named = [
        word.partition("(")[0]
        for word in quoted(BOTH)
        if re.match(r"(raxel|repro)\.[\w.]+", word)
    ]
    assert len(named) > 10
    for name in named:
        home, _, last = name.rpartition(".")
        try:
            importlib.import_module(name)
        except ModuleNotFoundError:
            assert hasattr(importlib.import_module(home), last), name


def test_scripts_of_make_can_be_imported():
    scripts = re.findall(r"-m (tests\.[\w.]+)", (ROOT / "Makefile").read_text("utf-8"))
    assert len({importlib.import_module(name).main for name in scripts}) == 3


def test_make_commands_are_valid():
    makefile = (ROOT / "Makefile").read_text("utf-8")
    targets = re.findall(r"^([\w%][\w% -]*):", makefile, re.MULTILINE)
    known = [name.replace("%", r"\w+") for names in targets for name in names.split()]
    orders = [word for word in quoted(BOTH) if word.startswith("make ")]
    orders += re.findall(r"^\$ (make [^#\n]*)", BOTH, re.MULTILINE)
    assert len(orders) > 20
    for order in orders:
        target, *more = order.split()[1:]
        assert re.fullmatch("|".join(known), target), order
        for setting in more:
            name, given, _ = setting.partition("=")
            assert not given or f"$({name})" in makefile or f"{name})" in makefile, (
                order
            )
    listed = subprocess.run(
        ["make", "-s", "help"], cwd=ROOT, capture_output=True, text=True, check=True
    ).stdout
    assert len(listed.splitlines()) > 5
    for line in listed.splitlines():
        name = line.split()[0].partition("%")[0]
        assert re.search(rf"`make {name}", README), f"README does not list {line}"


ORDERS = re.findall(r"^\$ raxel (.*)|`raxel (\w+ .*?)`", README, re.MULTILINE)


@pytest.mark.parametrize("order", ORDERS)
def test_raxel_commands_are_valid(order):
    command, *words = shlex.split("".join(order))
    PROGRAM.commands[command].make_context(command, words)
