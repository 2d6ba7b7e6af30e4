"""Trials of chapter 2 run in memory, and judged."""

import numpy as np


class Trials:
    """Stands for a Result: values by name and condition; arrays by name."""

    trials_per_condition = 1

    def __init__(self, values):
        self.values = values

    def column(self, name, **condition):
        found = self.values(name, condition) if callable(self.values) else None
        found = self.values[name] if found is None else found
        return np.atleast_1d(np.asarray(found, float))

    def arrays(self, name, **condition):
        found = self.values(name, condition)
        return [] if found is None else [found]


def ran(trial, conditions, seed=0):
    """A Trials of one real trial per condition, values nested by points."""
    made = [(c, flat(trial(c, np.random.default_rng(seed)))) for c in conditions]

    def values(name, condition):
        fits = [v for c, v in made if condition.items() <= c.items()]
        assert len(fits) == 1
        return fits[0].get(name)

    return Trials(values)


def flat(values, prefix=""):
    out = {}
    for key, value in values.items():
        if isinstance(value, dict):
            out |= flat(value, f"{prefix}{key}.")
        else:
            out[prefix + key] = value
    return out


def verdict(judge, experiment, values):
    (reading,) = judge({experiment: Trials(values)})
    return reading.verdict
