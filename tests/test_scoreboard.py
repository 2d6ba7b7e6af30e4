"""The scoreboard: its rows, their order, its page."""

import json
import re

import pytest

from repro.judge import scoreboard, verdict
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
def test_rows_that_break_the_schema_are_refused(changed, complaint):
    rows = [row("c2_zero"), row("c2_one", **changed)]
    with pytest.raises(VerdictError) as caught:
        scoreboard.checked(rows)
    assert complaint in str(caught.value)
    assert "\n" not in str(caught.value)


def test_missing_field_and_repeated_id_are_refused():
    incomplete = row("c2_one")
    del incomplete["reason"]
    with pytest.raises(VerdictError, match=r"c2_one\.reason: key missing"):
        scoreboard.checked([incomplete])
    with pytest.raises(VerdictError, match="c2_one: id: 2 rows"):
        scoreboard.checked([row("c2_one"), row("c2_one", kind="number")])


def test_order_and_bytes_do_not_depend_on_the_order_given():
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


def test_text_is_escaped_and_never_ends_the_block():
    bad = '<script>alert("x")</script>\n\n# Heading & <b>'
    rows = scoreboard.checked(
        [
            row(
                "c2_one",
                published=bad,
                reason=bad,
                regenerated=bad,
                unit=bad,
                variants=[
                    variant("px", reason=bad, reading={bad: bad}),
                    variant("mm", reason="else"),
                ],
            )
        ]
    )
    compared = row_html.comparison(rows, "full", "../", {}, {})
    for text in (board_page.page(rows), compared):
        assert "<script>alert" not in text
        assert "&lt;script&gt;alert(&#34;x&#34;)&lt;/script&gt; # Heading" in text
        block = text[text.index("<div") : text.rindex("</div>")]
        assert "\n\n" not in block
        assert "b" not in Board(text[text.index('class="rx-rows') :]).tags[:9]


def test_every_row_stands_on_the_page_and_the_counts_equal_the_rows():
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
    page = board_page.page(rows, {SECTION})
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
    assert counts["all"] == 6
    assert counts["kind"] == {"claim": 4, "number": 2}
    assert list(counts["verdict"].items()) == [
        ("reproduced", 1), ("differs", 2), ("undecided", 1), ("setting", 1),
        ("not yet", 1),
    ]  # fmt: skip
    assert counts["claims"] == {"reproduced": 1, "differs": 2, "undecided": 1}
    assert 'href="#kind=claim&amp;verdict=differs" aria-label="2: show' in page
    assert 'href="#verdict=not+yet" aria-label="1: show' in page
    assert '<option value="A">' in page
    assert '<option value="counterpart">' not in page


@pytest.mark.parametrize(
    ("changed", "loose", "said"),
    [
        ({"agree": [1, 1]}, False, ""),
        ({"agree": [1, 1], "few_seeds": True}, False, "few seeds"),
        ({"agree": [2, 2]}, False, "in both readings"),
        ({"agree": [2, 2], "few_seeds": True}, False, "in both readings, few seeds"),
        ({"agree": [3, 3]}, False, "in all 3 readings"),
        ({"agree": [2, 3]}, True, "in 2 of 3 readings"),
        ({"agree": [1, 3]}, True, "in the primary reading only, of 3"),
        ({"agree": [2, 3], "kind": "artefact"}, True, "2 of 3 claims firm"),
        ({"agree": [0, 1], "kind": "section"}, True, "none of 1 claim firm"),
        ({"agree": None, "firmness": None, "verdict": "counterpart", "kind": "number",
          "ratio": 0.7349}, False, "0.735 × published"),
    ],
)  # fmt: skip
def test_a_badge_says_how_firm_the_verdict_is(changed, loose, said):
    firmness = "some readings" if loose else "all readings"
    judged = row("c2_one", **{"firmness": firmness, **changed})
    shown = row_html.part("judged_badge", judged)
    assert row_html.SIGNS[judged["verdict"]] in shown
    assert ("rx-loose" in shown) == loose
    assert ("give another verdict" in shown) == loose
    assert re.search(r"</span>(?: <span[^>]*>(.*)</span>)?$", shown)[1] == (
        said or None
    )
    for text in (
        board_page.page(scoreboard.checked([judged])),
        row_html.comparison([judged | {"kind": "claim"}], "full", "../", {}, {}),
    ):
        assert "rx-loose" in text or not loose


def test_the_board_counts_the_firm_claims_and_filters_by_firmness():
    loose = {"firmness": "some readings", "agree": [1, 2]}
    rows = scoreboard.checked(
        [row("c1"), row("c2", **loose), row("c3", verdict="differs", **loose)]
    )
    assert scoreboard.headline(rows)["firm"] == {"reproduced": 1, "differs": 0}
    page = board_page.page(rows)
    assert "1 of the 2 reproduced</a>" in page
    assert "0 of the 1 differs</a>" in page
    assert "#kind=claim&amp;verdict=reproduced&amp;readings=all+readings" in page
    assert [a["data-readings"] for a, _ in Board(page).rows] == [
        "all readings", "some readings", "some readings",
    ]  # fmt: skip


def test_a_verdict_that_no_claim_gives_in_every_reading_says_not_firm():
    none = {"kind": "artefact", "firmness": "no claim", "agree": [0, 2]}
    rows = scoreboard.checked([row("fig_4_10", **none), row("c2_one")])
    page = board_page.page(rows)
    shown = {a["id"]: said for a, said in Board(page).rows}
    assert "reproduced, not firm" in shown["fig_4_10"]
    assert "none of 2 claims firm" in shown["fig_4_10"]
    assert "not firm" not in shown["c2_one"]
    assert '<a href="#readings=no+claim">1 time</a>' in page
    assert '<option value="no claim">' in page
    firm = board_page.page(scoreboard.checked([row("c2_one")]))
    assert "not firm" not in firm


def test_every_column_of_the_board_can_be_sorted_by():
    page = board_page.page(scoreboard.checked([row("c2_one")]))
    heads = re.findall(r'<th scope="col" data-sort="(\w)">', page)
    options = re.search(r'<select id="rx-sort".*?</select>', page)[0]
    assert re.findall(r'<option value="(\w)">', options) == heads
    cells = re.findall(r'<td class="(\w)">', page)
    assert ["w", *cells] == heads


def test_ids_in_a_reason_become_the_words_of_their_rows_with_a_link():
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


def test_the_test_of_a_claim_and_what_changed_in_it_are_shown():
    changed = row("c2_one", changed="After a run: <looser>.")
    rows = scoreboard.checked([changed, row("c2_two")])
    for shown in (
        board_page.page(rows),
        row_html.comparison(rows, "full", "../", {}, {}),
    ):
        assert shown.count("Slope &gt;= 0.9.") == 2
        assert shown.count("Test changed:</b> After a run: &lt;looser&gt;.") == 1
    assert 'href="scoreboard.html#test=changed">that of one row</a>' in (
        board_page.page(rows)
    )
    assert [a["data-test"] for a, _ in Board(board_page.page(rows)).rows] == [
        "changed", "",
    ]  # fmt: skip
    assert "before its run. The" in " ".join(board_page.page(rows[1:]).split())
    assert scoreboard.headline(rows)["changed"] == ["c2_one"]


def test_what_nothing_produces_yet_is_folded_away():
    rows = scoreboard.checked(
        [row("c2_one", verdict="not yet", regenerated=None), row("c2_two")]
    )
    page = board_page.page(rows)
    shown, folded = page.split('<details class="rx-pending">')
    assert 'id="c2_two"' in shown
    assert 'id="c2_one"' in folded[: folded.index("</table>")]
    assert "1 rows" not in folded
    assert "rx-pending" not in board_page.page(rows[1:])


def test_pure_numbers_have_no_unit():
    assert row_html.part("regenerated", row("c2_one", interval=None), "1") == "0.981"
    counted = row("n", kind="number", published=12, unit="count")
    assert row_html.part("published", counted) == "12"


def test_links_lead_to_the_row_on_its_page_to_data_and_source():
    rows = scoreboard.checked([row("c2_one")])
    assert 'id="c2_one"' in row_html.comparison(rows, "full", "../", {}, {})
    (to_page, *_), *_ = row_html.addresses(row("sec_2_1", kind="section"), ())
    assert to_page == f"{SECTION}.html#compared"
    assert 'id="compared"' in row_html.comparison([], "full", "../", {}, {})
    links = Board(board_page.page(rows, {SECTION})).links
    wanted = [
        f"{SECTION}.html#c2_one", "results/sweep.json", "figures/fig_2_3.csv",
        f"source/{SECTION}/page.py",
    ]  # fmt: skip
    assert links[-4:] == wanted
    assert f"source/{SECTION}/page.py" not in board_page.page(rows)


def test_readings_are_grouped_by_verdict_and_say_a_shared_reason_once():
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
    assert "3 other readings: 2 reproduced, 1 differs" in shown
    assert shown.count("same") == 1
    assert shown.index("noise unit: rad") < shown.index("noise unit: mm")
    assert row_html.part("readings", row("c2_one")) == ""


def test_what_all_readings_of_a_verdict_share_is_said_once():
    readings = [
        variant("", reading={"extent": "finite", "noise_unit": unit}, reason=unit)
        for unit in ("px", "mm")
    ]
    shown = row_html.part("readings", row("c2_one", variants=readings))
    assert shown.count("extent: finite") == 1
    assert shown.count("noise unit: ") == 2
    alone = row_html.part("readings", row("c2_one", variants=readings[:1]))
    assert "1 other reading: 1 reproduced" in alone
    assert "<li>extent: finite; noise unit: px → " in alone


def test_every_verdict_has_a_sign_and_a_meaning_of_its_own():
    schema = ROOT / "lib/repro/judge/schemas" / "scoreboard.schema.json"
    allowed = json.loads(schema.read_text("utf-8"))["$defs"]["verdict"]["enum"]
    assert allowed == list(scoreboard.MEANINGS) == list(row_html.SIGNS)
    assert len(set(row_html.SIGNS.values())) == len(allowed)
    styles = (ROOT / "report/source/_static/scoreboard.css").read_text("utf-8")
    for name in allowed:
        assert f".rx-{name.replace(' ', '-')}" in styles


def test_script_and_page_agree_on_names():
    script = (ROOT / "report/source/_static/scoreboard.js").read_text("utf-8")
    page = board_page.page(scoreboard.checked([row("c2_one")]))
    for name in re.findall(r'getElementById\("([^"]+)"\)', script):
        assert f'id="{name}"' in page
    names = re.search(r"const names = \[(.+)\]", script)[1]
    assert re.findall(r'"(\w+)"', names) == re.findall(
        r'<(?:select|input) id="rx-\w+" name="(\w+)"', page
    )


def test_the_three_verdict_words_of_the_judge_are_known():
    assert set(verdict.DECIDED) < set(scoreboard.MEANINGS)
