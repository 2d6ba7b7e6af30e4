"""What became of one mutant: read, refused in one line, or a fault of the reader."""

import os
import resource
import sys
import traceback
import warnings
from contextlib import contextmanager
from pathlib import Path

from raxel.errors import InputError

READ, REFUSED = "read", "refused"
MOST_BYTES = 2 << 30
LONGEST_LINE = 1500


def outcome(reader, folder, number):
    """(READ, REFUSED or the name of a fault, what is to be said about it)."""
    before = _most_memory()
    with _standard_error(folder) as words:
        try:
            reader.read(Path(folder), number)
            found = READ, ""
        except InputError as fault:
            found = _of_line(str(fault), str(folder))
        except Exception:
            found = "traceback", traceback.format_exc()
    if found[0] in (READ, REFUSED) and words():
        found = "words on stderr", words()
    # What the process took earlier, for something else, is no fault of this file.
    if _most_memory() > max(before, MOST_BYTES):
        found = "memory", f"more than {MOST_BYTES >> 30} GB"
    return found


def _most_memory():
    """Bytes that this process held at most so far."""
    return resource.getrusage(resource.RUSAGE_SELF).ru_maxrss * 1024


def _of_line(line, folder):
    if folder not in line:
        return "no file named", line
    if not line.isprintable() or len(line) > LONGEST_LINE:
        return "not one line", repr(line)
    return REFUSED, line


@contextmanager
def _standard_error(folder):
    """Catch what is written there, by Python or below it; yields () -> text."""
    place = Path(folder) / "stderr"
    kept = os.dup(2)
    sys.stderr.flush()
    target = os.open(place, os.O_CREAT | os.O_TRUNC | os.O_WRONLY)
    os.dup2(target, 2)
    try:
        with warnings.catch_warnings():
            warnings.simplefilter("always")
            yield lambda: place.read_text(errors="replace")
    finally:
        sys.stderr.flush()
        os.dup2(kept, 2)
        os.close(target)
        os.close(kept)
