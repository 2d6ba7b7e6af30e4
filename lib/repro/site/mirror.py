"""Make a folder contain exactly the wanted files; write only those that differ."""

from __future__ import annotations

import filecmp
import hashlib
from collections.abc import Callable, Mapping
from functools import cache
from pathlib import Path
from typing import NamedTuple

from repro.judge.kept import Kept
from repro.run.results import write_atomic


class Made(NamedTuple):
    """A text identified by its SHA-256, made only if it is not there yet."""

    sha256: str
    text: Callable[[], str]


Content = Path | str | Made


def mirror(wanted: Mapping[str, Content], folder: Path) -> list[str]:
    """Write, replace and remove files below ``folder``; return the changed names.

    ``wanted`` maps a path relative to ``folder`` to a file to copy or to a text. A file
    with the right content keeps its date, for tools that compare dates. Files are
    replaced completely.
    """
    touched = []
    for name, content in wanted.items():
        if not _equal(folder / name, content):
            write_atomic(folder / name, _whole(content))
            touched.append(name)
    for path in sorted(folder.rglob("*"), reverse=True):
        name = path.relative_to(folder).as_posix()
        if path.is_dir() and not path.is_symlink():
            if not any(path.iterdir()):
                path.rmdir()
        elif name not in wanted:
            path.unlink()
            touched.append(name)
    return touched


def made(kept: Kept, path: Path, text: Callable[[], str]) -> Made:
    """Return the output of ``text`` for a file, which is repeated when the file
    changes."""
    text = cache(text)
    return Made(kept.of(path, lambda own: (_hash(text().encode()), [own])), text)


def _hash(content: bytes) -> str:
    return hashlib.sha256(content).hexdigest()


def _whole(content: Content) -> bytes | str:
    if isinstance(content, Path):
        return content.read_bytes()
    return content.text() if isinstance(content, Made) else content


def _equal(path: Path, content: Content) -> bool:
    if not path.is_file():
        return False
    if isinstance(content, Made):
        return _hash(path.read_bytes()) == content.sha256
    if isinstance(content, Path):
        return filecmp.cmp(path, content, shallow=False)
    return path.read_bytes() == content.encode()


def files_below(folder: Path) -> dict[str, Path]:
    """Return every file below ``folder`` by its relative path, without caches."""
    return {
        path.relative_to(folder).as_posix(): path
        for path in sorted(folder.rglob("*"))
        if path.is_file() and "__pycache__" not in path.parts
    }
