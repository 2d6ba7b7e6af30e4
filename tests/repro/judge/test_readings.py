"""Readings of a claim: combinations of options, and outcomes of tests."""

import numpy as np
import pytest

from repro.judge.ledger import LedgerError
from repro.judge.readings import crossed, open_questions, primary
from repro.judge.seeds import MIN_SEEDS, decision_of_seeds
from repro.judge.statistics import (
    FAILS,
    HOLDS,
    UNDECIDED,
    Estimate,
    median_and_range,
    proportion,
)
from repro.run.judging import in_every_reading
from repro.run.outcomes import Measured, Reading, Value
from repro.run.readings import Case, counterpart
from tests.small_checkouts import ROOT

KNOWN = {
    "noise": {"options": ["px", "mm"], "primary": "px"},
    "window": {"options": ["full", "half"], "primary": "full"},
    "exposure": {
        "options": ["within", "over"],
        "primary": "within",
        "not_crossed_with": ["window"],
    },
}


def test_crossed_gives_all_combinations_primary_first():
    made = crossed(KNOWN, ("noise", "window"))
    assert made[0] == primary(KNOWN, ("noise", "window"))
    assert {tuple(one.items()) for one in made} == {
        (("noise", noise), ("window", window))
        for noise in ("px", "mm")
        for window in ("full", "half")
    }


def test_crossed_respects_not_crossed_with():
    made = crossed(KNOWN, ("window", "exposure"))
    assert {"window": "half", "exposure": "over"} not in made
    assert len(made) == 3
    assert len(crossed(KNOWN, ("noise", "exposure"))) == 4


def test_unknown_question_is_rejected():
    with pytest.raises(LedgerError, match=r"'noises'.*did you mean noise"):
        crossed(KNOWN, ("noises",))


def test_primary_options_are_listed_first():
    known = open_questions(ROOT)
    assert len(known) > 50
    assert all(one["options"][0] == one["primary"] for one in known.values())


def test_judge_is_called_once_per_reading():
    def judge(results, options):
        return Reading("differs", results["value"] + len(options["noise"]))

    made = in_every_reading(judge, {"value": 1}, KNOWN, ("noise", "window"))
    assert [one.reading for one in made] == crossed(KNOWN, ("noise", "window"))
    assert {one.regenerated for one in made} == {3}


def test_judge_without_questions_gives_one_reading():
    made = in_every_reading(lambda results: Reading("differs", 1.0), {}, KNOWN, ())
    assert [one.reading for one in made] == [{}]


def test_case_names_chosen_or_primary_options():
    names = {"noise": {"px": "pixel", "mm": "plane"}, "window": {"full": 1, "half": 2}}
    case = Case(names, {"noise": "mm"})
    assert (case["noise"], case["window"]) == ("plane", 1)
    assert (case.option("noise"), case.option("window")) == ("mm", "full")
    with pytest.raises(KeyError):
        Case(names, {"noise": "cm"})["noise"]


@pytest.mark.parametrize(("true", "verdict"), [(9, "reproduced"), (8, "differs")])
def test_counterpart_holds_in_nine_of_ten_runs(true, verdict):
    holds = np.arange(10) < true
    made = counterpart(holds, np.arange(10.0), "px", "how far")
    assert (made.verdict, made.regenerated, made.unit) == (verdict, 4.5, "px")
    assert made.interval == (0, 9)
    assert made.reason.startswith(f"how far; true in {true} of 10 seeds (")


def test_run_without_value_fails_and_is_not_in_range():
    found = np.array([1.0, np.nan, 3.0, np.inf])
    made = counterpart(found < 5, found)
    assert (made.verdict, made.regenerated, made.interval) == ("differs", 2, (1, 3))
    nothing = counterpart([False], [np.nan])
    assert (nothing.regenerated, nothing.interval) == ("nothing", None)


def test_zero_runs_are_undecided():
    assert decision_of_seeds([]) == UNDECIDED
    assert not Reading.of_seeds([], "nothing").few_seeds


@pytest.mark.parametrize(
    ("true", "seeds", "decision"),
    [
        (36, 36, HOLDS),
        (35, 36, UNDECIDED),
        (46, 53, UNDECIDED),
        (53, 53, HOLDS),
        (40, 53, FAILS),
        (99, 100, HOLDS),
        (90, 100, UNDECIDED),
        (80, 100, FAILS),
    ],
)
def test_interval_decides_for_many_runs(true, seeds, decision):
    holds = np.arange(seeds) < true
    assert decision_of_seeds(holds) == decision
    made = Reading.of_seeds(holds, 1.0, "px", "how far")
    assert (made.few_seeds, made.unit, made.reason) == (False, "px", "how far")


def test_few_seeds_limit_matches_interval():
    assert proportion(np.ones(MIN_SEEDS)).low > 0.9 >= proportion(np.ones(35)).low
    few = Reading.of_seeds(np.arange(35) < 32, 1.0)
    assert (few.verdict, few.few_seeds) == ("reproduced", True)
    assert counterpart(np.arange(3) < 2, np.arange(3.0)).few_seeds
    assert not counterpart(np.ones(53, bool), np.arange(53.0)).few_seeds


def test_reading_has_interval_of_estimate():
    made = Reading.of(HOLDS, Estimate(2.0, 1.0, 3.0), "mm", "because")
    assert (made.verdict, made.regenerated, made.interval) == ("reproduced", 2, (1, 3))
    assert (made.unit, made.reason, made.reading) == ("mm", "because", {})
    assert Reading.of(UNDECIDED, 2.0).interval is None
    # A ratio of two samples that mostly failed has no value and no interval.
    made = Reading.of(UNDECIDED, Estimate(np.nan, 0.0, np.inf))
    assert (made.regenerated, made.interval) == ("no number", None)


def test_medians_have_intervals_of_statistics():
    trials = np.array([3.0, 1.0, np.nan, 2.0, 5.0])
    assert Measured.median(trials) == Measured(3, 1, np.inf)
    assert Value.median(trials, "px") == Value(3, (1, np.inf), "px")


def test_numbers_of_runs_have_range():
    seeds = np.array([3.0, 1.0, np.nan, np.inf, 5.0])
    assert Measured.of_seeds(seeds) == Measured(3, 1, 5)
    assert Value.of_seeds(seeds, "mm") == Value(3, (1, 5), "mm")
    assert median_and_range(seeds).failed == 2
    assert np.isnan(median_and_range(seeds[2:4])[:3]).all()


def test_settled_question_uses_primary_option_only():
    settled = {"claims": ["c2_one"], "found": "the same verdict", "when": "2026-11-28"}
    known = {**KNOWN, "noise": {**KNOWN["noise"], "settled": settled}}
    every = crossed(known, ("noise", "window"))
    kept = crossed(known, ("noise", "window"), "c2_one")
    assert kept == [r for r in every if r["noise"] == KNOWN["noise"]["primary"]]
    assert len(kept) < len(every)
    assert crossed(known, ("noise", "window"), "c2_other") == every
