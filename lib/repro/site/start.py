"""Content for the start page: figures, tables and trials of the build.

Results are empty if the build lacks them, so that the page can omit them.
"""

from __future__ import annotations

import csv
import json
from dataclasses import dataclass
from pathlib import Path


@dataclass(frozen=True)
class Quotable:
    """The files below ``base``."""

    base: Path

    def drawn(self, figure: str) -> bool:
        """Return whether the build has a figure."""
        return (self.base / f"{figure}.svg").is_file()

    def only_lines(self, figure: str) -> bool:
        """Return whether a figure of the build contains no image
        (`repro.page.style`)."""
        return bool(json.loads((self.base / f"{figure}.json").read_text())["lines"])

    def lines_of(self, artefact: str) -> list[dict[str, str]]:
        """Return lines of a table, or of the data of a figure: column -> cell."""
        path = self.base / f"{artefact}.csv"
        if not path.is_file():
            return []
        with path.open(encoding="utf-8", newline="") as file:
            return list(csv.DictReader(file))

    def trials_of(self, experiment: str) -> list[dict]:
        """Return the values of each trial of an experiment, name -> value."""
        path = self.base / "results" / f"{experiment}.json"
        if not path.is_file():
            return []
        trials = json.loads(path.read_text("utf-8"))["trials"]
        return [trial["values"] for trial in trials]
