"""`make times`: processor seconds and peak memory of a finished build, page by page.

They are in the records of the jobs (`repro.workflow.job`). Results of an earlier build
count with the time that they took then.
"""

from __future__ import annotations

import argparse
import json
import sys
from collections import defaultdict
from pathlib import Path

from repro.run.discover import producers
from repro.run.rendered import TIMES as SET_TIMES

PRODUCED = ("experiment", "figure", "table")
COLUMNS = ("page", "experiments (s)", "drawn (s)", "rest (s)", "all (s)", "peak (MB)")


def rows_of(root: Path, effort: str) -> list[tuple]:
    """Return rows of `COLUMNS`: one for each page, the image sets, scoreboard and
    site."""
    folder = root / "figures" / effort / "times"
    pages = {(p.kind, p.id): p.page for p in producers(root)}
    sums: dict[str, list[float]] = defaultdict(lambda: [0.0, 0.0, 0.0, 0.0])
    for path in sorted(folder.rglob("*.json")):
        kind, _, name = (
            path.relative_to(folder).with_suffix("").as_posix().partition("/")
        )
        made = "experiment" if kind == "result" else kind
        identifier = name.partition("/")[0]
        if made in PRODUCED and (made, identifier) not in pages:
            continue  # of a removed producer
        page = pages.get(
            (made, identifier), name if kind in ("judge", "page") else kind
        )
        column = {"experiment": 0, "figure": 1, "table": 1}.get(made, 2)
        _add(sums[page], column, path)
    for path in sorted((root / SET_TIMES).rglob("*.json")):
        _add(sums["image sets"], 0, path)
    return [(page, *s[:3], sum(s[:3]), s[3]) for page, s in sorted(sums.items())]


def _add(sums: list[float], column: int, path: Path) -> None:
    record = json.loads(path.read_text("utf-8"))
    sums[column] += record["processor_seconds"]
    sums[3] = max(sums[3], record.get("peak_mb", 0.0))


def main(argv: list[str] | None = None) -> int:
    """Print the table; return 1 without a build."""
    parser = argparse.ArgumentParser(prog="make times", description=__doc__)
    parser.add_argument("--effort", choices=("quick", "full"), default="full")
    effort = parser.parse_args(argv).effort
    rows = rows_of(Path.cwd(), effort)
    if not rows:
        print(f"make times: no {effort} build; make it first", file=sys.stderr)
        return 1
    width = max(len(row[0]) for row in rows)
    print(f"{COLUMNS[0]:{width}}", *(f"{name:>15}" for name in COLUMNS[1:]))
    whole = [sum(column) for column in list(zip(*rows, strict=True))[1:5]]
    rows.append(("all", *whole, max(row[5] for row in rows)))
    for name, *numbers in rows:
        print(f"{name:{width}}", *(f"{number:15.1f}" for number in numbers))
    return 0


if __name__ == "__main__":
    sys.exit(main())
