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
from chapters.shared.mirror.levels import BENCHES, SAID, SWEPT
from tests.exercise_answers import misjudged
from tests.judged_claims import of_rejected, readings_of
from tests.made_results import ROOT, of_columns

SEEDS, FEWER = 100, 20
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


def made(other=None, at_ends=None):
    """Results with something else in some seeds, at all benches or at one's ends."""
    plans = ((STARTS, BENCHES, SEEDS, {}), (STARTS_SWEPT, SWEPT, FEWER, at_ends or {}))
    results = {}
    for experiment, benches, seeds, ends in plans:
        values = {}
        for bench in benches:
            values |= columns(bench, seeds, ends.get(bench, other or {}))
        results[experiment] = of_columns(({"geometry": "A"}, values))
    return results


def verdicts(results):
    found = readings_of(judge_linear_enough, results)
    assert [one.reading["mirror_bench"] for one in found] == list(SAID.values())
    return [one.verdict for one in found]


def test_equal_ends_are_reproduced():
    assert verdicts(made()) == ["reproduced"] * 3


@pytest.mark.parametrize("name", ENDED)
@pytest.mark.parametrize("factor", [0.98, 1.02])
def test_another_cost_or_another_deflection_differs(name, factor):
    other = {f"linear.{name}": (factor * ENDED[name], SEEDS)}
    assert verdicts(made(other)) == ["differs"] * 3
    near = {f"linear.{name}": ((1 + factor / 150) * ENDED[name], SEEDS)}
    assert verdicts(made(near)) == ["reproduced"] * 3


@pytest.mark.parametrize("start", ["linear", "true"])
def test_a_seed_without_an_end_does_not_count_and_is_told(start):
    lost = made({f"{start}.{name}": (np.nan, 15) for name in ENDED})
    told = of_rejected(judge_linear_enough, lost)
    assert told == {("reproduced", "15 of 100", "differs")}


def test_a_share_at_the_boundary_is_left_open():
    assert verdicts(made({"linear.cost_mm2": (99.0, 3)})) == ["undecided"] * 3


def test_an_end_of_the_sweep_on_the_other_side_leaves_the_bench_open():
    for end in SWEPT:
        for value, count in ((99.0, 2), (np.nan, FEWER)):
            lost = {end: {"linear.cost_mm2": (value, count)}}
            left = ["undecided", "reproduced", "reproduced"]
            assert verdicts(made(at_ends=lost)) == left
        kept = {end: {"linear.cost_mm2": (99.0, 1)}}
        assert verdicts(made(at_ends=kept)) == ["reproduced"] * 3


def outer():
    inner()


def inner():
    return None


def test_a_watch_tells_stages_in_order_and_not_what_is_within_them():
    stages = {"outer": f"{__name__}.outer", "inner": f"{__name__}.inner"}
    with Watch(stages) as watch:
        inner()
        outer()
        inner()
    outer()
    assert watch.order == ["inner", "outer", "inner"]
    assert watch.ways() == {"inner > outer": 1, "outer > inner": 1}


def test_every_stage_that_is_watched_is_a_function_of_the_library():
    for function in STAGES.values():
        module, _, name = function.rpartition(".")
        assert getattr(importlib.import_module(module), name).__module__ == module


def test_ways_to_and_from_the_bending_are_those_of_both_its_neighbours():
    ways = {"held > pose": 1, "open > pose": 2, "pose > order": 3, "order > refused": 1}
    made = {f"ways.{way}": n for way, n in ways.items()} | {"stage1.steps": 3}
    found = transitions(of_columns(({}, made)))
    assert found["held", "bend"] == 1
    assert found["bend", "pose"] == 3
    assert found["open", "bend"] == 2
    assert found["order", "refused"] == 1
    assert ("open", "pose") not in found


def test_exercises_are_judged_rightly():
    assert misjudged(ROOT, "ch05_flexible_mirror/s2_method") == []
