"""Make a folder contain exactly the wanted files; write only those that differ."""

from __future__ import annotations

import filecmp
from collections.abc import Mapping
from pathlib import Path

from repro.run.results import write_atomic

Content = Path | str


def mirror(wanted: Mapping[str, Content], folder: Path) -> list[str]:
    """Write, replace and remove files below ``folder``; return the changed names.

    ``wanted`` maps a path relative to ``folder`` to a file to copy or to a text. A file
    with the right content keeps its date, for tools that compare dates. Files are
    replaced completely.
    """
    touched = []
    for name, content in wanted.items():
        if not _equal(folder / name, content):
            text = content.read_bytes() if isinstance(content, Path) else content
            write_atomic(folder / name, text)
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


def _equal(path: Path, content: Content) -> bool:
    if not path.is_file():
        return False
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
