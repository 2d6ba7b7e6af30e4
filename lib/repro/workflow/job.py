"""One job: a command of the book-keeping, run and timed.

    python -m repro.workflow.job LABEL MODULE ...

does what `python -m MODULE ...` does, and leaves `LABEL.json` in the folder that the
environment names in `RAXEL_TIMES`: what the page of times adds up.
"""

from __future__ import annotations

import importlib
import os
import resource
import sys
import time
from collections.abc import Sequence
from pathlib import Path

from repro.run.results import write_json

TIMES = "RAXEL_TIMES"


def run(words: Sequence[str]) -> int:
    """Run the job; return its exit status."""
    label, name, *more = words
    start = time.monotonic()
    status = _command(name)(more)
    folder = os.environ.get(TIMES)
    if folder and not status:
        took = {
            "seconds": round(time.monotonic() - start, 2),
            "processor_seconds": round(_processor_seconds(), 2),
        }
        write_json(Path(folder) / f"{label}.json", took)
    return status


def _command(name: str):
    """The function that `python -m NAME` runs."""
    module = importlib.import_module(name)
    if hasattr(module, "__path__"):
        module = importlib.import_module(f"{name}.__main__")
    return module.main


def _processor_seconds() -> float:
    """Of this process, and of those that it has started and waited for."""
    used = [
        resource.getrusage(w) for w in (resource.RUSAGE_SELF, resource.RUSAGE_CHILDREN)
    ]
    return sum(one.ru_utime + one.ru_stime for one in used)


if __name__ == "__main__":
    sys.exit(run(sys.argv[1:]))
