"""Costs of a build: stored for the plan, and shown as a table by `make times`."""

from types import SimpleNamespace

import pytest

from repro.run.discover import Producer
from repro.run.results import write_json
from repro.workflow import costs, times
from repro.workflow.costs import Cost


@pytest.fixture
def plan(tmp_path):
    """A finished build of an experiment in two parts, a figure and a site."""
    made = [
        Producer("experiment", "sweep", "chapters.c.s.page", "f", "c/s", 1, {}),
        Producer("figure", "fig", "chapters.c.s.page", "g", "c/s", 9, {}),
    ]
    seconds = {
        "set/rig/0": 64.0, "part/sweep/0-of-2": 1.0, "part/sweep/1-of-2": 2.0,
        "experiment/sweep": 0.5, "figure/fig": 8.0, "notebook/c/s": 16.0, "site": 32.0,
    }  # fmt: skip
    names = [*seconds, "figure/not made"]
    plan = SimpleNamespace(
        root=tmp_path, base="figures/quick", made=made, tasks=names,
        record=lambda name: tmp_path / "records" / f"{name}.json",
    )  # fmt: skip
    for place, (name, used) in enumerate(seconds.items()):
        record = {
            "processor_seconds": used,
            "peak_mb": 100.0 + place,
            "files": {"x": 1},
        }
        write_json(plan.record(name), record)
    result = {"trials_per_condition": 5, "trials": [{}] * 10}
    write_json(tmp_path / "figures/quick/results/sweep.json", result)
    return plan


def test_costs_of_build_are_stored_per_effort(plan):
    found = times.measured(plan.root, plan)
    assert found["experiment/sweep"] == Cost(3.5, 103.0, 5, 10)
    assert "figure/not made" not in found
    (plan.root / costs.TABLE).parent.mkdir(parents=True)
    times.keep(plan.root, "full", {"site": Cost(1.0, 2.0)})
    times.keep(plan.root, "quick", found)
    assert costs.costs(plan.root, "quick") == found
    assert costs.costs(plan.root, "full") == {"site": Cost(1.0, 2.0)}


def test_times_sum_costs_by_page(plan):
    rows = times.rows_of(plan, times.measured(plan.root, plan))
    assert rows == [
        ("c/s", 3.5, 8.0, 16.0, 27.5, 105.0),
        ("image sets", 64.0, 0.0, 0.0, 64.0, 100.0),
        ("site", 0.0, 0.0, 32.0, 32.0, 106.0),
    ]
