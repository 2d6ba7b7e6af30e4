"""The rules of the verdict, branch by branch, on a ledger of a few entries."""

import json
from collections import Counter
from pathlib import Path

import pytest

from raxel.errors import InputError
from repro.judge import ledger, verdict
from repro.judge.number_rules import VerdictError, equal_as_printed, half_last_digit
from repro.run.outcomes import Reading

ROOT = Path(__file__).resolve().parents[1]
PAGE = "ch02_one/s1"


def number(value=640, comparator="eq", role="result", source="synthetic", unit="px"):
    return {
        "artefact": "fig_2_1",
        "value": value,
        "unit": unit,
        "comparator": comparator,
        "role": role,
        "source": source,
    }


def claim(*artefacts):
    return {"section": "2.1", "artefacts": list(artefacts), "statement": "It grows."}


def artefact(data="synthetic", chapter=2):
    return {"title": "A plot", "chapter": chapter, "data": data}


def question(*options):
    return {"options": list(options), "primary": options[0]}


def small(**kinds):
    """A ledger of the given entries; the questions noise and extent are open."""
    kinds.setdefault("artefacts", {"fig_2_1": artefact()})
    open_questions = {
        "noise": question("px", "mm"),
        "extent": question("unbounded", "finite"),
    }
    empty = {key: {} for key in ("numbers", "claims", "settings", "sections")}
    return ledger.Ledger(**{"readings": open_questions, **empty, **kinds})


def judged(page=PAGE, effort="full", claims=None, numbers=None, artefacts=None):
    return {
        "page": page,
        "effort": effort,
        "claims": claims or {},
        "numbers": numbers or {},
        "artefacts": artefacts or {},
    }


def value(found, interval=None, unit="", reason="", evidence="synthetic"):
    return {
        "value": found,
        "interval": interval,
        "unit": unit,
        "reason": reason,
        "evidence": evidence,
        "data": ["results/sweep.json"],
    }


def readings(*outcomes, evidence="synthetic"):
    """Judged claim from (verdict, options) pairs."""
    made = [
        Reading(v, i, reading=r, reason="slope") for i, (v, r) in enumerate(outcomes)
    ]
    return {
        "evidence": evidence,
        "readings": [r.as_dict() for r in made],
        "data": ["results/sweep.json"],
    }


def drawn(check=None, evidence="synthetic"):
    files = [f"figures/full/fig_2_1.{ending}" for ending in ("svg", "csv")]
    return {"evidence": evidence, "files": files, "check": check}


def by_id(book, *pages, effort="full", unfinished=None):
    missing = {"2": "the rest"} if unfinished is None else unfinished
    return {r["id"]: r for r in verdict.rows(book, pages, missing, effort)}


def of_number(entry, found, effort="full"):
    book = small(numbers={"n": entry})
    return by_id(book, judged(effort=effort, numbers={"n": found}), effort=effort)["n"]


NUMBERS = {
    "setting run as stated": (number(role="setting"), value(640), "setting"),
    "setting as a float": (number(role="setting"), value(640.0), "setting"),
    "setting run otherwise": (number(role="setting"), value(641), "setting"),
    "setting of hardware": (
        number(role="setting", source="real"), value(640), "setting",
    ),
    "setting in words": (number("7x5", role="setting"), value("7 x 5"), "setting"),
    "setting in other words": (number("7x5", role="setting"), value("5x7"), "setting"),
    "analytic count": (
        number(12, role="analytic", unit="count"), value(12), "reproduced",
    ),
    "analytic count, not whole": (
        number(12, role="analytic", unit="count"), value(12.2), "differs",
    ),
    "analytic at the printed precision": (
        number(0.46, role="analytic"), value(0.4649), "reproduced",
    ),
    "analytic beyond it": (number(0.46, role="analytic"), value(0.4651), "differs"),
    "analytic zero": (number(0, role="analytic"), value(1e-12), "reproduced"),
    "analytic, not quite zero": (number(0, role="analytic"), value(1e-3), "differs"),
    "analytic formula": (number("6*(n-1)", role="analytic"), value("6 * (n-1)"),
                         "reproduced"),
    "analytic bound": (number(8, "le", role="analytic"), value(8), "reproduced"),
    "analytic bound broken": (number(8, "le", role="analytic"), value(9), "differs"),
    "result inside": (number(26), value(27, (25, 29)), "reproduced"),
    "result about": (number(4, "approx"), value(4.5, (3.9, 5)), "reproduced"),
    "result outside": (number(26), value(27, (26.5, 29)), "differs"),
    "result with an open interval": (number(26), value(27, (25, "inf")), "reproduced"),
    "below": (number(6.5, "lt"), value(6, (5, 6.4)), "reproduced"),
    "not below": (number(6.5, "lt"), value(7, (6.5, 8)), "differs"),
    "perhaps below": (number(6.5, "lt"), value(6, (5, 6.5)), "undecided"),
    "at most": (number(6.5, "le"), value(6, (5, 6.5)), "reproduced"),
    "not at most": (number(6.5, "le"), value(7, (6.6, 7)), "differs"),
    "above": (number(48, "gt"), value(50, (49, 51)), "reproduced"),
    "not above": (number(48, "gt"), value(40, (39, 48)), "differs"),
    "perhaps above": (number(48, "gt"), value(49, (47, 51)), "undecided"),
    "at least": (number(48, "ge"), value(48), "reproduced"),
    "on hardware": (number(0.1, source="real"), value(0.2), "counterpart"),
    "a bound on hardware": (
        number(0.1, "lt", source="real"), value(0.2), "counterpart",
    ),
    "on hardware, zero": (number(0.0, source="real"), value(0.2), "counterpart"),
    "cell lost": (number(None, source="real"), value(0.2), "not comparable"),
    "cited": (number(30000, "gt", "literature", "real"), value(1), "not comparable"),
}  # fmt: skip


@pytest.mark.parametrize("name", NUMBERS)
def test_a_number_is_judged_by_role_source_and_comparator(name):
    entry, found, expected = NUMBERS[name]
    row = of_number(entry, found)
    assert row["verdict"] == expected
    assert row["published"] == entry["value"]
    assert row["unit"] == "px" or entry["unit"] == "count"
    if name != "cited":
        assert row["regenerated"] == found["value"]
        assert row["page"] == "ch02_one/s1.html"
        assert row["data"] == ["results/sweep.json"]
    if expected in ("differs", "undecided", "not comparable"):
        assert row["reason"]


def test_a_counterpart_says_the_ratio_and_the_remark():
    row = of_number(number(0.1, source="real"), value(0.25, reason="three seeds"))
    assert row["reason"] == "regenerated / published = 2.5; three seeds"
    row = of_number(number(0, source="real"), value(0.25))
    assert row["reason"] == "no ratio to a published 0; difference 0.25"


@pytest.mark.parametrize(
    ("found", "line"),
    [
        (value(None), "value: found nothing"),
        (value(3, unit="mm"), "unit: found 'mm'; give it in px, as published"),
        (value(3), "interval: found none; a simulated result needs its 95 %"),
        (value(3, (4, 2)), r"interval: found \(4, 2\); give \[low, high\]"),
        (value(3, (None, 2)), "interval: found"),
    ],
)
def test_a_number_that_cannot_be_judged_is_an_error_of_one_line(found, line):
    with pytest.raises(VerdictError, match=rf"^{PAGE}: n: {line}"):
        of_number(number(), found)


@pytest.mark.parametrize(
    ("printed", "half"), [(0.46, 0.005), (12, 0.5), (1e-05, 5e-06), (30000, 0.5)]
)
def test_the_printed_precision_is_half_the_last_digit(printed, half):
    assert half_last_digit(printed) == pytest.approx(half)
    assert equal_as_printed(printed, printed + 0.9 * half, exact=False)
    assert not equal_as_printed(printed, printed + 1.1 * half, exact=False)


def of_claim(*outcomes, effort="full"):
    book = small(claims={"c": claim("fig_2_1")})
    page = judged(effort=effort, claims={"c": readings(*outcomes)})
    return by_id(book, page, effort=effort)["c"]


def test_a_claim_without_open_questions_has_one_reading():
    row = of_claim(("differs", {}))
    assert (row["verdict"], row["published"]) == ("differs", "It grows.")
    assert (row["variants"], row["reason"]) == ([], "slope")


def test_the_primary_reading_decides_and_the_others_stand_beside_it():
    row = of_claim(
        ("differs", {"noise": "mm", "extent": "unbounded"}),
        ("reproduced", {"noise": "px", "extent": "finite"}),
        ("reproduced", {"noise": "px", "extent": "unbounded"}),
        ("undecided", {"noise": "mm", "extent": "finite"}),
    )
    assert (row["verdict"], row["regenerated"]) == ("reproduced", 2)
    assert row["reason"] == "slope"
    assert [v["regenerated"] for v in row["variants"]] == [0, 1, 3]
    assert [v["verdict"] for v in row["variants"]] == [
        "differs", "reproduced", "undecided",
    ]  # fmt: skip


def test_a_claim_has_its_test_and_how_it_was_changed():
    told = {**claim("fig_2_1"), "test": "Slope >= 0.9.", "changed": "Once."}
    book = small(claims={"c": told})
    row = by_id(book, judged(claims={"c": readings(("differs", {}))}))["c"]
    assert (row["test"], row["changed"]) == ("Slope >= 0.9.", "Once.")
    assert of_claim(("differs", {}))["changed"] == ""


def test_readings_that_agree_need_no_remark():
    row = of_claim(("differs", {"noise": "px"}), ("differs", {"noise": "mm"}))
    assert row["reason"] == "slope"
    assert len(row["variants"]) == 1


@pytest.mark.parametrize(
    ("taken", "line"),
    [
        (({"noise": "px"},), "reading: {'noise': 'mm'} is missing; test it too"),
        (({"nois": "px"},), "found the question 'nois', .*; did you mean noise?"),
        (({"noise": "px"}, {"noise": "cm"}), "found {'noise': 'cm'}; every reading"),
        (({"noise": "px"}, {"extent": "finite"}), "found {'extent': 'finite'}; every"),
        (({"noise": "px"}, {"noise": "px"}), "found {'noise': 'px'} twice; give each"),
    ],
)
def test_readings_must_be_all_combinations_of_listed_options(taken, line):
    with pytest.raises(VerdictError, match=f"^{PAGE}: c: reading: .*|{line}") as error:
        of_claim(*(("reproduced", options) for options in taken))
    assert error.match(line)


def of_artefact(check=None, data="synthetic", effort="full", **verdicts):
    names = {f"c_{word}": claim("fig_2_1") for word in verdicts}
    book = small(artefacts={"fig_2_1": artefact(data)}, claims=names)
    page = judged(
        effort=effort,
        claims={
            f"c_{w}": readings((v, {})) for w, v in verdicts.items() if v != "not yet"
        },
        artefacts={"fig_2_1": drawn(check)},
    )
    return by_id(book, page, effort=effort)["fig_2_1"]


HOLDS = {"holds": True, "text": "equal to 1e-9"}
BROKEN = {"holds": False, "text": "off by 3 mm"}
ARTEFACTS = {
    "all claims hold": ({"a": "reproduced", "b": "reproduced"}, None, "reproduced"),
    "one differs": ({"a": "reproduced", "b": "differs"}, None, "differs"),
    "one is undecided": ({"a": "reproduced", "b": "undecided"}, None, "reproduced"),
    "one is not built": ({"a": "reproduced", "b": "not yet"}, None, "reproduced"),
    "none is decided": ({"a": "undecided"}, None, "counterpart"),
    "claims and check hold": ({"a": "reproduced"}, HOLDS, "reproduced"),
    "the check fails": ({"a": "reproduced"}, BROKEN, "differs"),
    "a claim differs, the check holds": ({"a": "differs"}, HOLDS, "differs"),
    "no claims, a check": ({}, HOLDS, "reproduced"),
    "no claims, a failed check": ({}, BROKEN, "differs"),
    "no claims, no check": ({}, None, "counterpart"),
}


@pytest.mark.parametrize("name", ARTEFACTS)
def test_an_artefact_follows_its_decided_claims_and_its_check(name):
    claims, check, expected = ARTEFACTS[name]
    row = of_artefact(check, **claims)
    assert row["verdict"] == expected
    assert row["data"] == ["figures/fig_2_1.svg", "figures/fig_2_1.csv"]
    assert row["published"] == "A plot"
    for word, outcome in claims.items():
        assert (f"c_{word}" in row["reason"]) == (outcome != "reproduced")
    if check:
        assert check["text"] in row["reason"]


def test_an_artefact_counts_its_decided_claims():
    row = of_artefact(a="reproduced", b="differs", c="undecided")
    assert row["regenerated"] == "1 of 2 decided claims reproduced"
    assert row["reason"] == "differs: c_b; undecided: c_c"


def test_a_schematic_without_claims_needs_a_check():
    with pytest.raises(VerdictError, match="check: found none; a drawing without"):
        of_artefact(data="illustration")


def test_an_artefact_that_nothing_draws_is_not_yet_whatever_its_claims():
    book = small(claims={"c": claim("fig_2_1")})
    page = judged(claims={"c": readings(("reproduced", {}))})
    row = by_id(book, page)["fig_2_1"]
    assert (row["verdict"], row["reason"]) == (
        "not yet",
        "still missing: the rest",
    )


SECTION = {"sec_2_1": {"title": "Pinhole"}}


@pytest.mark.parametrize(
    ("outcomes", "expected"),
    [
        (["reproduced", "undecided"], "reproduced"),
        (["reproduced", "differs"], "differs"),
        (["undecided"], "counterpart"),
        ([], "counterpart"),
    ],
)
def test_a_section_follows_its_claims(outcomes, expected):
    claims = {f"c{i}": claim("sec_2_1") for i, _ in enumerate(outcomes)}
    book = small(
        claims=claims,
        sections=SECTION,
        numbers={"n": {**number(role="setting"), "artefact": "sec_2_1"}},
    )
    found = {f"c{i}": readings((v, {})) for i, v in enumerate(outcomes)}
    page = judged(claims=found, numbers={"n": value(640, evidence="analytic")})
    row = by_id(book, page)["sec_2_1"]
    assert (row["verdict"], row["kind"]) == (expected, "section")
    assert row["published"] == "Pinhole"
    assert row["page"] == "ch02_one/s1.html"
    assert row["data"] == ["results/sweep.json"]
    assert row["evidence"] == ("synthetic" if outcomes else "analytic")


def test_a_section_of_cited_numbers_is_not_comparable():
    cited = {**number(role="literature", source="real"), "artefact": "sec_2_1"}
    book = small(numbers={"n": cited}, sections=SECTION)
    found = by_id(book)
    assert found["n"]["verdict"] == found["sec_2_1"]["verdict"] == "not comparable"
    assert found["n"]["reason"] == "literature: cited, not run"


def test_quick_rows_show_values_and_say_quick():
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


def test_not_yet_is_for_listed_chapters_only():
    book = small(numbers={"n": number()}, claims={"c": claim("fig_2_1")})
    assert {r["verdict"] for r in by_id(book).values()} == {"not yet"}
    line = r"^c: nothing produces it and chapter 2 counts as built; .* \(and 2 more\)$"
    with pytest.raises(VerdictError, match=line):
        by_id(book, unfinished={"3": "all"})


def test_a_missing_value_is_an_error_at_quick_size_too():
    with pytest.raises(VerdictError, match="chapter 2 counts as built"):
        by_id(small(), effort="quick", unfinished={})


@pytest.mark.parametrize(
    ("page", "line"),
    [
        (
            judged(claims={"c_one": readings(("differs", {}))}),
            "ch02_one/s1: c_one: no claim of the ledger; did you mean c_ones?",
        ),
        (
            judged(numbers={"zzz": value(1)}),
            "ch02_one/s1: zzz: no number of the ledger; what is not in the thesis is "
            "called ext_...",
        ),
        (
            judged(artefacts={"fig_2_11": drawn()}),
            "ch02_one/s1: fig_2_11: no artefact of the ledger; did you mean fig_2_1?",
        ),
        (
            judged(effort="quick"),
            "ch02_one/s1: effort: found 'quick' in a full build; delete the judged "
            "file",
        ),
    ],
)
def test_what_no_ledger_knows_is_an_error_with_a_suggestion(page, line):
    book = small(claims={"c_ones": claim("fig_2_1")}, numbers={"n": number()})
    with pytest.raises(VerdictError) as error:
        by_id(book, page)
    assert str(error.value) == line


def test_one_page_judges_an_entry():
    pages = [judged(p, artefacts={"fig_2_1": drawn()}) for p in ("ch02_one/s1", "b/s2")]
    with pytest.raises(
        VerdictError, match=r"^b/s2: fig_2_1: judged by ch02_one/s1 too"
    ):
        by_id(small(), *pages)


def test_extensions_get_no_row():
    page = judged(
        artefacts={"ext_fig": drawn(), "ext_corners@left": drawn()},
        numbers={"ext_n": value(None)},
    )
    assert list(by_id(small(), page)) == ["fig_2_1"]


def test_rows_have_the_fields_of_the_scoreboard_in_order():
    rows = verdict.rows(small(), [], {"2": "the rest"}, "full")
    assert list(rows[0]) == [
        "id", "kind", "chapter", "verdict", "evidence", "effort", "published",
        "regenerated", "interval", "unit", "reason", "test", "changed",
        "variants", "page", "data",
    ]  # fmt: skip


def test_with_nothing_judged_everything_that_can_be_run_is_not_yet():
    unfinished = dict.fromkeys("123456A", "all")
    rows = verdict.rows(ledger.load(ROOT), [], unfinished, "full")
    assert Counter(row["kind"] for row in rows) == {
        "artefact": 88,
        "number": 507,
        "claim": 227,
        "section": 25,
    }
    others = {row["id"]: row["verdict"] for row in rows if row["verdict"] != "not yet"}
    # A number that the thesis cites is produced by nothing, now or later.
    assert others == {"s1_2_3_pairs": "not comparable", "sec_1_2_3": "not comparable"}


def test_judged_files_are_read_in_order_and_checked(tmp_path):
    folder = tmp_path / "judged"
    for name in ("b/s1", "a/s2"):
        path = folder / f"{name}.json"
        path.parent.mkdir(parents=True)
        path.write_text(json.dumps(judged(name)))
    assert [c["page"] for c in verdict.read_judged(folder)] == ["a/s2", "b/s1"]
    assert verdict.read_judged(tmp_path / "nothing") == []

    content = judged("a/s2", claims={"c": readings(("differs", {}))})
    content["claims"]["c"]["readings"][0]["verdict"] = "holds"
    (folder / "a/s2.json").write_text(json.dumps(content))
    line = r"^a/s2.json: claims.c.readings.0.verdict: found 'holds'; give one of repro"
    with pytest.raises(VerdictError, match=line):
        verdict.read_judged(folder)
    (folder / "a/s2.json").write_text("{")
    with pytest.raises(VerdictError, match=r"^a/s2.json: not JSON .*; delete it$"):
        verdict.read_judged(folder)


def test_the_list_of_unfinished_chapters_is_checked(tmp_path):
    (tmp_path / "chapters").mkdir()
    path = tmp_path / "chapters/unfinished.yaml"
    path.write_text("2: the rest\nA: all\n")
    assert verdict.read_unfinished(tmp_path) == {"2": "the rest", "A": "all"}
    for text in ("7: all\n", "2:\n", "- 2\n", "2: [\n"):
        path.write_text(text)
        with pytest.raises(InputError, match=r"^unfinished.yaml: "):
            verdict.read_unfinished(tmp_path)


def test_a_setting_that_was_run_otherwise_says_so():
    row = of_number(number(role="setting"), value(641))
    assert row["verdict"] == "setting"
    assert row["reason"] == "run with 641, the text states 640"
