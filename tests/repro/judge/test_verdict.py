"""Verdicts on numbers and claims."""

import pytest

from repro.judge import scoreboard, verdict
from repro.judge.number_rules import VerdictError, equal_as_printed, half_last_digit
from tests.verdict_books import (
    PAGE,
    by_id,
    claim,
    judged,
    number,
    of_claim,
    of_number,
    question,
    readings,
    small,
    value,
)

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
    "put into the rig": (
        number(0.1, source="real"), value(0.1, put_in="a pose of the rig"), "set",
    ),
    "a simulated number solved for": (
        number(26), value(27, (26.5, 29), put_in="the factor is solved for it"), "set",
    ),
    "a setting that is put in": (
        number(role="setting"), value(640, put_in="as stated"), "setting",
    ),
    "cell lost": (number(None, source="real"), value(0.2), "not comparable"),
    "cited": (number(30000, "gt", "literature", "real"), value(1), "not comparable"),
}  # fmt: skip


@pytest.mark.parametrize("name", NUMBERS)
def test_number_verdict_follows_role_source_comparator(name):
    entry, found, expected = NUMBERS[name]
    row = of_number(entry, found)
    assert (row["verdict"], row["published"]) == (expected, entry["value"])
    assert row["unit"] == "px" or entry["unit"] == "count"
    if name != "cited":
        assert (row["regenerated"], row["page"]) == (found["value"], "ch02_one/s1.html")
        assert row["data"] == ["results/sweep.json"]
    if expected in ("differs", "undecided", "not comparable", "set"):
        assert row["reason"]


def test_counterpart_has_ratio_and_remark():
    row = of_number(number(0.1, source="real"), value(0.25, reason="three seeds"))
    assert (row["ratio"], row["reason"]) == (pytest.approx(2.5), "three seeds")
    row = of_number(number(0, source="real"), value(0.25))
    assert row["reason"] == "no ratio to a published 0; difference 0.25"
    assert row["ratio"] is None
    words = of_number(number("7x5", source="real"), value("7x6"))
    assert (words["verdict"], words["ratio"]) == ("counterpart", None)
    assert of_number(number(26), value(27, (25, 29)))["ratio"] is None
    put_in = of_number(number(0.1, source="real"), value(0.1, put_in="from Table 4.2"))
    assert (put_in["ratio"], put_in["reason"]) == (None, "from Table 4.2")


@pytest.mark.parametrize(
    ("found", "line"),
    [
        (value(None), "value: not a number"),
        (value(3, unit="mm"), "unit: found 'mm'; give it in px, as published"),
        (value(3), "interval: missing"),
        (value(3, (4, 2)), r"interval: found \(4, 2\); give \[low, high\]"),
        (value(3, (None, 2)), "interval: found"),
    ],
)
def test_invalid_number_is_rejected_in_one_line(found, line):
    with pytest.raises(VerdictError, match=rf"^{PAGE}: n: {line}"):
        of_number(number(), found)


@pytest.mark.parametrize(
    ("printed", "half"), [(0.46, 0.005), (12, 0.5), (1e-05, 5e-06), (30000, 0.5)]
)
def test_printed_precision_is_half_last_digit(printed, half):
    assert half_last_digit(printed) == pytest.approx(half)
    assert equal_as_printed(printed, printed + 0.9 * half, exact=False)
    assert not equal_as_printed(printed, printed + 1.1 * half, exact=False)


def test_unambiguous_claim_has_one_reading():
    row = of_claim(("differs", {}))
    assert (row["verdict"], row["published"]) == ("differs", "It grows.")
    assert (row["variants"], row["reason"]) == ([], "slope")


def test_primary_reading_decides_and_others_are_variants():
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


@pytest.mark.parametrize(
    ("others", "firmness", "agree"),
    [
        ((), "all readings", [1, 1]),
        (("differs", "differs"), "all readings", [3, 3]),
        (("differs", "undecided"), "some readings", [2, 3]),
        (("reproduced", "undecided"), "some readings", [1, 3]),
    ],
)
def test_claim_is_firm_if_readings_agree(others, firmness, agree):
    options = ["px", "mm", "rad"][: 1 + len(others)]
    book = small(claims={"c": claim("fig_2_1")}, readings={"noise": question(*options)})
    found = readings(
        *zip(("differs", *others), ({"noise": o} for o in options), strict=True)
    )
    for reading in found["readings"] if not others else ():
        reading["reading"] = {}
    row = by_id(book, judged(claims={"c": found}))["c"]
    assert (row["firmness"], row["agree"]) == (firmness, agree)


def test_not_comparable_claim_is_shown_in_every_build():
    book = small(claims={"c": claim("fig_2_1"), "d": claim("fig_2_1")})
    alone = readings(("not comparable", {}))
    alone["readings"][0]["reason"] = "the method is not described"
    found = {"c": alone, "d": readings(("reproduced", {}))}
    shown = {}
    for effort in ("quick", "full"):
        page = judged(claims=found) | {"effort": effort}
        rows = verdict.rows(book, [page], {"2": "a figure"}, effort)
        shown[effort] = {row["id"]: row for row in scoreboard.checked(rows)}
        row = shown[effort]["c"]
        assert (row["verdict"], row["firmness"]) == ("not comparable", None)
        assert (row["reason"], row["regenerated"]) == ("the method is not described", 0)
    assert shown["quick"]["d"]["verdict"] == "quick"


def test_number_has_one_reading_and_words():
    row = of_number({**number(), "conditions": "wide"}, value(640, (600, 700)))
    assert (row["firmness"], row["agree"]) == (None, None)
    assert (row["words"], row["conditions"]) == ("width", "wide")
    assert of_claim(("differs", {}))["words"] == "It grows."


def test_claim_row_has_test_and_change():
    changed = {**claim("fig_2_1"), "test": "Slope >= 0.9.", "changed": "Once."}
    book = small(claims={"c": changed})
    row = by_id(book, judged(claims={"c": readings(("differs", {}))}))["c"]
    assert (row["test"], row["changed"]) == ("Slope >= 0.9.", "Once.")
    assert of_claim(("differs", {}))["changed"] == ""


def test_interval_includes_its_ends():
    for low, high, wanted in (
        (600, 700, "reproduced"),
        (640, 640, "reproduced"),
        (600, 639, "differs"),
        (641, 700, "differs"),
    ):
        row = of_number(number(640), value((low + high) / 2, [low, high]))
        assert row["verdict"] == wanted


def test_rows_have_intervals():
    found = readings(("differs", {}))
    found["readings"][0]["interval"] = [0.8, 0.9]
    book = small(claims={"c": claim("fig_2_1")})
    assert by_id(book, judged(claims={"c": found}))["c"]["interval"] == [0.8, 0.9]
    assert of_number(number(), value(640, [600, 700]))["interval"] == [600, 700]


def test_agreeing_readings_have_no_remark():
    row = of_claim(("differs", {"noise": "px"}), ("differs", {"noise": "mm"}))
    assert (row["reason"], len(row["variants"])) == ("slope", 1)


def test_uncrossed_options_use_primary_options_only():
    book = small(claims={"c": claim("fig_2_1")})
    book.readings["noise"]["not_crossed_with"] = ["extent"]
    taken = [("px", "unbounded"), ("px", "finite"), ("mm", "unbounded")]
    options = [dict(zip(("noise", "extent"), pair, strict=True)) for pair in taken]

    def found(asked):
        outcomes = (("differs", reading) for reading in asked)
        return by_id(book, judged(claims={"c": readings(*outcomes)}))["c"]

    assert len(found(options)["variants"]) == 2
    with pytest.raises(VerdictError, match=r"found {'noise': 'mm', 'extent': 'fin"):
        found([*options, {"noise": "mm", "extent": "finite"}])
    with pytest.raises(VerdictError, match=r"'mm', 'extent': 'unbounded'} missing"):
        found(options[:2])


@pytest.mark.parametrize(
    ("taken", "line"),
    [
        (({"noise": "px"},), "reading: {'noise': 'mm'} missing; test it too"),
        (({"nois": "px"},), "question 'nois' .*; did you mean noise?"),
        (({"noise": "px"}, {"noise": "cm"}), "found {'noise': 'cm'}; give"),
        (({"noise": "px"}, {"extent": "finite"}), "found {'extent': 'finite'}; give"),
        (({"noise": "px"}, {"noise": "px"}), "found {'noise': 'px'} twice; give each"),
    ],
)
def test_readings_must_be_all_combinations(taken, line):
    with pytest.raises(VerdictError, match=f"^{PAGE}: c: reading: .*|{line}") as error:
        of_claim(*(("reproduced", options) for options in taken))
    assert error.match(line)
