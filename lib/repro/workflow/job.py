"""One job: a command of `repro`, run and timed.

    python -m repro.workflow.job LABEL MODULE ...

runs `python -m MODULE ...`, and writes `LABEL.json` to the folder `RAXEL_TIMES` of the
environment: its time and peak memory for `make times`, and the files that it wrote for
`repro.workflow.intact`.
"""

from __future__ import annotations

import hashlib
import importlib
import os
import resource
import sys
import time
from collections.abc import Iterable, Sequence
from pathlib import Path

from repro.run.results import WRITTEN, write_json

TIMES = "RAXEL_TIMES"
USED = (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)


def run(words: Sequence[str]) -> int:
    """Run the job; return its exit status."""
    label, name, *more = words
    folder = os.environ.get(TIMES)
    record = Path(folder) / f"{label}.json" if folder else None
    if record:
        record.unlink(missing_ok=True)
    start, before = time.monotonic(), len(WRITTEN)
    status = _command(name)(more)
    if record and not status:
        # Of this process, and of the processes that it has waited for.
        used = [resource.getrusage(w) for w in USED]
        took = {
            "seconds": round(time.monotonic() - start, 2),
            "processor_seconds": round(sum(u.ru_utime + u.ru_stime for u in used), 2),
            "peak_mb": round(max(u.ru_maxrss for u in used) / 1024, 1),
        }
        files = left(WRITTEN[before:])
        write_json(record, took | ({"files": files} if files else {}))
    return status


def left(paths: Iterable[Path]) -> dict[str, list]:
    """File -> size, modification time (ns) and SHA-256, of existing files."""
    return {str(p): [*stat_of(p), hash_of(p)] for p in paths if p.is_file()}


def stat_of(path: Path) -> list[int]:
    """Return size and modification time in ns."""
    found = path.stat()
    return [found.st_size, found.st_mtime_ns]


def hash_of(path: Path) -> str:
    """SHA-256 of a file's content."""
    return hashlib.sha256(path.read_bytes()).hexdigest()


def _command(name: str):
    """The function that `python -m NAME` runs."""
    module = importlib.import_module(name)
    if hasattr(module, "__path__"):
        module = importlib.import_module(f"{name}.__main__")
    return module.main


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
