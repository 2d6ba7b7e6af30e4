"""Rows of the scoreboard from what pages judged, and the files they come from."""

import json
from collections import Counter

import pytest

from raxel.errors import InputError
from repro.judge import ledger, verdict
from repro.judge.number_rules import VerdictError
from tests.sample_files import write
from tests.verdict_books import (
    ROOT,
    by_id,
    claim,
    drawn,
    judged,
    number,
    of_artefact,
    of_claim,
    of_number,
    readings,
    small,
    value,
)


def test_quick_rows_have_values_without_verdict():
    row = of_claim(
        ("differs", {"noise": "mm"}), ("reproduced", {"noise": "px"}), effort="quick"
    )
    assert (row["verdict"], row["effort"], row["regenerated"]) == ("quick", "quick", 1)
    assert [v["verdict"] for v in row["variants"]] == ["quick"]
    assert "agree" not in row["reason"]
    row = of_number(number(role="setting"), value(4, reason="few"), effort="quick")
    assert (row["verdict"], row["regenerated"], row["reason"]) == ("quick", 4, "few")
    row = of_artefact(a="differs", effort="quick")
    assert (row["verdict"], row["regenerated"], row["reason"]) == ("quick", None, "")
    book = small()
    assert by_id(book, effort="quick")["fig_2_1"]["verdict"] == "not yet"


@pytest.mark.parametrize("effort", ["quick", "full"])
def test_infinite_number_has_no_ratio(effort):
    """Infinity is written as a word; the row says what it stands for."""
    entry = number(value=7.85, source="real")
    row = of_number(entry, value("inf", ["inf", "inf"]), effort=effort)
    assert (row["regenerated"], row["ratio"]) == ("inf", None)
    assert ("half of the trials" in row["reason"]) == (effort == "full")
    row = of_number(entry, value(3.925, [3, 4]))
    assert (row["verdict"], row["ratio"]) == ("counterpart", 0.5)


def test_not_yet_requires_listed_chapter():
    book = small(numbers={"n": number()}, claims={"c": claim("fig_2_1")})
    assert {r["verdict"] for r in by_id(book).values()} == {"not yet"}
    line = r"^c: no producer, and chapter 2 counts as built; .* \(and 2 more\)$"
    with pytest.raises(VerdictError, match=line):
        by_id(book, unfinished={"3": "all"})


def test_missing_value_is_rejected_in_quick_build():
    with pytest.raises(VerdictError, match="chapter 2 counts as built"):
        by_id(small(), effort="quick", unfinished={})


@pytest.mark.parametrize(
    ("page", "line"),
    [
        (
            judged(claims={"c_one": readings(("differs", {}))}),
            "ch02_one/s1: c_one: not in the claims of the ledger; did you mean c_ones?",
        ),
        (
            judged(numbers={"zzz": value(1)}),
            "ch02_one/s1: zzz: not in the numbers of the ledger; names outside the "
            "thesis begin with ext_",
        ),
        (
            judged(artefacts={"fig_2_11": drawn()}),
            "ch02_one/s1: fig_2_11: not in the artefacts of the ledger; did you mean "
            "fig_2_1?",
        ),
        (
            judged(effort="quick"),
            "ch02_one/s1: effort: found 'quick' in a full build; delete the judged "
            "file",
        ),
    ],
)
def test_unknown_ids_are_rejected_with_suggestion(page, line):
    book = small(claims={"c_ones": claim("fig_2_1")}, numbers={"n": number()})
    with pytest.raises(VerdictError) as error:
        by_id(book, page)
    assert str(error.value) == line


def test_entry_judged_twice_is_rejected():
    pages = [judged(p, artefacts={"fig_2_1": drawn()}) for p in ("ch02_one/s1", "b/s2")]
    with pytest.raises(
        VerdictError, match=r"^b/s2: fig_2_1: also judged by ch02_one/s1"
    ):
        by_id(small(), *pages)


def test_extensions_have_no_row():
    page = judged(
        artefacts={"ext_fig": drawn(), "ext_corners@left": drawn()},
        numbers={"ext_n": value(None)},
    )
    assert list(by_id(small(), page)) == ["fig_2_1"]


def test_rows_have_scoreboard_fields_in_order():
    rows = verdict.rows(small(), [], {"2": "the rest"}, "full")
    assert list(rows[0]) == [
        "id", "kind", "chapter", "words", "conditions", "verdict", "firmness",
        "agree", "few_seeds", "evidence", "effort", "published", "regenerated",
        "interval", "ratio", "unit", "reason", "test", "changed", "variants", "page",
        "source", "data",
    ]  # fmt: skip


def test_entries_without_result_are_not_yet():
    unfinished = dict.fromkeys("123456A", "all")
    rows = verdict.rows(ledger.load(ROOT), [], unfinished, "full")
    assert Counter(row["kind"] for row in rows) == {
        "artefact": 88,
        "number": 512,
        "claim": 233,
        "section": 25,
    }
    others = {row["id"]: row["verdict"] for row in rows if row["verdict"] != "not yet"}
    # A number that the thesis cites is produced by nothing, now or later.
    assert others == {"s1_2_3_pairs": "not comparable", "sec_1_2_3": "not comparable"}


def test_judged_files_are_read_in_order_and_validated(tmp_path):
    folder = tmp_path / "judged"
    for name in ("b/s1", "a/s2"):
        write(folder / f"{name}.json", json.dumps(judged(name)))
    assert [c["page"] for c in verdict.read_judged(folder)] == ["a/s2", "b/s1"]
    assert verdict.read_judged(tmp_path / "nothing") == []

    content = judged("a/s2", claims={"c": readings(("differs", {}))})
    content["claims"]["c"]["readings"][0]["verdict"] = "holds"
    (folder / "a/s2.json").write_text(json.dumps(content))
    line = r"^a/s2.json: claims.c.readings\[0\].verdict: found 'holds'; give enum"
    with pytest.raises(VerdictError, match=line):
        verdict.read_judged(folder)
    (folder / "a/s2.json").write_text("{")
    with pytest.raises(VerdictError, match=r"^a/s2.json: not JSON .*; delete it$"):
        verdict.read_judged(folder)
    # A page reads only its files; another job may be writing the others.
    assert [c["page"] for c in verdict.read_judged(folder, ["b/s1"])] == ["b/s1"]


def test_unfinished_chapters_are_validated(tmp_path):
    (tmp_path / "chapters").mkdir()
    path = tmp_path / "chapters/unfinished.yaml"
    path.write_text('"2": the rest\nA: all\n')
    assert verdict.read_unfinished(tmp_path) == {"2": "the rest", "A": "all"}
    for text in ('"7": all\n', "A:\n", "2: all\n", "- 2\n", "2: [\n"):
        path.write_text(text)
        with pytest.raises(InputError, match=r"^unfinished.yaml: "):
            verdict.read_unfinished(tmp_path)


def test_setting_with_other_value_states_it():
    row = of_number(number(role="setting"), value(641))
    assert row["verdict"] == "setting"
    assert row["reason"] == "run with 641, the text states 640"
