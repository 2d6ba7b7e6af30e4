"""What the jobs of earlier builds left is as they left it, or is made again.

A job's record (`repro.workflow.job`) holds size, time of change and hash of each file
that it wrote. Where size or time differ, the hash decides. A file that was cut or
edited goes, with all that its job left, and Snakemake runs the job again.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from pathlib import Path

from repro.run.rendered import TIMES
from repro.run.results import write_json
from repro.workflow.job import hash_of, stat_of
from repro.workflow.terminal import say
from repro.workflow.work import Work

MOST_SAID = 10
SITE = "site"


def drop_damaged(work: Work) -> None:
    """Remove what is not as its job left it, and say so."""
    said: list[str] = []
    claimed: set[str] = set()
    folders = (work.root / work.base / "times", work.root / TIMES)
    records = [record for folder in folders for record in folder.rglob("*.json")]
    for record in sorted(records, key=lambda path: -path.stat().st_mtime_ns):
        files = _files(record)
        files = {name: known for name, known in files.items() if name not in claimed}
        claimed |= files.keys()
        damaged = [name for name in files if not _intact(work.root / name, files[name])]
        if damaged and any((work.root / name).is_file() for name in files):
            said += damaged
        if damaged:
            _drop(work, record, files, damaged)
        elif any(stat_of(work.root / n) != known[:2] for n, known in files.items()):
            _remember(work.root, record, files)
    for name in said[:MOST_SAID]:
        say(f"{name} was damaged: it will be made again")
    if len(said) > MOST_SAID:
        more = len(said) - MOST_SAID
        say(f"{more} more files were damaged: the same")


def _files(record: Path) -> dict[str, list]:
    """Files of a job; none where its record is damaged itself, which then goes."""
    try:
        return json.loads(record.read_text("utf-8")).get("files", {})
    except (ValueError, AttributeError):
        record.unlink()
        return {}


def _intact(path: Path, known: list) -> bool:
    if not path.is_file():
        return False
    return stat_of(path) == known[:2] or hash_of(path) == known[2]


def _drop(work: Work, record: Path, files: Iterable[str], damaged: list[str]) -> None:
    """Remove what the job left: of the site, which mends itself, its mark alone."""
    of_site = record.parent.name == SITE
    for name in [work.site_done, *damaged] if of_site else files:
        (work.root / name).unlink(missing_ok=True)
    record.unlink()


def _remember(root: Path, record: Path, files: dict[str, list]) -> None:
    """Keep the new times of files whose content is as it was."""
    content = json.loads(record.read_text("utf-8"))
    for name, known in files.items():
        content["files"][name] = [*stat_of(root / name), known[2]]
    changed = record.stat().st_mtime_ns
    write_json(record, content)
    os.utime(record, ns=(changed, changed))  # later records speak for their files
