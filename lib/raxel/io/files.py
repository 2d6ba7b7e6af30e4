"""Files: input is checked before it is read; output is complete or absent."""

from __future__ import annotations

import contextlib
import json
import os
import tempfile
import unicodedata
from collections import Counter
from collections.abc import Iterator, Sequence
from itertools import chain, count
from pathlib import Path, PurePath
from typing import Any

from raxel.errors import InputError

# Memory and processors of this machine.


def physical_memory() -> float:
    """Return the bytes of memory of this machine; 8 GB where they are unknown."""
    try:
        return os.sysconf("SC_PAGE_SIZE") * os.sysconf("SC_PHYS_PAGES")
    except (AttributeError, OSError, ValueError):
        return 8e9


def processors() -> int:
    """Return the number of processors this process may use; 1 where unknown."""
    return len(os.sched_getaffinity(0)) if hasattr(os, "sched_getaffinity") else 1


# Corners of a thousand images are 30 MB. In memory, a text takes ten times as much.
MAX_JSON_BYTES = 100_000_000


def check_file(
    path: str | os.PathLike[str], max_bytes: float = float("inf"), what: str = "file"
) -> None:
    """Raise InputError unless a regular file of at most `max_bytes` can be read.

    To open a pipe may take for ever, and a device may have no end.

    Parameters
    ----------
    path : path-like
        The file.
    max_bytes : float
        Limit of its size, bytes.
    what : str
        Its name in messages.

    Raises
    ------
    InputError
        If the file is missing, not readable or too large.
    """
    if not os.path.exists(path):
        raise InputError(f"{path}: no such {what}; correct the name")
    if not os.path.isfile(path) or not os.access(path, os.R_OK):
        raise InputError(f"{path}: not a readable {what}; give a regular file")
    size = os.path.getsize(path)
    if size > max_bytes:
        raise InputError(
            f"{path}: {what} has {size / 1e6:.4g} MB; give a {what} of at most "
            f"{max_bytes / 1e6:g} MB"
        )


def read_text(path: str | os.PathLike[str], max_bytes: float) -> str:
    """Return the text of a UTF-8 file.

    Parameters
    ----------
    path : path-like
        The file.
    max_bytes : float
        Limit of its size, bytes.

    Returns
    -------
    str
        The text.

    Raises
    ------
    InputError
        If the file cannot be read. The message names the file.
    """
    check_file(path, max_bytes)
    try:
        return Path(path).read_text(encoding="utf-8-sig")
    except (OSError, UnicodeDecodeError) as fault:
        raise InputError(
            f"{path}: cannot be read ({fault}); save it as UTF-8"
        ) from fault


@contextlib.contextmanager
def replacing(path: str | os.PathLike[str]) -> Iterator[Path]:
    """Yield a temporary path of the name of `path`; move it there on success.

    The same as `together`, for one result.
    """
    with together() as place:
        yield place(path)


@contextlib.contextmanager
def together():
    """Move several results to their paths together, when the last is complete.

    Yields a callable `place`, which maps the path of a result to a temporary path of
    the same name. When the block ends all are moved, in this order. If it raises, none
    is moved, and temporary files are removed:

        with together() as place:
            camera.save(place("camera.npz"))
            write_json(place("result.json"), result)

    Only a move can fail after another one. Raises InputError if a folder cannot be
    written; an OSError of the block names the results.
    """
    temporary_paths = {}
    with contextlib.ExitStack() as folders:

        def place(path):
            check_can_be_written(path)
            folder = tempfile.TemporaryDirectory(dir=Path(path).parent, prefix=".")
            temporary_paths[path] = (
                Path(folders.enter_context(folder)) / Path(path).name
            )
            return temporary_paths[path]

        try:
            yield place
            for path, temporary in temporary_paths.items():
                os.replace(temporary, path)
        except OSError as fault:
            reason = fault.strerror or str(fault)
            raise OSError(
                fault.errno, reason, ", ".join(map(str, temporary_paths))
            ) from fault


def check_can_be_written(path: str | os.PathLike[str]) -> None:
    """Raise InputError unless a file can be written at `path`."""
    path = Path(path)
    if not path.parent.is_dir():
        raise InputError(f"{path}: no folder {path.parent}; create it first")
    if path.is_dir():
        raise InputError(f"{path}: is a folder; give the name of a file")
    if not os.access(path.parent, os.W_OK):
        raise InputError(f"{path}: folder is not writable; choose another one")


def write_whole(path: str | os.PathLike[str], content: str | bytes) -> None:
    """Write a text, as UTF-8, or bytes; `path` is the old or the complete new file.

    Parameters
    ----------
    path : path-like
        The file.
    content : str or bytes
        Its content.

    Raises
    ------
    InputError
        As `together`.
    """
    with replacing(path) as temporary:
        temporary.write_bytes(content.encode() if isinstance(content, str) else content)


def write_json(path: str | os.PathLike[str], data: Any) -> None:
    """Write `data` as JSON, whole or not at all.

    Parameters
    ----------
    path : path-like
        The file.
    data : object
        Content for JSON. Numbers must be finite or None.

    Raises
    ------
    InputError
        As `together`.
    """
    text = json.dumps(data, indent=1, ensure_ascii=False, allow_nan=False)
    # A file name that is not UTF-8 has lone surrogates, which JSON escapes.
    write_whole(path, (text + "\n").encode(errors="backslashreplace"))


def read_json(path: str | os.PathLike[str]) -> Any:
    """Return the content of a JSON file, in which no object has a key twice.

    Parameters
    ----------
    path : path-like
        A UTF-8 file of at most MAX_JSON_BYTES.

    Returns
    -------
    object
        The content.

    Raises
    ------
    InputError
        If the file is not usable. The message has the file, and the line or the key.

    Examples
    --------
    >>> import tempfile
    >>> from pathlib import Path
    >>> from raxel.io import read_json
    >>> with tempfile.TemporaryDirectory() as folder:
    ...     path = Path(folder) / "result.json"
    ...     _ = path.write_text('{"rms_px": 0.25}')
    ...     read_json(path)
    {'rms_px': 0.25}
    """
    text = read_text(path, MAX_JSON_BYTES)
    try:
        return json.loads(text, parse_constant=_reject, object_pairs_hook=_object)
    except (ValueError, RecursionError, MemoryError) as fault:
        raise InputError(f"{path}: invalid JSON ({fault}); write it again") from fault


def _object(pairs):
    """Return a JSON object as a dict; raise for repeated keys."""
    found = dict(pairs)
    if len(found) < len(pairs):
        ((key, _),) = Counter(key for key, _ in pairs).most_common(1)
        raise ValueError(f"key {key!r:.60} is repeated in one object")
    return found


def _reject(constant):
    raise ValueError(f"{constant} is not a finite number")


def png_names(files: Sequence[str]) -> list[PurePath]:
    """Return a PNG file for each image, distinct also if case is ignored.

    This is the name of the image with the ending .png. Images that would share a name
    keep their whole old name before the ending, with a number if that is taken too.
    """
    plain = [PurePath(name).with_suffix(".png") for name in files]
    shared = Counter(map(_folded, plain))
    taken = {_folded(folder) for path in plain for folder in path.parents}
    targets: list[PurePath] = []
    for name, first in zip(files, plain, strict=True):
        numbered = map(PurePath, (f"{name}-{number}.png" for number in count(2)))
        choices = chain([PurePath(f"{name}.png")], numbered)
        if shared[_folded(first)] == 1:
            choices = chain([first], choices)
        targets.append(next(path for path in choices if _folded(path) not in taken))
        taken.add(_folded(targets[-1]))
    return targets


def _folded(path: PurePath) -> str:
    """Return the same text for paths that some file systems take for one."""
    return unicodedata.normalize("NFC", str(path).casefold())
