"""Check that files of earlier builds are unchanged; otherwise make them again.

A job's record (`repro.workflow.job`) contains size, modification time and hash of each
file that it wrote. If size or time differ, the hash decides. A truncated or edited file
is removed, with all files of its job, and Snakemake runs the job again.
"""

from __future__ import annotations

import json
from pathlib import Path

from repro.run.rendered import FOLDER, TIMES
from repro.workflow.job import hash_of, stat_of
from repro.workflow.terminal import say
from repro.workflow.work import Work

MAX_LINES = 10
SITE = "site"
OF_JOBS = ("figures/", "report/", f"{FOLDER}/")


def drop_damaged(work: Work) -> None:
    """Remove changed files of jobs, with one line for each."""
    lost: list[str] = []
    claimed: set[str] = set()
    folders = (work.root / work.base / "times", work.root / TIMES)
    records = [path for folder in folders for path in folder.rglob("*.json")]
    # The newest record of a file counts.
    for record in sorted(records, key=lambda path: -path.stat().st_mtime_ns):
        files = {n: k for n, k in _files(record).items() if n not in claimed}
        claimed |= files.keys()
        damaged = [name for name in files if not _intact(work.root / name, files[name])]
        if damaged:
            if any((work.root / name).is_file() for name in files):
                lost += damaged
            # The site is repaired from its source: remove its marker and damaged files.
            of_site = record.parent.name == SITE
            for name in [work.site_done, *damaged] if of_site else files:
                (work.root / name).unlink(missing_ok=True)
            record.unlink()
    for name in lost[:MAX_LINES]:
        say(f"{name}: damaged; it will be made again")
    if len(lost) > MAX_LINES:
        say(f"{len(lost) - MAX_LINES} more files: the same")


def _files(record: Path) -> dict[str, list]:
    """File -> size, modification time and hash; nothing if the record is damaged."""
    try:
        content = json.loads(record.read_text("utf-8"))
        files = content.get("files", {})
    except (OSError, ValueError, AttributeError):
        return {}
    return {
        name: known
        for name, known in files.items()
        if name.startswith(OF_JOBS) and ".." not in Path(name).parts
    }


def _intact(path: Path, known: list) -> bool:
    if not path.is_file():
        return False
    return stat_of(path) == known[:2] or hash_of(path) == known[2]
