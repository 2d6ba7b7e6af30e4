"""Statements of the thesis: their claims, and the verdict that follows from them."""

from collections import Counter

import pytest

from repro.judge import ledger
from repro.judge.scoreboard import concluded, read_statements
from tests.scoreboard_rows import ROOT, row


def test_statements_cover_goals_contributions_and_claims_of_chapter_6():
    statements = read_statements(ROOT)
    kinds = Counter(one["kind"] for one in statements)
    numbers = [kinds[f"{size} contribution"] for size in ("major", "minor")]
    assert [kinds["goal"], *numbers] == [5, 3, 5]
    used = {claim for one in statements for claim in one["claims"]}
    claims = ledger.load(ROOT).claims
    assert {c for c, e in claims.items() if e["section"].startswith("6")} <= used
    for one in statements:
        leading = one.get("leading", {}).get("claim")
        assert (leading in one["claims"]) is (one["kind"] == "goal"), one["id"]


LOOSE = {"firmness": "some readings", "agree": [1, 2]}


@pytest.mark.parametrize(
    ("verdicts", "last", "verdict", "firmness"),
    [
        (["reproduced", "reproduced"], {}, "reproduced", "all readings"),
        (["reproduced", "reproduced"], LOOSE, "reproduced", "some readings"),
        (["undecided", "differs", "reproduced"], LOOSE, "differs", "all readings"),
        (["reproduced", "undecided"], {}, "undecided", None),
        (["reproduced", "not comparable"], {}, "undecided", None),
        (["quick", "not comparable"], {}, "quick", None),
        (["differs", "not yet"], {}, "not yet", None),
    ],
)
def test_statement_follows_from_claims(verdicts, last, verdict, firmness):
    rows = [row(f"c{n}", verdict=one) for n, one in enumerate(verdicts)]
    rows[-1] |= last
    (found,) = concluded([{"claims": [one["id"] for one in rows]}], rows)
    assert (found["verdict"], found["firmness"]) == (verdict, firmness)
