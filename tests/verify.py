"""`make verify`: does the repository reproduce itself?

It builds a chapter or the whole quick report in three copies of the checkout:

- on one core, interrupted by Ctrl-C once, and continued;
- on two cores, in a folder with spaces, in another locale and time zone;
- the smallest chapter, killed by SIGKILL at 20 random moments, and continued.

All result files, figures, tables and verdicts of the copies must be equal to the byte.
Run records (`*.run.json`: time, host, versions) and logs differ by nature.
"""

from __future__ import annotations

import argparse
import hashlib
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
from collections import Counter
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from repro.workflow.terminal import say

ROOT = Path(__file__).resolve().parents[1]
KILLS = 20
SMALLEST = "appendix_a"
LONGEST_WAIT_S = 12.0
BETWEEN_RUNS = ("jobs", "logs", "records", "shards")
ELSEWHERE = {"LC_ALL": "C", "TZ": "Asia/Kathmandu"}
KINDS = {
    ".json": "results, descriptions and verdicts", ".npz": "arrays",
    ".csv": "tables and data of figures", ".svg": "figures (svg)",
    ".png": "figures (png)", ".md": "scoreboard", ".html": "3-D scenes",
}  # fmt: skip


def copy_of_checkout(place: Path) -> Path:
    """Copy the files that git knows, compiled loops, and the downloaded images."""
    shutil.copytree(ROOT / "lib", place / "lib")
    names = subprocess.run(
        ["git", "ls-files", "-z", "--cached", "--others", "--exclude-standard"],
        cwd=ROOT, capture_output=True, text=True, check=True,
    ).stdout.split("\0")  # fmt: skip
    images = (ROOT / "data" / "recorded").rglob("*.jpg")
    names += [path.relative_to(ROOT).as_posix() for path in images]
    for name in filter(None, names):
        if (ROOT / name).is_file() and not name.startswith("lib/"):
            (place / name).parent.mkdir(parents=True, exist_ok=True)
            shutil.copy2(ROOT / name, place / name)
    return place


def started(root: Path, target: str, cores: int, **more: str) -> subprocess.Popen:
    """Start a quick build in a copy, in a session of its own."""
    environment = os.environ | {
        "PYTHONPATH": f"{root / 'lib'}{os.pathsep}{root}",
        "PATH": f"{Path(sys.executable).parent}{os.pathsep}{os.environ['PATH']}",
        "XDG_CACHE_HOME": str(root / ".cache"),
    }
    words = [sys.executable, "-m", "repro.workflow", target]
    words += ["--effort", "quick", "--cores", str(cores)]
    with (root / "build.log").open("a") as log:
        return subprocess.Popen(
            words, cwd=root, env=environment | more, stdout=log, stderr=log,
            start_new_session=True,
        )  # fmt: skip


def finished(root: Path, target: str, cores: int, **more: str) -> None:
    """Build in a copy to the end; exit with the last lines of its log if it fails."""
    if started(root, target, cores, **more).wait():
        lines = (root / "build.log").read_text("utf-8", "replace").splitlines()
        sys.exit("\n".join(["make verify: a build failed:", *lines[-8:]]))


def interrupted(root: Path, target: str) -> None:
    """Press Ctrl-C after the first job, then build to the end, on one core."""
    build = started(root, target, 1)
    jobs = root / "figures" / "quick" / "jobs"
    while build.poll() is None and not [*jobs.rglob("*.json")]:
        time.sleep(0.2)
    os.killpg(build.pid, signal.SIGINT)
    if build.wait() == 0:
        sys.exit("make verify: the build ended before it could be interrupted")
    finished(root, target, 1)


def killed(root: Path) -> int:
    """Kill builds and their jobs at random moments, then build to the end."""
    moments, count = random.Random(2009), 0
    for _ in range(KILLS):
        build = started(root, SMALLEST, 2)
        try:
            build.wait(moments.uniform(0.5, LONGEST_WAIT_S))
        except subprocess.TimeoutExpired:
            os.killpg(build.pid, signal.SIGKILL)
            build.wait()
            count += 1
        else:  # it was finished: begin again
            shutil.rmtree(root / "figures")
    finished(root, SMALLEST, 2)
    return count


def products(root: Path) -> dict[str, str]:
    """File -> hash of what a build makes, without what differs between runs."""
    base = root / "figures" / "quick"
    return {
        path.relative_to(base).as_posix(): hashlib.sha256(path.read_bytes()).hexdigest()
        for path in sorted(base.rglob("*"))
        if path.is_file()
        and path.relative_to(base).parts[0] not in BETWEEN_RUNS
        and not path.name.endswith(".run.json")
    }


def main() -> int:
    """Print one table; return 1 if a file differs."""
    parser = argparse.ArgumentParser(prog="make verify", description=__doc__)
    parser.add_argument("target", help="quick, or a chapter: ch02")
    target = parser.parse_args().target
    begin = time.monotonic()
    with tempfile.TemporaryDirectory(prefix="raxel-verify-") as folder:
        places = [Path(folder, name) for name in ("one", "another path", "killed")]
        one, two, three = map(copy_of_checkout, places)
        with ThreadPoolExecutor(1) as other:  # one core leaves the other idle
            say(f"{target} on one core, interrupted")
            slow = other.submit(interrupted, one, target)
            say(f"{target} on two cores, elsewhere")
            finished(two, target, 2, **ELSEWHERE)
            second = products(two)
            finished(two, SMALLEST, 2)
            say(f"{SMALLEST}, killed {KILLS} times")
            kills, after, undisturbed = killed(three), products(three), products(two)
            slow.result()
        first = products(one)
    different = [name for name in first | second if first.get(name) != second.get(name)]
    different += [name for name in after if after[name] != undisturbed.get(name)]
    counts = Counter(Path(name).suffix for name in first)
    wrong = Counter(Path(name).suffix for name in different)
    print(f"{'files of ' + target:40}{'compared':>10}{'different':>10}")
    for ending, kind in KINDS.items():
        print(f"{kind:40}{counts[ending]:>10}{wrong[ending]:>10}")
    print(
        f"one core, interrupted; two cores, locale C; "
        f"{kills} of {KILLS} builds of {SMALLEST} killed; "
        f"{(time.monotonic() - begin) / 60:.1f} min"
    )
    for name in different[:20]:
        print(f"different: {name}")
    return 1 if different else 0


if __name__ == "__main__":
    sys.exit(main())
