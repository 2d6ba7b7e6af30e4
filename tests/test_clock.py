"""`make times`: what runs took, added up and held against earlier ones and budgets."""

import json
import re

import pytest

from repro.site.times import PageTimes, Times
from repro.workflow import clock
from repro.workflow.clock import (
    BUDGETS,
    Clocked,
    Took,
    clocked_from,
    grown,
    growth_said,
    in_words,
    keep,
    kept_in,
    main,
    parts_of,
    parts_said,
    ratio,
    runs_said,
)

BEFORE = {"ch02": 40.0, "ch03": 100.0, "site": 0.2}


def test_the_parts_are_the_chapters_and_what_is_of_none():
    pages = [
        PageTimes("ch02_x/s1", 3.0, 1.0, 0.5),
        PageTimes("ch03_y/s1", 10.0),
        PageTimes("ch02_x/s2", rest=2.0),
    ]
    parts = parts_of(Times(pages, [], rendered=7.0, scoreboard=0.25), site=5.0)
    assert parts == {
        "ch02_x": 6.5,
        "ch03_y": 10.0,
        "rendered sets": 7.0,
        "scoreboard": 0.25,
        "site": 5.0,
    }


def test_growth_is_what_lies_beyond_what_runs_differ_by():
    now = {"ch02": 41.9, "ch03": 130.0, "site": 0.6, "ch05": 50.0}
    assert grown(now, BEFORE) == {"ch03": (100.0, 130.0)}
    assert grown(now | {"ch02": 43.0}, BEFORE) == {
        "ch03": (100.0, 130.0),
        "ch02": (40.0, 43.0),
    }
    assert list(grown({"ch02": 90.0, "ch03": 130.0}, BEFORE)) == ["ch02", "ch03"]
    assert grown(BEFORE, BEFORE) == {}


def test_on_a_slower_machine_only_what_grew_beyond_its_ratio_counts():
    slower = {name: 1.5 * seconds for name, seconds in BEFORE.items()}
    assert ratio(slower, BEFORE) == pytest.approx(1.5)
    assert ratio(slower | {"ch05": 900.0}, BEFORE) == pytest.approx(1.5)
    assert ratio(slower, {}) == 1.0
    assert grown(slower, BEFORE, 1.5) == {}
    assert grown(slower | {"ch02": 90.0}, BEFORE, 1.5) == {"ch02": (60.0, 90.0)}
    (first, last) = growth_said(slower, BEFORE, same_machine=False)
    assert "takes 1.50 times as long" in first
    assert last == "no part grew by more than 5%"
    assert growth_said(slower, BEFORE, same_machine=True) == [
        "grew: ch03, 100.0 s -> 150.0 s (+50 %)",
        "grew: ch02, 40.0 s -> 60.0 s (+50 %)",
    ]
    assert growth_said(slower, {}, same_machine=False) == [
        "No earlier run is known; the next one is held against this."
    ]


@pytest.mark.parametrize(
    ("seconds", "words"),
    [
        (3.42, "3.4 s"),
        (9.94, "9.9 s"),
        (9.96, "10 s"),
        (59.4, "59 s"),
        (59.6, "1 min"),
        (169.7, "2 min 50 s"),
        (2160, "36 min"),
        (2179, "36 min"),
    ],
)
def test_times_are_given_as_people_say_them(seconds, words):
    assert in_words(seconds) == words


def test_runs_stand_beside_the_last_and_their_budgets():
    now = {"quick": Took(331.4, 171.0), "nothing changed": Took(3.1, 3.6)}
    rows = runs_said(now, {"quick": Took(340.0, 175.0)})
    assert [re.split("  +", row) for row in rows] == [
        ["processors and wall", "now", "before", "budget", "whole book"],
        ["make quick", "331 s, 2 min 51 s", "340 s, 2 min 55 s"]
        + ["330 s, 2 min 50 s", "4 min"],
        ["nothing changed", "3 s, 3.6 s", "-", "4.0 s", "4.0 s"],
    ]
    assert len({len(row) for row in rows}) == 1
    assert parts_said({"ch02": 1.25, "ch05": 2.0}, {"ch02": 1.0}) == [
        "processor seconds of the jobs  now  before",
        "ch02                           1.2     1.0",
        "ch05                           2.0       -",
        "all                            3.2     1.0",
    ]


def test_what_is_kept_comes_back_and_what_was_not_timed_stays(tmp_path):
    path = tmp_path / "new" / "times.json"
    assert kept_in(path) == {}
    keep(path, "quick", Clocked(BEFORE, {"quick": Took(331.0, 171.0)}))
    keep(path, "test", Clocked({}, {"make test": Took(800.0, 420.0)}))
    keep(path, "quick", Clocked({"ch02": 39.0}, {"nothing changed": Took(3.0, 3.5)}))
    kept = clocked_from(kept_in(path)["quick"])
    assert kept.parts == {"ch02": 39.0}
    assert kept.runs == {"quick": (331.0, 171.0), "nothing changed": (3.0, 3.5)}
    assert clocked_from(kept_in(path)["test"]).runs == {"make test": (800.0, 420.0)}
    path.write_text(path.read_text()[:20])
    assert kept_in(path) == {}


@pytest.fixture
def made_up(tmp_path, monkeypatch):
    """What `measured` is to give, in a folder of its own."""
    given = {"status": 0, "now": Clocked(BEFORE, {"quick": Took(331.0, 171.0)})}
    monkeypatch.chdir(tmp_path)
    monkeypatch.setattr(
        clock, "measured", lambda *order: (given["status"], given["now"])
    )
    return given


def test_a_run_is_held_against_the_record_and_then_against_the_last(made_up, capsys):
    clock.RECORD.parent.mkdir(parents=True)
    keep(clock.RECORD, "quick", Clocked({n: s / 2 for n, s in BEFORE.items()}, {}))
    assert main(["build"]) == 0
    assert "takes 2.00 times as long" in capsys.readouterr().out
    made_up["now"] = Clocked(BEFORE | {"ch02": 50.0}, {"nothing changed": Took(3, 3)})
    assert main(["build"]) == 0
    shown = capsys.readouterr().out.splitlines()
    assert shown[-1] == "grew: ch02, 40.0 s -> 50.0 s (+25 %)"
    again = "make quick: a part was there; make clean times EFFORT=quick times all"
    assert again in shown
    before = json.loads(clock.RECORD.read_text())
    assert main(["build", "--record"]) == 0
    assert json.loads(clock.RECORD.read_text()) != before


def test_only_a_build_that_fails_fails_and_it_is_not_kept(made_up, capsys):
    made_up["now"] = Clocked({"ch02": 1e9}, {"quick": Took(1e9, 1e9)})
    assert main(["build"]) == 0
    made_up["status"] = 130
    clock.OWN.unlink()
    assert main(["build"]) == 130
    assert not clock.OWN.exists()


def test_the_tests_are_timed_where_they_pass(tmp_path, monkeypatch, capsys):
    monkeypatch.chdir(tmp_path)
    assert main(["test", "false"]) == 1
    assert not clock.OWN.exists()
    assert main(["test", "sh", "-c", "echo seen"]) == 0
    assert "make test" in capsys.readouterr().out
    (name,) = clocked_from(kept_in(clock.OWN)["test"]).runs
    assert name in BUDGETS


def test_a_build_is_ordered_three_times_and_the_third_makes_a_page(
    tmp_path, monkeypatch
):
    page = tmp_path / "report" / "build" / "quick" / "pages" / "ch02_x" / "s1.ipynb"
    orders = []

    def pretended(words):
        orders.append((words[words.index("--effort") + 1], page.exists()))
        page.parent.mkdir(parents=True, exist_ok=True)
        page.touch()
        return 0, Took(10.0 / len(orders), 6.0 / len(orders))

    work = type("Work", (), {"pages": ("ch02_x/s1",), "notebooks": lambda self: [page]})
    monkeypatch.setattr(clock, "timed", pretended)
    monkeypatch.setattr(clock, "Work", lambda *given: work())
    status, found = clock.measured(tmp_path, "quick", "", "")
    assert status == 0
    assert orders == [("quick", False), ("quick", True), ("quick", False)]
    assert found.runs == {
        "quick": (10.0, 6.0),
        "nothing changed": (5.0, 3.0),
        "a page again": (10.0 / 3, 2.0),
    }
    kept = tmp_path / "figures" / "quick" / "times" / "page" / "ch02_x" / "s1.json"
    kept.parent.mkdir(parents=True)
    kept.write_text('{"processor_seconds": 4.5}')
    _, found = clock.measured(tmp_path, "quick", "", "")
    assert "quick" not in found.runs
    assert found.parts["ch02_x"] == 4.5
