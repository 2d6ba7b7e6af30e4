"""What the start page may quote: figures, tables and trials of the build.

An answer is empty where the build has no such thing: the page can leave it out.
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
        """Values of each trial of an experiment, name -> value."""
        path = self.base / "results" / f"{experiment}.json"
        if not path.is_file():
            return []
        trials = json.loads(path.read_text("utf-8"))["trials"]
        return [trial["values"] for trial in trials]
