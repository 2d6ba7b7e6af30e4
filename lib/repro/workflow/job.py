"""One job: its tasks in order, without those whose product is fresh.

python -m repro.workflow.job NAME MARKER --effort full ...
"""

from __future__ import annotations

import argparse
import fcntl
import resource
import signal
import sys
import time
from pathlib import Path

from raxel.errors import InputError
from repro.run.jobs import Size
from repro.run.rendered import declared
from repro.run.results import WRITTEN, write_json
from repro.workflow import records
from repro.workflow.plan import BuildPlan, BuildTask, Job, planned

COST = ("seconds", "processor_seconds", "peak_mb")
USED = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)


def run(plan: BuildPlan, job: Job) -> None:
    """Make what is not fresh, then leave the marker of the job.

    Another process may still run the job, where a build was killed: it is waited for.
    """
    marker = plan.root / plan.marker(job)
    marker.parent.mkdir(parents=True, exist_ok=True)
    with marker.with_suffix(".lock").open("w") as lock:
        fcntl.flock(lock, fcntl.LOCK_EX)
        for task in job.tasks:
            if records.fresh(plan, task):
                print(f"{task.name}: unchanged", flush=True)
            elif records.covered(plan, task):
                print(f"{task.name}: not needed", flush=True)
                needs = records.digests(plan, task.needs)
                records.write(plan, task, needs, dict.fromkeys(COST, 0.0), ())
            else:
                _make(plan, task)
    write_json(marker, records.digests(plan, [task.name for task in job.tasks]))


def _make(plan: BuildPlan, task: BuildTask) -> None:
    print(f"{task.name}:", flush=True)
    plan.record(task.name).unlink(missing_ok=True)
    needs, before = records.digests(plan, task.needs), len(WRITTEN)
    start, used = time.monotonic(), _processor_seconds()
    try:
        with declared(()):  # an experiment opens its own; other tasks open none
            task.make()
    except BaseException as fault:
        fault.add_note(f"in {task.name}")
        raise
    peak_kb = max(resource.getrusage(who).ru_maxrss for who in USED)
    took = time.monotonic() - start, _processor_seconds() - used, peak_kb / 1024
    cost = {name: round(value, 2) for name, value in zip(COST, took, strict=True)}
    records.write(plan, task, needs, cost, WRITTEN[before:])


def _processor_seconds() -> float:
    """Of this process, and of the processes that it has waited for."""
    used = [resource.getrusage(who) for who in USED]
    return sum(one.ru_utime + one.ru_stime for one in used)


def _leave(number: int, frame: object) -> None:
    """End the job; unfinished files are removed."""
    signal.signal(number, signal.SIG_IGN)
    raise SystemExit(128 + number)


def main(argv: list[str] | None = None) -> int:
    """Run one job of a plan; return its exit status."""
    parser = argparse.ArgumentParser(prog="python -m repro.workflow.job")
    parser.add_argument("stage")
    parser.add_argument("name")
    parser.add_argument("--effort", required=True)
    parser.add_argument("--trials", type=int)
    parser.add_argument("--scale", type=int, default=1)
    parser.add_argument("--recorded", default="")
    parser.add_argument("--target", default="report")
    parser.add_argument("--readings", default="open")
    a = parser.parse_args(argv)
    for number in (signal.SIGINT, signal.SIGTERM):
        signal.signal(number, _leave)
    size = Size(a.effort, a.trials, a.scale)
    plan = planned(Path.cwd(), size, a.recorded, a.target, a.readings)
    try:
        run(plan, plan.jobs[a.stage, a.name])
    except InputError as fault:
        print(fault, file=sys.stderr)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
