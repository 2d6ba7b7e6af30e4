"""Section 5.2: the test of the start can fail, on the seeds that were completed."""

import importlib

import numpy as np
import pytest

from chapters.ch05_flexible_mirror.s2_method.claims import judge_linear_enough
from chapters.ch05_flexible_mirror.s2_method.experiment import STAGES, Watch
from chapters.ch05_flexible_mirror.s2_method.report import (
    STARTS,
    STARTS_SWEPT,
    transitions,
)
from chapters.shared.mirror.levels import BENCHES, LEVEL_NAMES, SWEPT
from tests.judged_claims import of_rejected, readings_of
from tests.made_results import of_columns, of_levels

SEEDS = 100
ENDED = {"cost_mm2": 40.0, "deflection_mm": 4.9}


def columns(bench, seeds, other):
    """A bench where both starts end alike, but for `other`: name -> (value, count)."""
    made = {
        f"{bench}.{start}.{name}": np.full(seeds, value)
        for start in ("linear", "true")
        for name, value in ENDED.items()
    }
    for name, (value, count) in other.items():
        made[f"{bench}.{name}"][:count] = value
    return made


def made(other, swept=None):
    """Results with other values in some runs; swept: {level: those of the sweep}."""
    swept = swept or {}
    return of_levels(
        (STARTS, BENCHES, lambda level: columns(level, SEEDS, other)),
        (
            STARTS_SWEPT,
            SWEPT,
            lambda level: columns(level, 20, swept.get(level, other)),
        ),
    )


def linear(name, value, count=SEEDS):
    """The value of the linear start in so many runs."""
    return {f"linear.{name}": (value, count)}


@pytest.mark.parametrize(
    ("other", "swept", "expected"),
    [
        ({}, {}, "reproduced"),
        *(
            (linear(n, f * v), {}, "differs")
            for n, v in ENDED.items()
            for f in (0.98, 1.02)
        ),
        *(
            (linear(n, f * v), {}, "reproduced")
            for n, v in ENDED.items()
            for f in (0.993, 1.007)
        ),
        (linear("cost_mm2", 99.0, 3), {}, "undecided"),
        *(({}, {end: linear("cost_mm2", 99.0, 1)}, "reproduced") for end in SWEPT),
        *(
            ({}, {end: linear("cost_mm2", value, n)}, "undecided in the first")
            for end in SWEPT
            for value, n in ((99.0, 2), (np.nan, 20))
        ),
    ],
)
def test_linear_start_verdict(other, swept, expected):
    found = readings_of(judge_linear_enough, made(other, swept))
    assert [one.reading["mirror_bench"] for one in found] == list(LEVEL_NAMES.values())
    first, *others = [one.verdict for one in found]
    assert first == expected.split()[0]
    assert others == ["reproduced" if "first" in expected else first] * 2


@pytest.mark.parametrize("start", ["linear", "true"])
def test_rejected_starts_are_excluded_and_reported(start):
    lost = made({f"{start}.{name}": (np.nan, 15) for name in ENDED})
    found = of_rejected(judge_linear_enough, lost)
    assert found == {("reproduced", "15 of 100", "differs")}


def outer():
    inner()


def inner():
    return None


def test_watch_records_outer_stages_in_order():
    stages = {"outer": f"{__name__}.outer", "inner": f"{__name__}.inner"}
    with Watch(stages) as watch:
        inner()
        outer()
        inner()
    outer()
    assert watch.order == ["inner", "outer", "inner"]
    assert watch.ways() == {"inner > outer": 1, "outer > inner": 1}


def test_watched_stages_are_library_functions():
    for function in STAGES.values():
        module, _, name = function.rpartition(".")
        assert getattr(importlib.import_module(module), name).__module__ == module


def test_transitions_of_bending_combine_its_neighbours():
    ways = {"held > pose": 1, "open > pose": 2, "pose > order": 3, "order > refused": 1}
    made = {f"ways.{way}": n for way, n in ways.items()} | {"stage1.steps": 3}
    found = transitions(of_columns(({}, made)))
    assert (found["held", "bend"], found["bend", "pose"]) == (1, 3)
    assert (found["open", "bend"], found["order", "refused"]) == (2, 1)
    assert ("open", "pose") not in found
