"""What the start page may quote: verdicts, tables and trials of the build.

An answer is empty where the build has no such thing: the page can leave it out.
"""

from __future__ import annotations

import csv
import json
from collections.abc import Mapping, Sequence
from dataclasses import dataclass
from functools import cached_property
from numbers import Real
from pathlib import Path


@dataclass(frozen=True)
class Quotable:
    """The files below ``base``, and ``board``, the rows of the scoreboard."""

    base: Path
    board: Sequence[Mapping]

    @cached_property
    def row(self) -> dict[str, Mapping]:
        """Rows of the scoreboard by id."""
        return {row["id"]: row for row in self.board}

    def measured(self, identifier: str) -> bool:
        """Whether a row has a regenerated number."""
        return isinstance(self.row.get(identifier, {}).get("regenerated"), Real)

    def drawn(self, figure: str) -> bool:
        """Whether the build has a figure."""
        return (self.base / f"{figure}.svg").is_file()

    def only_lines(self, figure: str) -> bool:
        """Whether a figure of the build has no picture in it (`repro.page.style`)."""
        return bool(json.loads((self.base / f"{figure}.json").read_text())["lines"])

    def lines_of(self, artefact: str) -> list[dict[str, str]]:
        """Lines of a table, or of the data behind a figure: column -> cell."""
        path = self.base / f"{artefact}.csv"
        if not path.is_file():
            return []
        with path.open(encoding="utf-8", newline="") as file:
            return list(csv.DictReader(file))

    def trials_of(self, experiment: str) -> list[dict]:
        """Values of each trial of an experiment; `raxel.right` is nested in `raxel`."""
        path = self.base / "results" / f"{experiment}.json"
        if not path.is_file():
            return []
        trials = json.loads(path.read_text("utf-8"))["trials"]
        return [_nested(trial["values"]) for trial in trials]


def _nested(values: Mapping[str, object]) -> dict:
    found: dict = {}
    for name, value in values.items():
        *outer, last = name.split(".")
        place = found
        for part in outer:
            place = place.setdefault(part, {})
        place[last] = value
    return found
