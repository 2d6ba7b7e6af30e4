"""How long an artefact took: the experiments behind it, and their run records."""

from __future__ import annotations

import json
from collections.abc import Iterable, Sequence
from pathlib import Path

from repro.run.discover import Producer, per_set_experiments, result_ids, results_read


def results_behind(made: Sequence[Producer], read: Iterable[str]) -> list[str]:
    """The result ids of ``read`` and of every experiment behind them, each once.

    ``made`` are the producers of all chapters.
    """
    needs = {p.id: p.needs for p in made if p.kind == "experiment"}
    per_set = per_set_experiments(made)
    found: list[str] = []
    waiting = list(read)
    while waiting:
        result = waiting.pop(0)
        if result not in found:
            found.append(result)
            experiment, _, own = result.partition("@")
            needed = results_read(needs.get(experiment, ()), per_set, own, ())
            waiting += result_ids(needed)
    return found


def seconds_of(folder: Path, results: Iterable[str]) -> float | None:
    """Seconds that the runs of ``results`` took, added up; None without a record."""
    records = [folder / f"{name}.run.json" for name in results]
    took = [
        float(json.loads(path.read_text("utf-8"))["seconds"])
        for path in records
        if path.is_file()
    ]
    return sum(took) if took else None


def duration(seconds: float) -> str:
    """A time in words, so coarse that the next run mostly takes as long."""
    if seconds < 1:
        return "under 1 s"
    if seconds < 10:
        return f"{seconds:.0f} s"
    if seconds < 57.5:
        return f"{5 * round(seconds / 5)} s"
    if seconds < 90 * 60:
        return f"{max(1, round(seconds / 60))} min"
    return f"{seconds / 3600:.1f} h"
