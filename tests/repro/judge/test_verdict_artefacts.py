"""Verdicts on artefacts and sections, which follow those of their claims."""

import pytest

from repro.judge.number_rules import VerdictError
from tests.verdict_books import (
    by_id,
    claim,
    drawn,
    judged,
    number,
    of_artefact,
    readings,
    small,
    value,
)

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
def test_artefact_follows_claims_and_check(name):
    claims, check, expected = ARTEFACTS[name]
    row = of_artefact(check, **claims)
    assert row["verdict"] == expected
    assert row["data"] == ["figures/fig_2_1.svg", "figures/fig_2_1.csv"]
    assert row["published"] == "A plot"
    for word, outcome in claims.items():
        assert (f"c_{word}" in row["reason"]) == (outcome != "reproduced")
    if check:
        assert check["text"] in row["reason"]


def test_artefact_counts_decided_claims():
    row = of_artefact(a="reproduced", b="differs", c="undecided")
    assert row["regenerated"] == "1 of 2 decided claims reproduced"
    assert row["reason"] == "differs: c_b; undecided: c_c"


OPEN = ({"noise": "px"}, {"noise": "mm"})
FIRM = {
    "all hold in all readings": (("RR", "RR"), None, "all readings", [2, 2]),
    "one depends on the reading": (("RR", "RD"), None, "some readings", [1, 2]),
    "one differs in all readings": (("RD", "DD"), None, "all readings", [1, 2]),
    "one differs in one reading": (("RR", "DR"), None, "some readings", [1, 2]),
    "all depend on the reading": (("RD",), None, "no claim", [0, 1]),
    "all that differ may hold": (("DR", "RD"), None, "no claim", [0, 2]),
    "open, and may differ": (("RR", "UD"), None, "some readings", [1, 2]),
    "none is decided": (("UU",), None, None, None),
    "the check fails": (("RD",), BROKEN, "all readings", None),
    "drawn as computed": ((), HOLDS, "all readings", None),
}


def test_not_comparable_claim_does_not_decide_artefact():
    claims = {name: claim("fig_2_1") for name in ("c0", "c1")}
    found = {"c0": readings(("not comparable", {})), "c1": readings(("reproduced", {}))}
    page = judged(claims=found, artefacts={"fig_2_1": drawn(None)})
    row = by_id(small(claims=claims), page)["fig_2_1"]
    assert (row["verdict"], row["agree"]) == ("reproduced", [1, 1])
    assert row["regenerated"] == "1 of 1 decided claims reproduced"
    assert row["reason"] == "not comparable: c0"


@pytest.mark.parametrize("name", FIRM)
def test_artefact_firmness_follows_claims(name):
    outcomes, check, firmness, agree = FIRM[name]
    words = {"R": "reproduced", "D": "differs", "U": "undecided"}
    claims = {f"c{i}": claim("fig_2_1") for i, _ in enumerate(outcomes)}
    found = {
        f"c{i}": readings(*((words[v], o) for v, o in zip(both, OPEN, strict=True)))
        for i, both in enumerate(outcomes)
    }
    page = judged(claims=found, artefacts={"fig_2_1": drawn(check)})
    row = by_id(small(claims=claims), page)["fig_2_1"]
    assert (row["firmness"], row["agree"]) == (firmness, agree)
    loose = [i for i, both in enumerate(outcomes) if both[0] != both[1]]
    assert row["reason"].count(", not firm: c") == len(loose)
    assert all(
        f"{words[outcomes[i][0]]}, not firm: c{i}" in row["reason"] for i in loose
    )
    row = by_id(small(claims=claims), page | {"effort": "quick"}, effort="quick")
    assert row["fig_2_1"]["agree"] is row["fig_2_1"]["firmness"] is None


def test_illustration_without_claims_requires_check():
    with pytest.raises(VerdictError, match="check: missing; a drawing without"):
        of_artefact(data="illustration")


def test_artefact_without_drawing_is_not_yet():
    book = small(claims={"c": claim("fig_2_1")})
    page = judged(claims={"c": readings(("reproduced", {}))})
    row = by_id(book, page)["fig_2_1"]
    assert (row["verdict"], row["reason"]) == ("not yet", "still missing: the rest")


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
def test_section_follows_claims(outcomes, expected):
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
    assert (row["published"], row["page"]) == ("Pinhole", "ch02_one/s1.html")
    assert row["data"] == ["results/sweep.json"]
    assert row["evidence"] == ("synthetic" if outcomes else "analytic")


def test_section_of_cited_numbers_is_not_comparable():
    cited = {**number(role="literature", source="real"), "artefact": "sec_2_1"}
    book = small(numbers={"n": cited}, sections=SECTION)
    found = by_id(book)
    assert found["n"]["verdict"] == found["sec_2_1"]["verdict"] == "not comparable"
    assert found["n"]["reason"] == "literature: cited, not run"
