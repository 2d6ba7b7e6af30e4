"""An order that was carried out is so still, while all files are as they were then.

To plan a build takes seconds, to compare times of change a fraction of one. What is
compared are all files of the checkout but what builds leave there, and for that the
records of the jobs, by which `repro.workflow.intact` has just found it whole.
"""

from __future__ import annotations

import hashlib
import json
import os
from collections.abc import Iterable, Iterator, Sequence
from pathlib import Path

from raxel.io.files import write_json
from raxel.io.rendering import available
from repro.run.rendered import FOLDER, TIMES
from repro.workflow.work import Work

RECORD = Path(".cache/built.json")
MADE = (FOLDER, "figures") + tuple(
    f"report/{name}" for name in ("answers", "build", "notebooks", "site", "site-quick")
)


def sources_of(root: Path) -> str:
    """Hash over the files of a checkout, but what is hidden or made by builds."""
    return _hash([root], {root / name for name in MADE})


def is_done(work: Work, order: Sequence, sources: str, targets: Iterable[str]) -> bool:
    """Whether an order was carried out with these sources, and nothing is gone since.

    ``order`` are the words that say what is built, ``targets`` the files asked for.
    """
    if not all((work.root / target).is_file() for target in targets):
        return False
    return _noted(work.root).get(_name(order)) == _state(work, sources)


def note(work: Work, order: Sequence, sources: str) -> None:
    """Keep that an order was carried out; ``sources`` are those before it began."""
    noted = _noted(work.root) | {_name(order): _state(work, sources)}
    write_json(work.root / RECORD, noted)


def _name(order: Sequence) -> str:
    return json.dumps(order)


def _state(work: Work, sources: str) -> list[str | bool]:
    """The sources, image sets that may lie elsewhere, records of jobs, and OpenGL."""
    sets = [work.root / folder for folder in work.sets.values()]
    records = [work.root / work.base / "times", work.root / TIMES]
    return [sources, _hash(sets), _hash(records), available().works]


def _noted(root: Path) -> dict[str, list]:
    try:
        return dict(json.loads((root / RECORD).read_text("utf-8")))
    except (OSError, ValueError, TypeError):  # none yet, or damaged
        return {}


def _hash(folders: Iterable[Path], left_out: Iterable[Path] = ()) -> str:
    """Hash over names, sizes and times of change of the files below folders."""
    left_out = {str(path) for path in left_out}
    digest = hashlib.sha256()
    for folder in folders:
        for line in sorted(_stats(str(folder), left_out, set())):
            digest.update(f"{line}\n".encode(errors="surrogateescape"))
    return digest.hexdigest()


def _stats(
    folder: str, left_out: set[str], above: set[tuple[int, int]]
) -> Iterator[str]:
    """A line for each file below a folder; links are followed, but not in circles."""
    if not os.path.isdir(folder):
        return
    found = os.stat(folder)
    place = found.st_dev, found.st_ino
    if place in above:
        return
    with os.scandir(folder) as entries:
        for entry in entries:
            hidden = entry.name.startswith(".") or entry.name == "__pycache__"
            if entry.is_file():
                known = entry.stat()
                yield f"{entry.path!r} {known.st_size} {known.st_mtime_ns}"
            elif not hidden and entry.path not in left_out:
                yield from _stats(entry.path, left_out, above | {place})
