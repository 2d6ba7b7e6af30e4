"""The scoreboard: its rows, their order, its page."""

import json
import re

import pytest

from repro.judge import scoreboard
from repro.judge.number_rules import VerdictError
from repro.page import rows as row_html
from repro.site import scoreboard as board_page
from tests.scoreboard_rows import ROOT, SECTION, Board, row, variant


@pytest.mark.parametrize(
    ("changed", "complaint"),
    [
        ({"verdict": "fine"}, "c2_one.verdict: found 'fine'"),
        ({"regenerated": None}, "c2_one.regenerated: found null"),
        ({"regenerated": float("nan")}, "c2_one.regenerated: found nan"),
        ({"verdict": "not comparable", "reason": ""}, "c2_one.reason: found ''"),
        ({"verdict": "quick"}, "c2_one.verdict"),
        ({"effort": "quick"}, "c2_one.verdict"),
        ({"interval": [1.0]}, "c2_one.interval"),
        ({"page": "/etc/passwd.html"}, "c2_one.page"),
        ({"data": ["shards/x.json"]}, "c2_one.data"),
        ({"id": "a b"}, "a b.id"),
        ({"colour": "red"}, "c2_one.colour: unknown key"),
        ({"variants": [{"verdict": "differs"}]}, "c2_one.variants"),
    ],
)
def test_checked_rejects_invalid_rows(changed, complaint):
    rows = [row("c2_zero"), row("c2_one", **changed)]
    with pytest.raises(VerdictError) as caught:
        scoreboard.checked(rows)
    assert complaint in str(caught.value)
    assert "\n" not in str(caught.value)


def test_checked_rejects_missing_field_and_repeated_id():
    incomplete = row("c2_one")
    del incomplete["reason"]
    with pytest.raises(VerdictError, match=r"c2_one\.reason: key missing"):
        scoreboard.checked([incomplete])
    with pytest.raises(VerdictError, match="c2_one: id: 2 rows"):
        scoreboard.checked([row("c2_one"), row("c2_one", kind="number")])


def test_board_is_independent_of_input_order():
    rows = [
        row("c2_one"),
        row("fig_2_10", kind="artefact"),
        row("fig_2_9", kind="artefact"),
        row("c_a", chapter="A"),
        row("c10", chapter=10),
        row("c9", chapter="9"),
    ]
    ordered = scoreboard.checked(rows)
    assert [r["id"] for r in ordered] == [
        "fig_2_9", "fig_2_10", "c2_one", "c9", "c10", "c_a",
    ]  # fmt: skip
    again = scoreboard.checked(rows[::-1])
    assert board_page.page(ordered) == board_page.page(again)


def test_page_has_all_rows_and_correct_counts():
    rows = scoreboard.checked(
        [
            row(f"c2_{i}", verdict=v, variants=[variant("px"), variant("mm")])
            for i, v in enumerate(["reproduced", "differs", "undecided", "differs"])
        ]
        + [
            row("n1", kind="number", verdict="setting", chapter=3, unit="px"),
            row("n2", kind="number", verdict="not yet", chapter="A", regenerated=None),
        ]
    )
    page = board_page.page(rows)
    board = Board(page)
    assert [
        (a["id"], a["data-kind"], a["data-chapter"], a["data-verdict"])
        for a, _ in board.rows
    ] == [(r["id"], r["kind"], str(r["chapter"]), r["verdict"]) for r in rows]
    for (_, shown), wanted in zip(board.rows, rows, strict=True):
        assert wanted["verdict"] in shown
        assert wanted["published"] in shown
        assert ("(0.951 to 1.022)" in shown) == (wanted["regenerated"] is not None)

    counts = scoreboard.headline(rows)
    assert (counts["all"], counts["kind"]) == (6, {"claim": 4, "number": 2})
    assert list(counts["verdict"].items()) == [
        ("reproduced", 1), ("differs", 2), ("undecided", 1), ("setting", 1),
        ("not yet", 1),
    ]  # fmt: skip
    assert counts["claims"] == {"reproduced": 1, "differs": 2, "undecided": 1}
    for text in (
        'href="#kind=claim&amp;verdict=differs" aria-label="2: show',
        'href="#verdict=not+yet" aria-label="1: show',
        '<option value="A">',
    ):
        assert text in page
    assert '<option value="counterpart">' not in page


def test_board_counts_and_filters_firm_claims():
    loose = {"firmness": "some readings", "agree": [1, 2]}
    rows = scoreboard.checked(
        [row("c1"), row("c2", **loose), row("c3", verdict="differs", **loose)]
    )
    assert scoreboard.headline(rows)["firm"] == {"reproduced": 1, "differs": 0}
    page = board_page.page(rows)
    for text in (
        "1 of the 2 reproduced</a>",
        "0 of the 1 differs</a>",
        "#kind=claim&amp;verdict=reproduced&amp;readings=all+readings",
    ):
        assert text in page
    assert [a["data-readings"] for a, _ in Board(page).rows] == [
        "all readings", "some readings", "some readings",
    ]  # fmt: skip


def test_board_columns_are_sortable():
    page = board_page.page(scoreboard.checked([row("c2_one")]))
    heads = re.findall(r'<th scope="col" data-sort="(\w)">', page)
    options = re.search(r'<select id="rx-sort".*?</select>', page)[0]
    assert re.findall(r'<option value="(\w)">', options) == heads
    cells = re.findall(r'<td class="(\w)">', page)
    assert ["w", *cells] == heads


def test_ids_in_reasons_become_links():
    rows = [
        row("fig_2_3", kind="artefact", reason="differs: c2_one; t2_n of c9_other"),
        row("c2_one", words="It <grows>."),
        row("t2_n", kind="number", words="width", conditions="wide"),
    ]
    words = row_html.words_of(rows)
    assert words == {"fig_2_3": "Fig. 2.3", "c2_one": "“It <grows>”", "t2_n": "“width”"}
    shown = str(row_html.linked(rows[0]["reason"], words, "../"))
    assert shown == (
        'differs: <a href="../scoreboard.html#c2_one" title="c2_one">“It &lt;grows&gt;”'
        '</a>; <a href="../scoreboard.html#t2_n" title="t2_n">“width”</a> of c9_other'
    )
    assert "“It &lt;grows&gt;”</a>" in board_page.page(scoreboard.checked(rows))


def test_rows_without_producer_are_folded():
    rows = scoreboard.checked(
        [row("c2_one", verdict="not yet", regenerated=None), row("c2_two")]
    )
    page = board_page.page(rows)
    shown, folded = page.split('<details class="rx-pending">')
    assert 'id="c2_two"' in shown
    assert 'id="c2_one"' in folded[: folded.index("</table>")]
    assert "1 rows" not in folded
    assert "rx-pending" not in board_page.page(rows[1:])


def test_row_links_to_page_data_and_source():
    rows = scoreboard.checked([row("c2_one")])
    assert 'id="c2_one"' in row_html.comparison(rows, "full", "../", {})
    (to_page, *_), *_ = row_html.addresses(row("sec_2_1", kind="section"))
    assert to_page == f"{SECTION}.html#compared"
    assert 'id="compared"' in row_html.comparison([], "full", "../", {})
    links = Board(board_page.page(rows)).links
    wanted = [
        f"{SECTION}.html#c2_one", "provenance/sweep.html", "figures/fig_2_3.csv",
        f"source/{SECTION}/claims.py.html#one",
    ]  # fmt: skip
    assert links[-4:] == wanted


def test_readings_are_grouped_by_verdict():
    shown = row_html.part(
        "readings",
        row(
            "c2_one",
            variants=[
                variant("px", reason="same"),
                variant("mm", verdict="differs", reason="one"),
                variant("rad", reason="same"),
            ],
        ),
    )
    assert "3 other interpretations: 2 reproduced, 1 differs" in shown
    assert shown.count("same") == 1
    assert shown.index("noise unit: rad") < shown.index("noise unit: mm")
    assert row_html.part("readings", row("c2_one")) == ""


def test_verdicts_have_unique_sign_and_meaning():
    schema = ROOT / "lib/repro/judge/schemas" / "scoreboard.schema.json"
    allowed = json.loads(schema.read_text("utf-8"))["$defs"]["verdict"]["enum"]
    assert allowed == list(scoreboard.MEANINGS) == list(row_html.SIGNS)
    assert len(set(row_html.SIGNS.values())) == len(allowed)
    styles = (ROOT / "report/source/_static/scoreboard.css").read_text("utf-8")
    for name in allowed:
        assert f".rx-{name.replace(' ', '-')}" in styles


def test_script_and_page_use_same_names():
    script = (ROOT / "report/source/_static/scoreboard.js").read_text("utf-8")
    page = board_page.page(scoreboard.checked([row("c2_one")]))
    for name in re.findall(r'getElementById\("([^"]+)"\)', script):
        assert f'id="{name}"' in page
    names = re.search(r"const names = \[(.+)\]", script)[1]
    assert re.findall(r'"(\w+)"', names) == re.findall(
        r'<(?:select|input) id="rx-\w+" name="(\w+)"', page
    )
