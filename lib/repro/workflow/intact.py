"""What the jobs of earlier builds left is as they left it, or is made again.

A job's record (`repro.workflow.job`) holds size, time of change and hash of each file
that it wrote. Where size or time differ, the hash decides. A file that was cut or
edited goes, with all that its job left, and Snakemake runs the job again. So does a
result that no sound record knows: nothing says that it is whole.
"""

from __future__ import annotations

import json
import os
from collections.abc import Iterable
from itertools import chain
from pathlib import Path

from repro.run.rendered import FOLDER, TIMES
from repro.run.results import write_json
from repro.workflow.job import hash_of, stat_of
from repro.workflow.terminal import say
from repro.workflow.work import Work

MOST_SAID = 10
SITE = "site"
# What jobs alone write into: below the folder of a build.
OF_JOBS = ("results", "shards", "judged")
# And from the checkout; what is kept in git is no job's.
OF_REPORT = ("build", "site", "site-quick", "notebooks", "answers")
ALSO_OF_JOBS = (*(f"report/{name}" for name in OF_REPORT), FOLDER)
KEPT = "README.md"


def drop_damaged(work: Work) -> None:
    """Remove what is not as its job left it, and say so."""
    said: list[str] = []
    claimed: set[str] = set()
    folders = (work.root / work.base / "times", work.root / TIMES)
    found = [record for folder in folders for record in folder.rglob("*.json")]
    records = [record for record in found if record.is_file()]
    written = [(work.root / name).resolve() for name in (work.base, *ALSO_OF_JOBS)]
    for record in sorted(records, key=lambda path: -path.stat().st_mtime_ns):
        files = _files(record, work.root, written)
        if files is None:
            record.unlink()
            continue
        files = {name: known for name, known in files.items() if name not in claimed}
        claimed |= files.keys()
        damaged = [name for name in files if not _intact(work.root / name, files[name])]
        if damaged and any((work.root / name).is_file() for name in files):
            said += [f"{name} was damaged" for name in damaged]
        if damaged:
            _drop(work, record, files, damaged)
        elif any(stat_of(work.root / n) != known[:2] for n, known in files.items()):
            _remember(work.root, record, files)
    said += _drop_unknown(work, claimed)
    for words in said[:MOST_SAID]:
        say(f"{words}: it will be made again")
    if len(said) > MOST_SAID:
        more = len(said) - MOST_SAID
        say(f"{more} more files: the same")


def _files(record: Path, root: Path, written: list[Path]) -> dict[str, list] | None:
    """Files of a job; None where its record is not as a job writes it."""
    try:
        content = json.loads(record.read_text("utf-8"))
    except (OSError, ValueError, RecursionError):
        return None
    files = content.get("files", {}) if isinstance(content, dict) else None
    if not isinstance(files, dict):
        return None
    sound = (
        _is_place(root / name, written) and _is_stated(known)
        for name, known in files.items()
    )
    return files if all(sound) else None


def _is_place(path: Path, written: list[Path]) -> bool:
    """Whether a file may be there, and be a job's: what a record names is removed."""
    try:
        place = path.resolve()
        free = not path.is_dir()
    except (OSError, ValueError, RuntimeError):
        return False
    below = any(folder in place.parents for folder in written)
    return free and below and place.name != KEPT


def _is_stated(known: object) -> bool:
    """Whether that is a size, a time of change and a hash."""
    return isinstance(known, list) and [type(part) for part in known] == [int, int, str]


def _drop_unknown(work: Work, claimed: set[str]) -> list[str]:
    """Remove results, figures and tables that no sound record knows, and say which."""
    base = work.root / work.base
    ids = {name for _, name in work.producers}
    found = [path for path in base.glob("*") if path.name.partition(".")[0] in ids]
    found += chain.from_iterable((base / name).rglob("*") for name in OF_JOBS)
    unknown = [
        (path, name)
        for path in found
        if path.is_file() and (name := str(path.relative_to(work.root))) not in claimed
    ]
    for path, _ in unknown:
        path.unlink()
    return sorted(f"{name} has no sound record of its job" for _, name in unknown)


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
