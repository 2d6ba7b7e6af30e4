"""Store the costs of a finished build, from which other builds are planned.

    python -m repro.workflow.kept_costs --effort full    # make costs

They are in the records of the tasks (`repro.workflow.records`). Those of a build with a
SCALE are stored as efforts of their own, to compare them with the model
(`repro.workflow.scale`).
"""

from __future__ import annotations

import argparse
import csv
import json
import sys
from collections.abc import Mapping
from io import StringIO
from pathlib import Path

from raxel.io.files import write_whole
from repro.run.jobs import Size
from repro.workflow.costs import FIELDS, TABLE, Cost, costs
from repro.workflow.plan import BuildPlan, planned


def measured(plan: BuildPlan) -> dict[str, Cost]:
    """Return task -> cost of a finished build, in the order of the plan."""
    sums: dict[str, Cost] = {}
    for name in plan.tasks:
        path = plan.record(name)
        record = json.loads(path.read_text("utf-8")) if path.is_file() else {}
        if not record.get("files"):  # not made, or a part that was not needed
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
    known = costs(root)
    known[effort] = known.get(effort, {}) | found
    text = StringIO()
    table = csv.writer(text, lineterminator="\n")
    table.writerow(FIELDS)
    for one, rows in sorted(known.items()):
        for name, cost in sorted(rows.items()):
            table.writerow(
                [one, name, round(cost.seconds, 1), round(cost.peak_mb), *cost[2:]]
            )
    write_whole(root / TABLE, text.getvalue())


def main(argv: list[str] | None = None) -> int:
    """Store the costs; return 1 without a build."""
    parser = argparse.ArgumentParser(prog="make costs", description=__doc__)
    parser.add_argument("--effort", choices=("quick", "full"), default="full")
    parser.add_argument("--scale", type=int, default=1)
    options = parser.parse_args(argv)
    size = Size(options.effort, None, options.scale)
    plan = planned(Path.cwd(), size, "", "report", "open")
    try:
        found = measured(plan)
    except (OSError, ValueError):  # a record is cut, or a result is missing
        found = {}
    if not found:
        print(
            f"make costs: no whole {size.name} build; run make report (or quick) first",
            file=sys.stderr,
        )
        return 1
    # Image sets are those of a build without SCALE.
    own = "" if options.scale == 1 else "experiment/"
    keep(plan.root, size.name, {n: found[n] for n in found if n.startswith(own)})
    return 0


if __name__ == "__main__":
    sys.exit(main())
