"""A cache of what was read from files of the checkout, for later builds."""

from __future__ import annotations

import hashlib
import json
from collections.abc import Callable, Iterable, Sequence
from pathlib import Path

from raxel.io.files import write_json


class Kept:
    """The content read from each file, as JSON, while all files read for it are
    unchanged.

    It is stored in `.cache/NAME.json` of the checkout at ``root``, and is discarded
    when one of the files ``by``, the code that reads, changes.
    """

    def __init__(self, root: Path, name: str, by: Sequence[str]) -> None:
        self.root = root
        self._place = root / ".cache" / f"{name}.json"
        self._by = hashlib.sha256(
            b"".join(Path(f).read_bytes() for f in by)
        ).hexdigest()
        self._hashes: dict[str, str] = {}
        self._before = self._written()
        self._now: dict[str, dict] = {}

    def of(
        self, path: Path, read: Callable[[Path], tuple[object, Iterable[Path]]]
    ) -> object:
        """Return the content of ``path``; ``read`` returns it with the files that it
        opened."""
        name = self._name(path)
        entry = self._before.get(name)
        if entry is None or any(self._hash(n) != h for n, h in entry["from"].items()):
            says, files = read(path)
            hashes = {n: self._hash(n) for n in sorted(map(self._name, files))}
            entry = json.loads(json.dumps({"says": says, "from": hashes}))
        self._now[name] = entry
        return entry["says"]

    def keep(self) -> None:
        """Write the entries that were used, and no others."""
        if self._now != self._before:
            self._place.parent.mkdir(parents=True, exist_ok=True)
            write_json(self._place, {"by": self._by, "files": self._now})

    def _written(self) -> dict[str, dict]:
        try:
            content = json.loads(self._place.read_text("utf-8"))
            return content["files"] if content["by"] == self._by else {}
        except (OSError, ValueError, KeyError, TypeError):  # not kept yet, or damaged
            return {}

    def _name(self, path: Path) -> str:
        return path.relative_to(self.root).as_posix()

    def _hash(self, name: str) -> str:
        """Hash of a file's content; of nothing, if it is missing."""
        if name not in self._hashes:
            path = self.root / name
            content = path.read_bytes() if path.is_file() else b""
            self._hashes[name] = hashlib.sha256(content).hexdigest()
        return self._hashes[name]
