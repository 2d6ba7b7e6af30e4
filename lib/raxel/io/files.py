"""Files: checked before they are read; results are whole or absent."""

import contextlib
import json
import os
import reprlib
import stat
import tempfile
from collections import Counter
from pathlib import Path

from raxel.errors import InputError

# Characters of the name and of the suffix in a temporary name, at most 4 bytes each.
LONGEST_IN_NAMES = 24
# Corners of a thousand photographs are 30 MB. Read, a text takes ten times as much.
MAX_JSON_BYTES = 100_000_000


def file_size(path, what="file"):
    """Bytes of the regular file at `path`; `what` is its name in messages.

    Raises InputError for one that is missing, may not be read, or is a folder, a pipe
    or a device: to open a pipe may take for ever, and a device may have no end.
    """
    try:
        status = os.stat(path)
    except FileNotFoundError as fault:
        raise InputError(f"{path}: no such {what}; check the name") from fault
    except (OSError, ValueError) as fault:
        told = getattr(fault, "strerror", None) or fault
        raise InputError(f"{path}: cannot be read ({told})") from fault
    if not stat.S_ISREG(status.st_mode):
        found = "a folder" if stat.S_ISDIR(status.st_mode) else "a pipe or a device"
        raise InputError(f"{path}: not a {what}: found {found}; give a plain file")
    if not os.access(path, os.R_OK):
        raise InputError(f"{path}: cannot be read (Permission denied)")
    return status.st_size


def check_size(path, most, what="file"):
    """Raise InputError for a file of more than `most` bytes, and as `file_size`."""
    size = file_size(path, what)
    if size > most:
        raise InputError(
            f"{path}: found {size / 1e6:.4g} MB, more than is read; is it the right "
            f"{what}? Give {most / 1e6:g} MB at most"
        )


@contextlib.contextmanager
def replacing(path):
    """Give a temporary path in the folder of `path`; move it there on success.

    The temporary name keeps the suffix of `path`, since writers look at it. If the
    block raises, nothing is left. Raises InputError where the folder cannot be
    written; an OSError of the block names `path`.
    """
    with together() as place:
        yield place(path)


@contextlib.contextmanager
def together():
    """Several results take their places together, when the last is whole.

    Yields a callable `place`: it takes the path of a result and gives a temporary path
    for it, as `replacing`. When the block ends all are moved, in the order in which
    they were placed. If it raises, none is, and nothing is left:

        with together() as place:
            camera.save(place("camera.npz"))
            write_json(place("result.json"), result)

    Only a move can fail after another.
    """
    places = {}

    def place(path):
        temporary = _beside(Path(path))
        places[temporary] = Path(path)
        return temporary

    try:
        yield place
        for temporary, path in places.items():
            temporary.chmod(0o666 & ~_umask())
            os.replace(temporary, path)
    except OSError as fault:
        _name_the_result(fault, places)
        raise
    finally:
        for temporary in places:
            temporary.unlink(missing_ok=True)


def move_into(folder, out):
    """Move all files below `folder` to the same places below `out`, on the same disk.

    A new `out` appears whole. In one that is there already they take their places one
    by one, over files of the same name.
    """
    folder, out = Path(folder), Path(out)
    if not out.exists():
        os.replace(folder, out)
        return
    for path in sorted(path for path in folder.rglob("*") if path.is_file()):
        target = out / path.relative_to(folder)
        target.parent.mkdir(parents=True, exist_ok=True)
        os.replace(path, target)


def _beside(path):
    """A new empty file in the folder of `path`, for what will be there."""
    check_can_be_written(path)
    suffix = path.suffix if len(path.suffix) <= LONGEST_IN_NAMES else ""
    descriptor, name = tempfile.mkstemp(
        prefix=f".{path.stem[:LONGEST_IN_NAMES]}-", suffix=suffix, dir=path.parent
    )
    os.close(descriptor)
    return Path(name)


def _name_the_result(fault, places):
    """Let a fault of the system name the file asked for, not the temporary one."""
    if fault.errno is None:  # a text of its own, which a name would replace
        return
    if fault.filename is None and len(places) == 1:
        (fault.filename,) = map(str, places.values())
    for temporary, path in places.items():
        if fault.filename == str(temporary):
            fault.filename = str(path)


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
    # A file name that is no UTF-8 holds lone surrogates: JSON has escapes for them.
    write_whole(path, (text + "\n").encode(errors="backslashreplace"))


def read_json(path):
    """The content of a JSON file, in which no object has a key twice.

    Raises InputError with the file, and the line or the key.
    """
    path = Path(path)
    check_size(path, MAX_JSON_BYTES)
    try:
        return json.loads(
            path.read_text(encoding="utf-8-sig"),
            parse_constant=_refuse,
            object_pairs_hook=_object,
        )
    except InputError as fault:
        raise InputError(f"{path}: {fault}; keep one of the two") from fault
    except OSError as fault:
        raise InputError(f"{path}: cannot be read ({fault.strerror})") from fault
    except json.JSONDecodeError as fault:
        raise InputError(
            f"{path}: line {fault.lineno}: not JSON ({fault.msg}); was it cut off?"
        ) from fault
    except (ValueError, RecursionError, MemoryError) as fault:
        raise InputError(f"{path}: not usable JSON ({fault}); write it anew") from fault


def _object(pairs):
    """An object of JSON as a dict, of which Python would keep the last value alone."""
    found = dict(pairs)
    if len(found) < len(pairs):
        (key, _), *_ = Counter(key for key, _ in pairs).most_common(1)
        raise InputError(f"key {reprlib.repr(key)} given twice in one object")
    return found


def _refuse(constant):
    raise ValueError(f"it holds {constant}, which is no finite number")


def _umask():
    mask = os.umask(0)
    os.umask(mask)
    return mask
