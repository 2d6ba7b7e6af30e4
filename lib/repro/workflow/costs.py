"""Measured costs of the tasks, from which the jobs of a build are planned."""

from __future__ import annotations

import csv
from pathlib import Path
from typing import NamedTuple

TABLE = Path("lib/repro/workflow/costs.csv")
FIELDS = ("effort", "task", "seconds", "peak_mb", "trials", "pairs")


class Cost(NamedTuple):
    """Measured cost of a task; of an experiment, the sum over its parts.

    ``trials`` per condition and ``pairs`` (condition, trial) in all are 1 for what is
    not an experiment.
    """

    seconds: float
    peak_mb: float
    trials: int = 1
    pairs: int = 1


def costs(root: Path) -> dict[str, dict[str, Cost]]:
    """Return name of the build's size -> task -> cost; the experiment ID is
    ``experiment/ID``."""
    found: dict[str, dict[str, Cost]] = {}
    if (root / TABLE).is_file():
        lines = (root / TABLE).read_text("utf-8").splitlines()[1:]
        try:
            for effort, task, seconds, peak_mb, trials, pairs in csv.reader(lines):
                cost = Cost(float(seconds), float(peak_mb), int(trials), int(pairs))
                found.setdefault(effort, {})[task] = cost
        except ValueError:
            raise ValueError(f"{TABLE}: a damaged line; restore it from git") from None
    return found
