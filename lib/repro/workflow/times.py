"""Processor time and memory of a finished build: shown, or kept for the plan.

    python -m repro.workflow.times --effort full          # make times
    python -m repro.workflow.times --effort full --keep   # make costs

They are in the records of the tasks (`repro.workflow.records`).
"""

from __future__ import annotations

import argparse
import csv
import json
import sys
from collections import defaultdict
from collections.abc import Mapping
from io import StringIO
from pathlib import Path

from raxel.io.files import write_whole
from repro.run.jobs import Size
from repro.workflow.costs import FIELDS, TABLE, Cost, costs
from repro.workflow.plan import BuildPlan, planned

COLUMNS = ("page", "experiments (s)", "drawn (s)", "rest (s)", "all (s)", "peak (MB)")


def measured(root: Path, plan: BuildPlan) -> dict[str, Cost]:
    """Return task -> cost of a finished build, in the order of the plan."""
    sums: dict[str, Cost] = {}
    for name in plan.tasks:
        path = plan.record(name)
        if not path.is_file():
            continue
        record = json.loads(path.read_text("utf-8"))
        if not record["files"]:  # a part that was not needed
            continue
        kind, _, rest = name.partition("/")
        key = f"experiment/{rest.partition('/')[0]}" if kind == "part" else name
        before = sums.get(key, Cost(0.0, 0.0))
        trials, pairs = _trials(plan, rest) if kind == "experiment" else (1, 1)
        sums[key] = Cost(
            before.seconds + record["processor_seconds"],
            max(before.peak_mb, record["peak_mb"]), trials, pairs,
        )  # fmt: skip
    return sums


def _trials(plan: BuildPlan, experiment: str) -> tuple[int, int]:
    path = plan.root / plan.base / "results" / f"{experiment}.json"
    content = json.loads(path.read_text("utf-8"))
    return content["trials_per_condition"], len(content["trials"])


def keep(root: Path, effort: str, found: Mapping[str, Cost]) -> None:
    """Store the costs of one effort. Others, and those not measured now, remain."""
    text = StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(FIELDS)
    for one in ("quick", "full"):
        known = costs(root, one) | (found if one == effort else {})
        for name, cost in sorted(known.items()):
            table.writerow(
                [one, name, round(cost.seconds, 1), round(cost.peak_mb), *cost[2:]]
            )
    write_whole(root / TABLE, text.getvalue())


def rows_of(plan: BuildPlan, found: Mapping[str, Cost]) -> list[tuple]:
    """Return rows of `COLUMNS`: one for each page, the image sets, and the site."""
    pages = {f"{p.kind}/{p.id}": p.page for p in plan.made}
    columns = {"experiment": 0, "figure": 1, "table": 1}
    sums: dict[str, list[float]] = defaultdict(lambda: [0.0, 0.0, 0.0, 0.0])
    for name, cost in found.items():
        kind, _, rest = name.partition("/")
        page = pages.get(name, rest if kind in ("judged", "notebook") else name)
        if kind in ("set", "recorded"):
            page, column = "image sets", 0
        else:
            column = columns.get(kind, 2)
        sums[page][column] += cost.seconds
        sums[page][3] = max(sums[page][3], cost.peak_mb)
    return [(page, *s[:3], sum(s[:3]), s[3]) for page, s in sorted(sums.items())]


def main(argv: list[str] | None = None) -> int:
    """Print the table, or store the costs; return 1 without a build."""
    parser = argparse.ArgumentParser(prog="make times", description=__doc__)
    parser.add_argument("--effort", choices=("quick", "full"), default="full")
    parser.add_argument("--keep", action="store_true")
    options = parser.parse_args(argv)
    root = Path.cwd()
    plan = planned(root, Size(options.effort), "", "report", "open")
    found = measured(root, plan)
    if not found:
        print(f"make times: no {options.effort} build; make it first", file=sys.stderr)
        return 1
    if options.keep:
        keep(root, options.effort, found)
        return 0
    rows = rows_of(plan, found)
    width = max(len(row[0]) for row in rows)
    print(f"{COLUMNS[0]:{width}}", *(f"{name:>15}" for name in COLUMNS[1:]))
    whole = [sum(column) for column in list(zip(*rows, strict=True))[1:5]]
    rows.append(("all", *whole, max(row[5] for row in rows)))
    for name, *numbers in rows:
        print(f"{name:{width}}", *(f"{number:15.1f}" for number in numbers))
    return 0


if __name__ == "__main__":
    sys.exit(main())
