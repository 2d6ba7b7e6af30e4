"""Results that tests make up, written and read as a build writes and reads them.

They are `repro.run.results.Result`, in the conditions of the experiment's own plan: a
claim that reads a condition which no plan has fails here as in a build.
"""

import functools
import itertools
import tempfile
from pathlib import Path

import numpy as np

from repro.run.jobs import Order, Size, producer
from repro.run.marks import run_trials
from repro.run.outcomes import Plan
from repro.run.rendered import declared
from repro.run.results import Result, gather

ROOT = Path(__file__).resolve().parents[1]
FOLDER = tempfile.TemporaryDirectory(prefix="made-results-")
COUNT = itertools.count()


def written(plan, experiment="made_up", effort="full"):
    """The Result of a plan, run here."""
    records, arrays = run_trials(experiment, plan, plan.pairs)
    path = Path(FOLDER.name) / f"{next(COUNT)}_{experiment}.json"
    gather({"experiment": experiment, "effort": effort}, plan, records, arrays, path)
    return Result(path)


@functools.cache
def plan_of(experiment):
    """The plan of an experiment that reads no other, at full size."""
    found = producer(ROOT, "experiment", experiment)
    order = Order(experiment, Size("full"), results=ROOT)
    with declared(found.rendered("full")):
        return order.plan(ROOT, found)


def of_seed(trial, conditions=({},), seed=0):
    """The Result of one trial in each condition, all with the draws of one seed."""
    return written(
        Plan(lambda c, _: trial(c, np.random.default_rng(seed)), conditions, 1)
    )


def of_columns(*made, settings=None):
    """The Result of pairs (condition, {name: value of each trial}).

    A value that is no sequence is that of every trial; arrays are values too.
    """
    lengths = {len(v) for _, values in made for v in values.values() if _is_column(v)}
    assert len(lengths) <= 1, f"columns of {lengths} trials"
    count = max(lengths, default=1)
    places = itertools.product([values for _, values in made], range(count))

    def trial(condition, rng):
        values, t = next(places)
        return {n: v[t] if _is_column(v) else v for n, v in values.items()}

    return written(
        Plan(trial, [condition for condition, _ in made], count, settings or {})
    )


def of_levels(*plans):
    """{experiment: Result of rig A} of plans (experiment, error levels, columns).

    columns: a function of the level that gives {name: value of each trial}.
    """
    return {
        name: of_columns(
            (
                {"geometry": "A"},
                {key: v for level in levels for key, v in columns(level).items()},
            )
        )
        for name, levels, columns in plans
    }


def as_planned(experiment, values):
    """The Result of an experiment with these columns in each condition of its plan.

    values: {name: value of each trial}, or a function of the condition that gives it.
    """
    plan = plan_of(experiment)
    of = values if callable(values) else lambda condition: values
    return of_columns(*((c, of(c)) for c in plan.conditions), settings=plan.settings)


def flat(values, prefix=""):
    """The nested values of a trial by their dotted names."""
    out = {}
    for key, value in values.items():
        if isinstance(value, dict):
            out |= flat(value, f"{prefix}{key}.")
        else:
            out[prefix + key] = value
    return out


def _is_column(value):
    return isinstance(value, list | tuple) or np.ndim(value) > 0


class OfLaw(Result):
    """A Result whose values a law gives when they are read.

    law(name, condition) -> the value of each trial, (trials,); ``conditions`` are a
    list, or the experiment whose plan has them.
    """

    def __init__(self, conditions, law, trials):
        if isinstance(conditions, str):
            conditions = plan_of(conditions).conditions
        empty = Plan(lambda condition, rng: {}, conditions, trials)
        super().__init__(written(empty).path)
        columns = [
            functools.cache(functools.partial(law, condition=condition))
            for condition in self.conditions
        ]
        self._values = [
            [_Asked(column, t) for t in range(trials)] for column in columns
        ]


class _Asked:
    """The values of one trial, as a dictionary that does not know its names."""

    def __init__(self, column, trial):
        self.column, self.trial = column, trial

    def get(self, name):
        return float(self.column(name)[self.trial])
