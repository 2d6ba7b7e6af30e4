"""The record of a task: its key, its inputs, its cost, and the files that it wrote.

A product is fresh if its record has the key of today and the digests of the products
it needs, and if its files are unchanged. Results and figures are read for that; of the
rendered sets and the site, which are large, size and time are compared first.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path
from typing import Any

from repro.run.results import hash_of, write_json
from repro.workflow.plan import BuildPlan, BuildTask, digest
from repro.workflow.terminal import say

MAX_LINES = 10
LARGE = ("report/", "data/synthetic/")
OF_TASKS = ("figures/", *LARGE)
RUN_RECORD = ".run.json"
"""A file of an experiment that differs between runs: host, time, versions."""


def read(plan: BuildPlan, task: str) -> dict[str, Any] | None:
    """Return the record of a task; None if it is missing or damaged."""
    try:
        record = json.loads(plan.record(task).read_text("utf-8"))
        named = all(
            name.startswith(OF_TASKS) and ".." not in Path(name).parts
            for name in record["files"]
        )
        return record if named and record["key"] and record["digest"] else None
    except (OSError, ValueError, KeyError, TypeError, AttributeError):
        return None


def fresh(plan: BuildPlan, task: BuildTask) -> bool:
    """Return whether the product of a task is the one that it would make now."""
    record = read(plan, task.name)
    return (
        record is not None
        and record["key"] == task.key()
        and record["needs"] == digests(plan, task.needs)
        and not damaged(plan.root, record)
    )


def covered(plan: BuildPlan, task: BuildTask) -> bool:
    """Return whether a part is not needed, because its experiment's result is fresh."""
    result = plan.tasks.get(task.covered_by)
    return result is not None and fresh(plan, result)


def digests(plan: BuildPlan, tasks: Iterable[str]) -> dict[str, str]:
    """Return task -> digest of its product, without parts.

    A result does not depend on its division into parts.
    """
    products = [name for name in tasks if not name.startswith("part/")]
    return {name: (read(plan, name) or {}).get("digest", "") for name in products}


def write(
    plan: BuildPlan,
    task: BuildTask,
    needs: dict[str, str],
    cost: dict,
    files: Iterable[Path],
) -> None:
    """Write the record of a finished task."""
    known = {
        path.as_posix(): [*stat_of(path), hash_of(path)]
        for path in dict.fromkeys(files)
        if path.is_file()
    }
    hashes = {n: k[2] for n, k in known.items() if not n.endswith(RUN_RECORD)}
    content = {"key": task.key(), "needs": needs, "digest": digest(hashes)}
    write_json(plan.record(task.name), content | cost | {"files": known})


def damaged(root: Path, record: dict) -> list[str]:
    """Return the files of a record that are missing or changed."""
    return [
        name
        for name, known in record["files"].items()
        if not _intact(root / name, known, large=name.startswith(LARGE))
    ]


def drop_damaged(plan: BuildPlan) -> None:
    """Remove changed files and their records, with one line for each.

    A job without the records of all its tasks runs again.
    """
    lost: list[str] = []
    for job in plan.jobs.values():
        marker = plan.root / plan.marker(job)
        for task in job.tasks:
            record = read(plan, task.name)
            wrong = damaged(plan.root, record) if record else []
            lost += [name for name in wrong if (plan.root / name).is_file()]
            for name in wrong:
                (plan.root / name).unlink(missing_ok=True)
            if wrong:
                plan.record(task.name).unlink()
            if wrong or record is None:
                marker.unlink(missing_ok=True)
    for job in plan.jobs.values():
        for task in job.tasks:
            # A part that was not needed is, if the result is lost.
            record = read(plan, task.name) if task.covered_by else None
            if record and not record["files"] and not read(plan, task.covered_by):
                plan.record(task.name).unlink()
                (plan.root / plan.marker(job)).unlink(missing_ok=True)
    for name in lost[:MAX_LINES]:
        say(f"{name}: damaged; it will be made again")
    if len(lost) > MAX_LINES:
        say(f"{len(lost) - MAX_LINES} more files: the same")


def stat_of(path: Path) -> list[int]:
    """Return size and modification time in ns."""
    found = path.stat()
    return [found.st_size, found.st_mtime_ns]


def _intact(path: Path, known: list, large: bool) -> bool:
    if not path.is_file():
        return False
    return (large and stat_of(path) == known[:2]) or hash_of(path) == known[2]
