"""The scoreboard of a small checkout: what pages and the command show of it."""

import json

import pytest

from raxel.errors import InputError
from repro.judge import ledger, reference, scoreboard
from repro.judge.number_rules import VerdictError
from repro.page import rows as row_html
from repro.run.deciding import judged_with
from repro.run.discover import producers
from repro.run.results import write_atomic, write_json
from repro.site import scoreboard as board_page
from tests.scoreboard_rows import READING, ROOT, SECTION, Board


@pytest.fixture
def checkout(tmp_path):
    """The ledger, one chapter file, and its judged claims, number and artefact."""
    (tmp_path / "data").mkdir()
    (tmp_path / "data" / "published").symlink_to(ROOT / "data" / "published")
    write_atomic(
        tmp_path / "chapters" / "unfinished.yaml",
        "".join(f"'{c}': not built\n" for c in [*range(1, 7), "A"]),
    )
    write_atomic(tmp_path / "chapters" / SECTION / "page.py", CHAPTER)
    write_atomic(tmp_path / "chapters" / OTHER_PAGE / "page.py", OTHER)
    judged = {
        "page": SECTION,
        "effort": "full",
        "claims": {
            "c2_noise_linear_generic": claim(verdict="differs"),
            "c2_fov_persp_rises": claim(),
        },
        "numbers": {},
        "artefacts": {
            "fig_2_3": {
                "evidence": "synthetic",
                "files": ["figures/full/fig_2_3.csv"],
                "check": None,
            }
        },
    }
    other = {**judged, "page": OTHER_PAGE, "artefacts": {}}
    flat = claim(verdict="differs") | {"source": [f"{OTHER_PAGE}/page.py", "flat"]}
    other["claims"] = {"c2_fov_generic_flat": flat}
    folder = tmp_path / "figures" / "full" / "judged"
    write_json(folder / f"{SECTION}.json", judged)
    write_json(folder / f"{OTHER_PAGE}.json", other)
    return tmp_path


OTHER_PAGE = "ch02_general_camera_model/other"
CHAPTER = """# %% [markdown]
@figure("fig_2_3", needs=(), evidence="synthetic")
def fig_2_3(results):
    pass
"""
OTHER = """# %% [markdown]
@claim("c2_fov_generic_flat", needs=(), evidence="synthetic")
def flat(results):
    pass
"""


def claim(**changed):
    """A judged claim in one reading that leaves nothing open."""
    return {
        "evidence": "synthetic",
        "readings": [{**READING, "reading": {}, **changed}],
        "data": ["results/sweep.json"],
    }


def test_comparison_equals_board(checkout):
    folder = checkout / "figures" / "full" / "judged"
    board = scoreboard.rows_of(checkout, "full", folder)
    own = {"c2_noise_linear_generic", "c2_fov_persp_rises", "fig_2_3"}
    table = row_html.comparison_table(SECTION, "full", checkout)
    assert table == row_html.comparison(
        [r for r in board if r["id"] in own], "full", "../", row_html.words_of(board)
    )
    flat = f"../source/{OTHER_PAGE}/page.py.html#flat"
    assert flat not in Board(table).links
    shown = row_html.comparison_table(OTHER_PAGE, "full", checkout)
    assert {flat, "../provenance/sweep.html"} <= set(Board(shown).links)
    assert {a["data-id"] for a, _ in Board(table).rows} == own
    assert "../scoreboard.html#fig_2_3" in Board(table).links
    book = ledger.load(checkout)
    assert judged_with(producers(checkout), SECTION, book) == [SECTION, OTHER_PAGE]
    assert judged_with(producers(checkout), OTHER_PAGE, book) == [OTHER_PAGE]


def test_comparison_does_not_need_other_chapters(checkout):
    write_atomic(checkout / "chapters" / "unfinished.yaml", "{}\n")
    assert "c2_fov_persp_rises" in row_html.comparison_table(SECTION, "full", checkout)
    with pytest.raises(VerdictError):
        scoreboard.rows_of(checkout, "full", checkout / "figures" / "full" / "judged")


def test_quick_board_has_no_verdicts(checkout):
    for path in (checkout / "figures" / "full" / "judged").rglob("*.json"):
        content = json.loads(path.read_text("utf-8")) | {"effort": "quick"}
        name = path.relative_to(checkout / "figures" / "full")
        write_json(checkout / "figures" / "quick" / name, content)
    table = row_html.comparison_table(SECTION, "quick", checkout)
    assert "Verdicts are given at full size only" in " ".join(table.split())
    assert {a["data-verdict"] for a, _ in Board(table).rows} == {"quick"}
    assert "0.980 " in table


def test_board_and_page_are_written_or_none(checkout):
    files = checkout / "b.json", checkout / "b.md"

    def write():
        judged = checkout / "figures" / "full" / "judged"
        board_page.write_board(checkout, "full", judged, *files)
        return [path.read_text("utf-8") for path in files]

    rows, page = write()
    book = ledger.load(checkout)
    every = {*book.artefacts, *book.numbers, *book.claims, *book.sections}
    assert {r["id"] for r in json.loads(rows)} == every
    assert {a["id"] for a, _ in Board(page).rows} == every
    assert len(page.encode()) < 1.2e6
    assert write() == [rows, page]

    files[0].unlink()
    write_atomic(checkout / "chapters" / "unfinished.yaml", "{}\n")
    with pytest.raises(InputError):
        write()
    assert not files[0].exists()


def test_changed_verdict_fails_comparison(checkout, monkeypatch, capsys):
    monkeypatch.chdir(checkout)
    base = checkout / "figures" / "full"
    accepted = checkout / "data" / "reference" / "full.csv"
    accepted.parent.mkdir()

    def made(action):
        return reference.main([action]), *capsys.readouterr()

    assert made("compare")[2] == (
        "make compare: no finished full build; run make report\n"
    )
    write_json(base / "scoreboard.json", [])
    assert made("compare")[2].endswith("no reference; run make reference\n")
    assert made("reference")[0] == 0
    status, out, _ = made("compare")
    assert (status, out[:5]) == (0, "0 of ")
    path = base / "judged" / f"{OTHER_PAGE}.json"
    judged = json.loads(path.read_text("utf-8"))
    judged["claims"]["c2_fov_generic_flat"] = claim(verdict="reproduced")
    write_json(path, judged)
    status, out, fault = made("compare")
    assert status == 1
    assert "\nc2_fov_generic_flat: differs -> reproduced\n" in f"\n{out}"
    assert fault.count("\n") == 1
