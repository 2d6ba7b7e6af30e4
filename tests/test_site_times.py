"""Processor seconds of the pages, added up from the records of their jobs."""

import json

import pytest

from repro.run.discover import Producer
from repro.site.times import times_of

PAGES = ["ch02_x/s1", "photographs/a-set", "photographs/b-set"]


def producer(kind, name, page, **details):
    return Producer(kind, name, "chapters.x", "f", page, 1, details)


MADE = [
    producer(
        "experiment",
        "one",
        "ch02_x/s1",
        shards={"quick": 1, "full": 2},
        rendered={"full": ("rig/0", "rig/1"), "quick": ("rig/2",)},
    ),
    producer("figure", "fig_2_1", "ch02_x/s1"),
    producer("claim", "c2_x", "ch02_x/s1"),
    producer(
        "experiment", "study", "photographs/set", shards={"full": 1}, per_set=True
    ),
    producer(
        "experiment",
        "gone",
        "ch09_y/s1",
        shards={"full": 1},
        rendered={"full": ("rig/5",)},
    ),
]


@pytest.fixture
def folder(tmp_path):
    kept = {
        "experiment/one/0-of-2": 3.0,
        "experiment/one/1-of-2": 4.0,
        "experiment/one/0-of-7": 500.0,
        "experiment/one": 900.0,
        "experiment/gone": 700.0,
        "result/one": 0.5,
        "figure/fig_2_1": 1.0,
        "judge/ch02_x/s1": 0.25,
        "page/ch02_x/s1": 0.75,
        "experiment/study@a-set": 10.0,
        "experiment/study@another": 800.0,
        "scoreboard": 2.0,
        "sets/rig/0": 5.0,
        "sets/rig/1": 6.0,
        "sets/rig/2": 50.0,
        "sets/rig/5": 60.0,
        "site/sphinx": 600.0,
    }
    for label, seconds in kept.items():
        path = tmp_path / f"{label}.json"
        path.parent.mkdir(parents=True, exist_ok=True)
        path.write_text(json.dumps({"seconds": 0, "processor_seconds": seconds}))
    return tmp_path


def test_every_job_of_the_build_counts_once_and_no_other(folder):
    times = times_of(folder, folder / "sets", "full", MADE, PAGES)
    first, a_set, b_set = times.pages
    assert (first.computed, first.drawn, first.rest) == (7.5, 1.0, 1.0)
    assert (a_set.computed, b_set.total) == (10.0, 0.0)
    assert times.scoreboard == 2.0
    assert times.rendered == 11.0
    assert times.total == 32.5
    assert times.slowest[0] == ("study@a-set", "photographs/a-set", 10.0)


def test_a_job_that_was_one_is_read_as_one(folder):
    times = times_of(folder, folder / "sets", "quick", MADE[:1], PAGES[:1])
    assert times.pages[0].computed == 900.0
