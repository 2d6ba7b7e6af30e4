"""Trials, shards and result files: the same bytes however the work is divided."""

import json
from dataclasses import replace
from pathlib import Path

import numpy as np
import pytest
from hypothesis import given
from hypothesis import strategies as st

from repro.run import judging, marks, results
from repro.run.outcomes import DECISIONS, Plan, Reading, crossed

CONDITIONS = [{"noise": 0.5, "extent": "finite"}, {"noise": 1.0, "extent": "finite"}]


def noisy_trial(condition, rng):
    draws = condition["noise"] * rng.standard_normal(20)
    failed = draws[0] > 1.2
    return {
        "method": {"mean": np.nan if failed else draws.mean(), "count": 20},
        "draws": draws,
        "reason": "too large" if failed else None,
    }


PLAN = Plan(noisy_trial, CONDITIONS, trials=12, settings={"points": 20})


def run_all(plan: Plan, shards: int, path: Path) -> tuple[bytes, bytes]:
    records, arrays = [], {}
    for shard in reversed(range(shards)):
        pairs = marks.shard_pairs(plan, shard, shards)
        more, drawn = marks.run_trials("fig_0_0", plan, pairs)
        records += more
        arrays |= drawn
    results.gather({"experiment": "e", "effort": "quick"}, plan, records, arrays, path)
    return path.read_bytes(), path.with_suffix(".npz").read_bytes()


@pytest.fixture
def result(tmp_path):
    """The Result of PLAN, of several shards."""
    run_all(PLAN, 5, tmp_path / "r.json")
    return results.Result(tmp_path / "r.json")


def test_result_is_independent_of_shards(tmp_path):
    one = run_all(PLAN, 1, tmp_path / "one.json")
    assert run_all(PLAN, 5, tmp_path / "five.json") == one
    assert run_all(PLAN, 24, tmp_path / "all.json") == one


def test_result_round_trip(result):
    rng = marks.trial_rng("fig_0_0", CONDITIONS[1], 4)
    draws = rng.standard_normal(20)
    assert np.array_equal(result.arrays("draws", noise=1.0)[4], draws)
    means = result.column("method.mean", noise=1.0)
    reasons = result.texts("reason", noise=1.0)
    assert len(means) == 12
    assert np.array_equal(np.isnan(means), [r is not None for r in reasons])
    assert result.settings == {"points": 20}


def test_failed_trial_has_no_value(tmp_path):
    values = iter([1.0, np.nan, 3.0])
    plan = Plan(lambda condition, rng: {"x": next(values)}, [{}], trials=3)
    records, _ = marks.run_trials("fig_0_0", plan, [(0, t) for t in range(3)])
    identity = {"experiment": "e", "effort": "quick"}
    results.gather(identity, plan, records, {}, tmp_path / "r.json")
    found = results.Result(tmp_path / "r.json").column("x")
    np.testing.assert_array_equal(found, [1.0, np.nan, 3.0])


def test_column_requires_one_condition(result):
    with pytest.raises(KeyError, match="2 conditions fit"):
        result.column("method.mean", extent="finite")
    with pytest.raises(KeyError, match="0 conditions fit"):
        result.column("method.mean", noise=7.0)


def test_selection_follows_plan_order(result):
    both = result.select(extent="finite")
    apart = [result.one(noise=noise) for noise in (0.5, 1.0)]
    for read in (lambda s: s.column("method.mean"), lambda s: s.texts("reason")):
        np.testing.assert_array_equal(read(both), np.concatenate([*map(read, apart)]))
    assert np.array_equal(
        both.arrays("draws")[15], result.arrays("draws", noise=1.0)[3]
    )
    assert both.conditions == CONDITIONS


def test_selection_splits_by_levels(result):
    assert result.levels("noise") == [0.5, 1.0]
    parts = result.by("noise", extent="finite")
    assert list(parts) == [0.5, 1.0]
    wanted = result.column("method.count", noise=1.0)
    np.testing.assert_array_equal(parts[1.0].column("method.count"), wanted)


@pytest.mark.parametrize("asked", [{"noise": 7.0}, {"nois": 0.5}, {"nois": None}])
def test_empty_selection_is_rejected(result, asked):
    with pytest.raises(KeyError, match="0 conditions fit"):
        result.select(**asked)


def test_more_trials_keep_first_ones(tmp_path):
    few, many = tmp_path / "few.json", tmp_path / "many.json"
    run_all(PLAN, 1, few)
    run_all(Plan(noisy_trial, CONDITIONS, 30), 4, many)
    short = results.Result(few).column("method.mean", noise=0.5)
    long = results.Result(many).column("method.mean", noise=0.5)
    assert np.array_equal(short, long[:12], equal_nan=True)


def test_plan_with_first_trial_runs_later_trials(tmp_path):
    late = replace(PLAN, first=7, trials=3)
    assert late.pairs == [(c, t) for c in (0, 1) for t in (7, 8, 9)]
    run_all(late, 2, tmp_path / "late.json")
    run_all(PLAN, 1, tmp_path / "whole.json")
    found, whole = (results.Result(tmp_path / f"{n}.json") for n in ("late", "whole"))
    assert (found.first_trial, whole.first_trial) == (7, 0)
    own, same = (one.arrays("draws", noise=1.0) for one in (found, whole))
    np.testing.assert_array_equal(own, same[7:10])


def test_missing_and_duplicate_trials_are_rejected(tmp_path):
    records, _ = marks.run_trials("fig_0_0", PLAN, marks.shard_pairs(PLAN, 0, 2))
    for wrong in (records, records + records):
        with pytest.raises(ValueError, match="of 24 trials missing"):
            results.gather({}, PLAN, wrong, {}, tmp_path / "r.json")
    assert not (tmp_path / "r.json").exists()


def test_result_has_no_nan_and_no_machine_data(result):
    text = result.path.read_text()
    assert {"seconds", "host", "finished", "versions"}.isdisjoint(json.loads(text))
    assert "NaN" not in text


@given(st.lists(st.floats(-1e6, 1e6), min_size=1, max_size=60), st.integers(0, 5))
def test_summary_brackets_median_and_counts_missing(values, missing):
    found = results.summary(values + [None] * missing)
    low, high = found["median_interval"]
    assert low <= found["median"] <= high
    assert (found["n"], found["without_value"]) == (len(values), missing)


def test_summary_matches_manual_example():
    found = results.summary([4.0, None, 1.0, 2.0, 3.0])
    assert (found["n"], found["without_value"]) == (4, 1)
    assert (found["median"], found["mean"]) == (2.5, 2.5)
    # Squares of 1.5, 0.5, 0.5, 1.5 add up to 5; four values leave three degrees.
    assert found["sd"] == pytest.approx(np.sqrt(5 / 3))
    assert results.summary([7.0])["sd"] is None


def test_seeds_differ_by_artefact_condition_trial():
    seeds = {
        tuple(marks.seed_of(a, c, t))
        for a in ("fig_2_3", "fig_2_4")
        for c in CONDITIONS
        for t in range(50)
    }
    assert len(seeds) == 2 * 2 * 50
    assert marks.seed_of("a", {"x": 1, "y": 2}, 0) == marks.seed_of(
        "a", {"y": 2, "x": 1}, 0
    )


def test_interrupted_write_keeps_old_file(tmp_path):
    path = tmp_path / "r.json"
    results.write_json(path, {"old": 1})
    with pytest.raises(ValueError, match="not JSON compliant"):
        results.write_json(path, {"new": float("nan")})
    with pytest.raises(TypeError):
        results.write_atomic(path, None)
    assert json.loads(path.read_text()) == {"old": 1}


def test_unknown_verdict_is_rejected():
    with pytest.raises(ValueError, match="verdict: found 'holds'"):
        Reading("holds", 1.0)


def test_only_holding_decision_is_reproduced():
    assert DECISIONS == {
        "holds": "reproduced",
        "fails": "differs",
        "undecided": "undecided",
        "not comparable": "not comparable",
    }


def test_judged_file_stores_infinity_as_text_and_nan_as_null():
    found = {"value": np.inf, "interval": (-np.inf, np.float64(2)), "other": np.nan}
    plain = {"value": "inf", "interval": ["-inf", 2.0], "other": None}
    assert judging._finite(found) == plain


def test_crossed_varies_last_level_fastest():
    found = crossed(rig=("a", "b"), seed=range(2))
    assert [c["rig"] for c in found] == ["a", "a", "b", "b"]
    assert [c["seed"] for c in found] == [0, 1, 0, 1]


def test_boolean_decision_is_true_or_false():
    exact, off = (Reading.of(np.float64(error) < 1e-9, error) for error in (0.0, 1.0))
    assert (exact.verdict, off.verdict) == ("reproduced", "differs")
    assert Reading.of("undecided", 1.0).verdict == "undecided"
