"""Costs of a build: stored for the plan, and the model of larger builds."""

from types import SimpleNamespace

import numpy as np
import pytest

from repro.run.discover import Producer
from repro.run.results import write_json
from repro.workflow import costs, kept_costs, scale
from repro.workflow.costs import Cost
from tests.small_checkouts import ROOT


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
    found = kept_costs.measured(plan)
    assert found["experiment/sweep"] == Cost(3.5, 103.0, 5, 10)
    assert "figure/not made" not in found
    (plan.root / costs.TABLE).parent.mkdir(parents=True)
    kept_costs.keep(plan.root, "full", {"site": Cost(1.0, 2.0)})
    kept_costs.keep(plan.root, "quick", found)
    assert costs.costs(plan.root) == {"quick": found, "full": {"site": Cost(1.0, 2.0)}}


def test_model_multiplies_repeated_trials_only():
    parts = scale.parts(ROOT)
    once, ten, hundred = np.transpose([hours for hours, _ in parts.values()])
    names = list(parts)
    fixed = [names.index(name) for name in (scale.SETS, scale.REST)]
    assert (once[fixed] == hundred[fixed]).all()
    chapter = names.index("ch05_flexible_mirror")
    repeated = (ten - once)[chapter] / 9
    assert 0.5 * once[chapter] < repeated < once[chapter]
    assert hundred[chapter] == pytest.approx(once[chapter] + 99 * repeated, 1e-3)
