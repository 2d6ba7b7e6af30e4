"""A quick build of the whole report, and checks on its numbers, links and pages."""

import json
import os
import subprocess
import sys
from functools import cache
from pathlib import Path

import nbformat
import pytest

from repro.judge.ledger import read_yaml
from repro.page.execute import CELL_SECONDS
from repro.page.notebook import execute
from repro.page.questions import exercises_of
from repro.run.discover import page_files, page_id
from repro.site.check import check_site
from tests.repro.page.test_page_form import HEADINGS

ROOT = Path(__file__).resolve().parents[3]
FIGURES = ROOT / "figures" / "quick"
SITE = ROOT / "report" / "site-quick"


def build() -> subprocess.CompletedProcess:
    path = f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}"
    environment = os.environ | {"PATH": path, "XDG_CACHE_HOME": str(ROOT / ".cache")}
    return subprocess.run(
        [sys.executable, "-m", "repro.workflow.build", "quick", "--effort", "quick"],
        cwd=ROOT, env=environment, capture_output=True, text=True, check=False,
    )  # fmt: skip


@pytest.fixture(scope="module")
def report() -> Path:
    done = build()
    assert done.returncode == 0, done.stderr[-3000:]
    return SITE


def test_second_build_has_no_jobs(report):
    done = build()
    assert done.returncode == 0
    assert "Nothing changed" in done.stderr
    assert "[" not in done.stderr.replace("[markdown]", "")


def test_site_links_are_valid_and_local(report):
    assert check_site(report) == []


def test_notebooks_run_in_their_folder(report, tmp_path, monkeypatch):
    # The build has checked the ledger and the judgements. To read and check them again
    # for each notebook would be half of the time, and so would be what each shell does
    # when it ends: collect the garbage of this process.
    monkeypatch.setattr("raxel.io.documents.faults", lambda *given: [])
    monkeypatch.setattr("repro.judge.ledger.read_yaml", cache(read_yaml))
    monkeypatch.setattr("gc.collect", lambda: 0)
    monkeypatch.setattr(sys, "path", [*sys.path])
    monkeypatch.delenv("JPY_SESSION_NAME", raising=False)
    books = sorted((report / "notebooks").glob("*/*.ipynb"))
    assert len(books) == len(page_files(ROOT))
    for place, path in enumerate(books):
        # As Jupyter starts it; and the first from somewhere else.
        monkeypatch.chdir(path.parent if place else tmp_path)
        book = nbformat.read(path, as_version=4)
        for cell in book.cells:
            cell.outputs = []
        execute(book, path, ROOT, {}, CELL_SECONDS)
        assert Path.cwd() == ROOT
        open_yet = sum("Your turn" in str(cell.get("outputs")) for cell in book.cells)
        assert open_yet == len(exercises_of(book)), path.name


def test_chapter_pages_are_in_site(report):
    for path in page_files(ROOT):
        name = page_id(ROOT, path)
        if not name.startswith("ch"):
            continue
        page = (report / f"{name}.html").read_text("utf-8")
        places = [page.find(f"<h2>{heading}") for heading in HEADINGS]
        assert all(place > 0 for place in places), (name, places)
        assert places == sorted(places), name


def test_quick_scoreboard_is_complete_without_verdicts(report):
    rows = json.loads((report / "scoreboard.json").read_text("utf-8"))
    kinds = [row["kind"] for row in rows]
    counts = {kind: kinds.count(kind) for kind in ("artefact", "number", "claim")}
    assert counts == {"artefact": 88, "number": 512, "claim": 233}
    assert len({(row["kind"], row["id"]) for row in rows}) == len(rows)
    assert {row["verdict"] for row in rows} <= {"quick", "not yet", "not comparable"}
    built = {row["id"]: row for row in rows if row["verdict"] == "quick"}
    assert {"fig_2_3", "table_2_1", "c2_crossover"} <= set(built)
    assert built["c2_crossover"]["regenerated"]
    assert all(row["source"] for row in rows if row["regenerated"] is not None)


def test_results_state_their_origin(report):
    for path in sorted((FIGURES / "results").glob("*.json")):
        if path.name.endswith(".run.json"):
            continue
        content = json.loads(
            path.read_text("utf-8"), parse_constant=lambda name: pytest.fail(name)
        )
        assert {"experiment", "artefact", "effort", "code", "seed", "inputs"} <= set(
            content
        )
        assert str(ROOT) not in path.read_text("utf-8")
        run = json.loads(path.with_suffix(".run.json").read_text("utf-8"))
        assert {"seconds", "host", "versions"} <= set(run)


def test_figures_come_with_data_and_description(report):
    for path in sorted(FIGURES.glob("*.json")):
        about = json.loads(path.read_text("utf-8"))
        if "caption" not in about:
            continue
        assert about["caption"]
        assert path.with_suffix(".csv").stat().st_size > 20
        if about["kind"] == "figure":
            assert path.with_suffix(".svg").read_text("utf-8").startswith("<?xml")
            assert path.with_suffix(".png").read_bytes()[:4] == b"\x89PNG"
