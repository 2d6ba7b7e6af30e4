"""Build on a Slurm of four nodes on this machine: `make test-cluster`.

A node is drained meanwhile, and one job is stopped until its time limit ends it. All
results must equal those of a build without Slurm. The folders remain in .cache/cluster.
"""

import argparse
import filecmp
import os
import shutil
import subprocess
import sys
import time
from contextlib import suppress
from datetime import datetime
from pathlib import Path
from statistics import median

import psutil

from repro.run.jobs import Size
from repro.workflow import records
from repro.workflow.plan import Plan
from tests.checkout_copies import ROOT, copy_checkout
from tests.cluster import slurm

WORK = ROOT / ".cache" / "cluster"
OF_A_RUN = ("jobs", "logs", "records")
"""Folders of figures/quick that state times."""
SKIPPED = 77
DRAINED = "n2"
UPDATE = "scontrol", "update"
Line = tuple[str, str, bool]
"""What was measured, the measurement, and whether it is as it must be."""


def main() -> int:
    """Build, compare and print; return 1 if something does not hold."""
    parser = argparse.ArgumentParser(prog="make test-cluster", description=__doc__)
    parser.add_argument("--target", default="quick")
    parser.add_argument("--profile", default="slurm")
    parser.add_argument("--local", type=Path, help="checkout with the build to compare")
    options = parser.parse_args()
    if reason := slurm.missing():
        print(f"make test-cluster: skipped ({reason}); run it as root on Debian")
        return SKIPPED
    shutil.rmtree(WORK, ignore_errors=True)
    copy = copied(WORK / "slurm")
    target = "report" if options.target == "quick" else options.target
    plan = Plan(copy, Size("quick"), target=target)
    with slurm.slurm(WORK / "daemons"):
        with started(copy, options.target, f"PROFILE={options.profile}") as build:
            drained, stopped = disturbed(build, len(plan.jobs))
        rows = slurm.jobs()
    local = options.local or copied(WORK / "local")
    if not options.local:
        started(local, options.target, "CORES=2").wait()
    table = [
        ("build on Slurm", f"exit status {build.returncode}", build.returncode == 0),
        ("jobs", f"{len(plan.jobs)} in {len(rows)} jobs of Slurm", True),
        overhead(plan, rows),
        after_drain(rows, drained),
        after_limit(rows, stopped),
        equal_files(copy, local),
    ]
    for name, text, holds in table:
        print(f"{name:18} {text}{'' if holds else '  FAILED'}")
    return 0 if all(row[2] for row in table) else 1


def copied(to: Path) -> Path:
    """Return a copy of the checkout with its environment."""
    (copy_checkout(to) / ".venv").symlink_to(ROOT / ".venv")
    return to


def started(root: Path, target: str, setting: str) -> subprocess.Popen:
    """Start a build in a copy as the README does, without the set-up."""
    environment = os.environ | {"PYTHONPATH": f"{root / 'lib'}{os.pathsep}{root}"}
    order = ["make", "--old-file=setup", target, "EFFORT=quick", setting]
    return subprocess.Popen(order, cwd=root, env=environment)


def disturbed(build: subprocess.Popen, n_jobs: int) -> tuple[datetime, str]:
    """Drain a node after a quarter of the jobs, and stop the first job of another node.

    Returns the time of the one and the id of the other.
    """
    drained, stopped = datetime.max, ""
    while build.poll() is None:
        time.sleep(1)
        rows = slurm.jobs()
        n_done = sum(row.state == "COMPLETED" for row in rows)
        for row in rows:
            if row.state != "RUNNING":
                continue
            if row.node == DRAINED:
                if drained == datetime.max and 4 * n_done >= n_jobs:
                    slurm.asked(
                        *UPDATE, f"nodename={DRAINED}", "state=drain", "reason=test"
                    )
                    drained = datetime.now()
            elif not stopped and (datetime.now() - row.begin).total_seconds() > 10:
                stopped = row.id
                slurm.asked(*UPDATE, f"jobid={stopped}", "timelimit=1")
                stop(stopped)
    return drained, stopped


def stop(job: str) -> None:
    """Stop the processes of a job, as if they waited for a disk."""
    for process in psutil.process_iter():
        with suppress(psutil.Error):
            if process.environ().get("SLURM_JOB_ID") == job:
                process.suspend()


def overhead(plan: Plan, rows: list[slurm.Job]) -> Line:
    """Return the time of a job of Slurm without its tasks, and the time it waited."""
    waited, more = [], []
    for row in rows:
        if row.state == "COMPLETED":
            (tasks,) = [job.tasks for job in plan.jobs.values() if job.name in row.name]
            own = sum(records.read(plan, task.name)["seconds"] for task in tasks)
            more.append((row.end - row.begin).total_seconds() - own)
            waited.append((row.begin - row.submitted).total_seconds())
    times = f"{median(more):.1f} s, after {median(waited):.0f} s in the queue (medians)"
    return "overhead per job", times, True


def after_drain(rows: list[slurm.Job], drained: datetime) -> Line:
    """Return whether the jobs of the drained node ended well, and no other came."""
    there = [row for row in rows if row.node == DRAINED]
    later = [row for row in there if row.begin > drained]
    running = [row for row in there if row.begin <= drained < row.end]
    text = f"drained while {len(running)} job ran there; {len(later)} began there later"
    well = all(row.state == "COMPLETED" for row in there)
    return f"node {DRAINED}", text, well and len(running) == 1 and not later


def after_limit(rows: list[slurm.Job], stopped: str) -> Line:
    """Return whether the job that exceeded its limit ran once more, with more."""
    name = next((row.name for row in rows if row.id == stopped), "")
    tried = [row for row in rows if row.name == name]
    states = [row.state for row in tried]
    text = ", ".join(f"{row.state} ({row.limit}, {row.memory})" for row in tried)
    return "killed and retried", f"{name}: {text}", states == ["TIMEOUT", "COMPLETED"]


def equal_files(one: Path, other: Path) -> Line:
    """Return whether the results of two builds are equal, byte by byte."""
    names = results(one) | results(other)
    equal, unequal, gone = filecmp.cmpfiles(one, other, sorted(names), shallow=False)
    text = f"{len(equal)} of {len(names)}"
    if unequal or gone:
        text += f", not {', '.join([*unequal, *gone][:5])}"
    return "equal files", text, len(equal) == len(names) > 0


def results(root: Path) -> set[str]:
    """Return the files of results, figures, tables and verdicts of a quick build."""
    base = root / "figures" / "quick"
    return {
        path.relative_to(root).as_posix()
        for path in base.rglob("*")
        if path.is_file()
        and path.relative_to(base).parts[0] not in OF_A_RUN
        and not path.name.endswith(records.RUN_RECORD)
    }


if __name__ == "__main__":
    sys.exit(main())
