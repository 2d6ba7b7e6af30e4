"""Sets of boards and of active grids have pages of their own kind, and meet nowhere."""

import pytest

from repro.run.sets_of_report import target_kind
from repro.workflow.work import Work
from tests.active_grids import drawn
from tests.image_sets import write_drawn_set
from tests.raxel.cli.test_cli_active_grid import recorded
from tests.small_checkouts import ROOT


@pytest.fixture
def work(tmp_path):
    recorded(tmp_path / "grid", drawn(noise=1.0))
    write_drawn_set(tmp_path / "board", tilts=((0, 0), (25, 0)))
    names = ("grid", "board")
    return Work(ROOT, "quick", None, {name: str(tmp_path / name) for name in names})


def test_sets_have_one_page(work):
    assert work.target_kinds == {"grid": "active_grid", "board": "chessboard"}
    pages = {page.set: page.stem for page in work.pages.values() if page.set}
    assert pages == {"grid": "photographs/active_grid", "board": "photographs/set"}
    made = {i for _, i in work.producers if "@" in i}
    assert {"ext_grid_places@grid", "ext_models@board"} <= made
    assert not {"ext_grid_places@board", "ext_models@grid"} & made


def test_artefact_of_all_sets_reads_its_kind(work):
    read = [i for i in work.needed("table", "ext_methods") if "@" in i]
    assert read == ["photograph_study@board"]
    assert work._sets_option([("table", "ext_methods")]) == "--sets board"
    assert work.needed("table", "ext_grid_views@grid") == ["active_grid_study@grid"]


def test_unreadable_set_has_no_kind(tmp_path):
    assert target_kind(tmp_path) == ""
    (tmp_path / "set.yaml").write_text("[1, 2]")
    assert target_kind(tmp_path) == ""
