"""Build on a Slurm of four nodes on this machine: `make test-cluster`.

A node is drained meanwhile, and one job is stopped until its time limit ends it. All
results must equal those of a build without Slurm. The folders remain in .cache/cluster.
"""

import argparse
import os
import shutil
import subprocess
import sys
import time
from contextlib import suppress
from datetime import datetime, timedelta
from pathlib import Path
from statistics import median

import psutil

from repro.run.jobs import Size
from repro.workflow import records
from repro.workflow.plan import BuildPlan
from tests.verify import ROOT, copy_of_checkout, finished, products

WORK = ROOT / ".cache" / "cluster"
SLURM = Path(__file__).with_name("slurm.sh")
SCONTROL = "scontrol", "--oneliner"
DRAINED = "n2"
BEGUN = timedelta(seconds=10)
Job = dict[str, str]  # fields of a job of Slurm; Comment identifies the job of the plan
Line = tuple[str, str, bool]  # what was measured, the result, whether it is right


def main() -> int:
    """Build, compare and print; return 1 if something does not hold."""
    parser = argparse.ArgumentParser(prog="make test-cluster", description=__doc__)
    parser.add_argument("--target", default="quick")
    parser.add_argument("--profile", default="slurm")
    parser.add_argument("--local", type=Path, help="checkout with the build to compare")
    options = parser.parse_args()
    shutil.rmtree(WORK, ignore_errors=True)
    (WORK / "daemons").mkdir(parents=True)
    status = subprocess.run([SLURM, "start", WORK / "daemons"]).returncode
    if status:
        return status
    try:
        copy = copy_of_checkout(WORK / "slurm")
        target = options.target.replace("quick", "report")
        plan = BuildPlan(copy, Size("quick"), target=target)
        with started(copy, options.target, options.profile) as build:
            drained, stopped = disturbed(build, len(plan.jobs))
        jobs = slurm_jobs()
    finally:
        subprocess.run([SLURM, "stop", WORK / "daemons"])
    local = options.local
    if local is None:
        local = copy_of_checkout(WORK / "local")
        finished(local, options.target, 2)
    table = [
        ("build on Slurm", f"exit status {build.returncode}", build.returncode == 0),
        ("jobs", f"{len(plan.jobs)} in {len(jobs)} jobs of Slurm", True),
        overhead(plan, jobs),
        after_drain(jobs, drained),
        after_limit(jobs, stopped),
        equal_files(copy, local),
    ]
    for name, text, holds in table:
        print(f"{name:18} {text}{'' if holds else '  FAILED'}")
    return 0 if all(holds for _, _, holds in table) else 1


def started(root: Path, target: str, profile: str) -> subprocess.Popen:
    """Start a build in a copy as the README does, with the environment of this one."""
    (root / ".venv").symlink_to(ROOT / ".venv")
    environment = os.environ | {"PYTHONPATH": f"{root / 'lib'}{os.pathsep}{root}"}
    order = ["make", "--old-file=setup", target, "EFFORT=quick", f"PROFILE={profile}"]
    return subprocess.Popen(order, cwd=root, env=environment)


def slurm_jobs() -> list[Job]:
    """Return all jobs in the order of their submission."""
    shown = subprocess.run([*SCONTROL, "show", "job"], capture_output=True, text=True)
    jobs = [
        {"Comment": "", **dict(w.split("=", 1) for w in line.split() if "=" in w)}
        for line in shown.stdout.splitlines()
        if line.startswith("JobId=")
    ]
    for job in jobs:
        job["Comment"] = job["Comment"] or job["JobName"]
    return sorted(jobs, key=lambda job: int(job["JobId"]))


def when(job: Job, event: str) -> datetime:
    """Return the time at which a job was submitted, began or ended."""
    return datetime.fromisoformat(job[f"{event}Time"])


def disturbed(build: subprocess.Popen, n_jobs: int) -> tuple[datetime, str]:
    """Drain a node after a quarter of the jobs, and stop the first job of another node.

    Returns the time of the one and the id of the other.
    """
    drained, stopped = datetime.max, ""
    while build.poll() is None:
        time.sleep(1)
        jobs = slurm_jobs()
        middle = 4 * sum(job["JobState"] == "COMPLETED" for job in jobs) >= n_jobs
        for job in (job for job in jobs if job["JobState"] == "RUNNING"):
            if job["NodeList"] == DRAINED:
                if middle and drained == datetime.max:
                    update(f"nodename={DRAINED}", "state=drain", "reason=test")
                    drained = datetime.now()
            elif not stopped and datetime.now() - when(job, "Start") > BEGUN:
                stopped = job["JobId"]
                update(f"jobid={stopped}", "timelimit=1")
                stop(stopped)
    return drained, stopped


def update(*words: str) -> None:
    """Change a node or a job of Slurm."""
    subprocess.run([*SCONTROL, "update", *words])


def stop(job_id: str) -> None:
    """Stop the processes of a job, as if they waited for a disk."""
    for process in psutil.process_iter():
        with suppress(psutil.Error):
            if process.environ().get("SLURM_JOB_ID") == job_id:
                process.suspend()


def overhead(plan: BuildPlan, jobs: list[Job]) -> Line:
    """Return the time of a job of Slurm without its tasks, and the time it waited."""
    waited, more = [], []
    for job in jobs:
        if job["JobState"] == "COMPLETED":
            (own,) = [one for one in plan.jobs.values() if one.name in job["Comment"]]
            tasks = sum(records.read(plan, t.name)["seconds"] for t in own.tasks)
            more.append((when(job, "End") - when(job, "Start")).total_seconds() - tasks)
            waited.append((when(job, "Start") - when(job, "Submit")).total_seconds())
    text = f"{median(more):.1f} s (smallest {min(more):.1f} s)"
    return "overhead per job", f"{text}, queue {median(waited):.0f} s; medians", True


def after_drain(jobs: list[Job], drained: datetime) -> Line:
    """Return whether the jobs of the drained node ended well, and no other came."""
    there = [job for job in jobs if job["NodeList"] == DRAINED]
    later = [job for job in there if when(job, "Start") > drained]
    running = [job for job in there if job not in later and when(job, "End") >= drained]
    text = f"drained while {len(running)} job ran there; {len(later)} began there later"
    good = [job for job in there if job["JobState"] == "COMPLETED"]
    return f"node {DRAINED}", text, good == there and len(running) == 1 and not later


def after_limit(jobs: list[Job], stopped: str) -> Line:
    """Return whether the job that exceeded its limit ran once more, with more."""
    name = next((job["Comment"] for job in jobs if job["JobId"] == stopped), "")
    tried = [job for job in jobs if job["Comment"] == name]
    shown = [(j["JobState"], j["TimeLimit"], j["MinMemoryNode"]) for j in tried]
    right = [state for state, _, _ in shown] == ["TIMEOUT", "COMPLETED"]
    return "stopped job", f"{name}: {', then '.join(map(' '.join, shown))}", right


def equal_files(*checkouts: Path) -> Line:
    """Return whether the results of two builds are equal, byte by byte."""
    one, other = map(products, checkouts)
    names = sorted(one | other)
    unequal = [name for name in names if one.get(name) != other.get(name)]
    text = f"{len(names) - len(unequal)} of {len(names)}"
    text += f", not {', '.join(unequal[:5])}" if unequal else ""
    return "equal files", text, bool(names) and not unequal


if __name__ == "__main__":
    sys.exit(main())
