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


def costs(root: Path, effort: str) -> dict[str, Cost]:
    """Return task -> stored cost; an experiment is ``experiment/ID``."""
    if not (root / TABLE).is_file():
        return {}
    with (root / TABLE).open(encoding="utf-8", newline="") as file:
        rows = [row for row in csv.DictReader(file) if row["effort"] == effort]
    return {
        row["task"]: Cost(
            float(row["seconds"]), float(row["peak_mb"]),
            int(row["trials"]), int(row["pairs"]),
        )
        for row in rows
    }  # fmt: skip
