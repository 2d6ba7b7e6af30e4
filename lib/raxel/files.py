"""Results on disk are whole or absent: written beside their place, then moved."""

import contextlib
import json
import os
import tempfile
from pathlib import Path

from raxel.errors import InputError


@contextlib.contextmanager
def replacing(path):
    """Give a temporary path in the folder of `path`; move it there on success.

    The temporary name keeps the suffix of `path`, since writers look at it. If the
    block raises, nothing is left. Raises InputError where the folder cannot be
    written.
    """
    path = Path(path)
    check_can_be_written(path)
    descriptor, name = tempfile.mkstemp(
        prefix=f".{path.stem}-", suffix=path.suffix, dir=path.parent
    )
    os.close(descriptor)
    temporary = Path(name)
    try:
        yield temporary
        temporary.chmod(0o666 & ~_umask())
        os.replace(temporary, path)
    finally:
        temporary.unlink(missing_ok=True)


def check_can_be_written(path):
    """Raise InputError unless a file could be put at `path`."""
    path = Path(path)
    if not path.parent.is_dir():
        raise InputError(f"{path}: no folder {path.parent}; make it first")
    if path.is_dir():
        raise InputError(f"{path}: this is a folder; give the name of a file")
    if not os.access(path.parent, os.W_OK):
        raise InputError(f"{path}: the folder cannot be written; choose another")


def write_whole(path, content):
    """Write a text, as UTF-8, or bytes: `path` is the old file or the whole new one.

    Raises InputError as `replacing`.
    """
    with replacing(path) as temporary:
        temporary.write_bytes(content.encode() if isinstance(content, str) else content)


def write_json(path, data):
    """Write `data` as JSON, whole or not at all. Numbers must be finite or None."""
    text = json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False)
    write_whole(path, text + "\n")


def read_json(path):
    """The content of a JSON file. Raises InputError with file and line."""
    path = Path(path)
    try:
        return json.loads(path.read_text(encoding="utf-8"), parse_constant=_refuse)
    except FileNotFoundError as fault:
        raise InputError(f"{path}: no such file; check the name") from fault
    except OSError as fault:
        raise InputError(f"{path}: cannot be read ({fault.strerror})") from fault
    except json.JSONDecodeError as fault:
        raise InputError(
            f"{path}: line {fault.lineno}: not JSON ({fault.msg}); was it cut off?"
        ) from fault
    except (ValueError, RecursionError) as fault:
        raise InputError(f"{path}: not usable JSON ({fault}); write it anew") from fault


def _refuse(constant):
    raise ValueError(f"it holds {constant}, which is no finite number")


def _umask():
    mask = os.umask(0)
    os.umask(mask)
    return mask
