"""Only figures and tables may show printed numbers next to their results."""

import csv
import inspect

import pytest

from repro.judge.ledger import LedgerError, load
from repro.page import draw
from repro.run import discover, jobs, marks
from repro.run.jobs import Size
from repro.workflow.plan import BuildPlan
from tests.sample_files import write
from tests.small_checkouts import ROOT

CHAPTER = """
from repro.run.marks import table
from repro.run.outcomes import Table


@table("ext_beside", evidence="analytic", published=("NAME",))
def ext_beside(results, published):
    return Table({"printed": list(published.values())}, "Caption.")
"""


@pytest.fixture
def checkout(tmp_path):
    """A checkout with the ledger and one table that uses a printed number."""

    def made(name):
        page = tmp_path / "chapters/ch09_try/s9_beside/page.py"
        write(page, CHAPTER.replace("NAME", name))
        ledger = tmp_path / "data" / "published"
        ledger.mkdir(parents=True)
        for file in (ROOT / "data" / "published").glob("*.yaml"):
            (ledger / file.name).write_bytes(file.read_bytes())
        return tmp_path

    return made


def filled(root, monkeypatch):
    names = {}
    (found,) = discover.producers(root)
    source = (root / "chapters" / found.path).read_text()
    exec(compile(source, found.path, "exec"), names)
    monkeypatch.setattr(jobs, "function_of", lambda found: names[found.function])
    out = root / "ext_beside.json"
    draw.draw(root, "table", "ext_beside", root, out)
    with out.with_suffix(".csv").open(newline="") as file:
        return list(csv.reader(file))


def test_table_gets_its_printed_numbers(checkout, monkeypatch):
    rows = filled(checkout("s3_3_1_noise_fail"), monkeypatch)
    assert rows == [["printed"], ["26"]]


def test_unknown_printed_number_is_rejected(checkout, monkeypatch):
    with pytest.raises(
        LedgerError, match="s3_3_1_noise_fial: published: not in numbers"
    ):
        filled(checkout("s3_3_1_noise_fial"), monkeypatch)


def test_changed_printed_value_rebuilds_table(checkout):
    root = checkout("s3_3_1_noise_fail")
    key = BuildPlan(root, Size("full")).tasks["table/ext_beside"].key()
    numbers = root / "data" / "published" / "numbers.yaml"
    numbers.write_text(numbers.read_text().replace("  value: 26\n", "  value: 27\n"))
    assert BuildPlan(root, Size("full")).tasks["table/ext_beside"].key() != key


@pytest.mark.parametrize("kind", ["experiment", "claim", "numbers"])
def test_experiments_and_claims_cannot_use_printed_numbers(kind):
    assert "published" not in inspect.signature(getattr(marks, kind)).parameters


def test_printed_numbers_reach_figures_and_tables_only():
    for found in discover.producers(ROOT):
        if found.published:
            assert found.kind in ("figure", "table"), found.id
            load(ROOT).printed(found.published)
