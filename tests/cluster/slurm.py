"""A Slurm of four nodes on one machine: as root, without systemd and cgroups."""

import os
import shutil
import socket
import subprocess
import time
from collections.abc import Callable, Iterator
from contextlib import contextmanager
from datetime import datetime
from pathlib import Path
from typing import NamedTuple

CONFIG = Path("/etc/slurm/slurm.conf")
"""A nested `srun` reads no other file: the plugin's jobs drop SLURM_CONF."""
PACKAGES = "slurm-wlm", "munge"
PORTS = range(16820, 16825)
NODES = "n1", "n2", "n3", "n4"
TEXT = """\
ClusterName=acceptance
SlurmctldHost=localhost
SlurmUser=root
SlurmdUser=root
AuthType=auth/munge
AuthInfo=socket={folder}/munge.socket
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
JobAcctGatherType=jobacct_gather/linux
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core_Memory
SchedulerParameters=sched_interval=1,batch_sched_delay=0,bf_interval=1
ReturnToService=2
AccountingStorageType=accounting_storage/none
JobCompType=jobcomp/none
SlurmctldPort=16820
SlurmctldPidFile={folder}/slurmctld.pid
SlurmdPidFile={folder}/slurmd.%n.pid
StateSaveLocation={folder}/state
SlurmdSpoolDir={folder}/spool/%n
SlurmctldLogFile={folder}/slurmctld.log
SlurmdLogFile={folder}/slurmd.%n.log
SlurmdParameters=config_overrides
MinJobAge=86400
KillWait=5
NodeName=n[1-4] NodeHostname={host} NodeAddr=127.0.0.1 Port=[16821-16824] CPUs=1 RealMemory=6000 State=UNKNOWN
PartitionName=main Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""  # noqa: E501


class Job(NamedTuple):
    """A job of Slurm; times that are not known yet are in the far future."""

    id: str
    name: str
    state: str
    node: str
    submitted: datetime
    begin: datetime
    end: datetime
    limit: str
    memory: str


def missing() -> str:
    """Install Slurm if necessary; return why it cannot run here, or nothing."""
    if os.geteuid() != 0:
        return "not root"
    if not all(map(shutil.which, ("slurmctld", "slurmd", "munged"))):
        install = ["apt-get", "install", "-y", "--no-install-recommends", *PACKAGES]
        if not shutil.which("apt-get") or asked(*install) == "":
            return f"no {' and '.join(PACKAGES)}"
    if CONFIG.exists():
        return f"{CONFIG} belongs to another Slurm"
    for port in PORTS:
        with socket.socket() as one:
            if one.connect_ex(("127.0.0.1", port)) == 0:
                return f"port {port} is taken"
    return ""


@contextmanager
def slurm(folder: Path) -> Iterator[None]:
    """Run the controller and the nodes with their files in an empty folder."""
    for name in ("state", *(f"spool/{node}" for node in NODES)):
        (folder / name).mkdir(parents=True)
    CONFIG.parent.mkdir(exist_ok=True)
    CONFIG.write_text(TEXT.format(folder=folder, host=socket.gethostname()))
    key = folder / "munge.key"
    key.touch(0o600)
    key.write_bytes(os.urandom(64))
    munged = ["munged", "--foreground", "--force", f"--key-file={key}"]
    for kind in ("log", "seed"):
        munged.append(f"--{kind}-file={folder}/munge.{kind}")
    munged += [f"--pid-file={folder}/munge.pid", f"--socket={folder}/munge.socket"]
    started = []
    try:
        for order in (
            munged,
            ["slurmctld", "-D"],
            *(["slurmd", "-D", "-N", n] for n in NODES),
        ):
            started.append(
                subprocess.Popen(
                    order, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL
                )
            )
        wait_until(lambda: asked("sinfo", "--noheader", "--format=%T %D") == "idle 4")
        yield
    finally:
        subprocess.run(["scancel", "--user=root"], check=False)
        wait_until(lambda: not asked("squeue", "--noheader"))
        for process in reversed(started):
            process.terminate()
            process.wait()
        CONFIG.unlink()


def asked(*command: str) -> str:
    """Return the answer of a command of Slurm; nothing if it fails."""
    done = subprocess.run(command, capture_output=True, text=True, check=False)
    return done.stdout.strip()


def jobs() -> list[Job]:
    """Return all jobs, in the order of their submission."""
    found = []
    for line in asked("scontrol", "--oneliner", "show", "job").splitlines():
        row = dict(word.split("=", 1) for word in line.split() if "=" in word)
        if "JobId" not in row:  # a line that states that there is none
            continue
        submitted, begin, end = (
            _time(row[f"{n}Time"]) for n in ("Submit", "Start", "End")
        )
        found.append(
            Job(
                row["JobId"], row.get("Comment", row["JobName"]), row["JobState"],
                row["NodeList"], submitted, begin, end, row["TimeLimit"],
                row["MinMemoryNode"],
            )
        )  # fmt: skip
    return sorted(found, key=lambda job: int(job.id))


def _time(text: str) -> datetime:
    return datetime.max if text == "Unknown" else datetime.fromisoformat(text)


def wait_until(holds: Callable[[], bool], seconds: float = 60) -> None:
    """Wait for a state of Slurm."""
    end = time.monotonic() + seconds
    while not holds():
        if time.monotonic() > end:
            raise TimeoutError("Slurm does not answer as expected")
        time.sleep(0.2)
