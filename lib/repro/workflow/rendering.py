"""The task that renders a set, and the dependencies of the set.

The simulator is used only through its command: `raxel render`.
"""

from __future__ import annotations

import hashlib
import importlib
import os
import shutil
from collections.abc import Iterable
from functools import cached_property
from pathlib import Path

from raxel.errors import InputError
from repro.run.discover import Producer
from repro.run.reach import Reach
from repro.run.rendered import FOLDER, NAME, manifest, rig_file
from repro.run.results import WRITTEN, hash_of, write_json

COMMAND = "raxel.cli"
CODE = ("raxel.cli.images", "render")
SCHEMA = "lib/raxel/lab/rig.schema.json"


class RenderedSets:
    """The sets that experiments of one size declare, and the key of each."""

    def __init__(
        self, root: Path, reach: Reach, producers: Iterable[Producer], effort: str
    ) -> None:
        self.root = root
        self.reach = reach
        self.effort = effort
        self.producers = producers

    @cached_property
    def names(self) -> list[str]:
        """Every declared ``RIG/SEED``, once; ValueError for one without a rig."""
        found: dict[str, None] = {}
        for producer in self.producers:
            for name in producer.rendered(self.effort):
                self._check(producer, name)
                found[name] = None
        return list(found)

    def _check(self, producer: Producer, name: str) -> None:
        place = f"chapters/{producer.path}:{producer.line}: rendered set {name!r}"
        if not NAME.fullmatch(name):
            raise ValueError(f'{place}: write ("RIG/SEED", ...) for each size')
        if not (self.root / rig_file(name)).is_file():
            raise ValueError(f"{place}: no rig {rig_file(name)}; check the name")

    def key(self, name: str) -> str:
        """Return the key over the code, the rig and its schema; the seed is in the
        name."""
        files = [hash_of(self.root / file) for file in (rig_file(name), SCHEMA)]
        text = "\n".join([self.reach.key(CODE), *files])
        return hashlib.sha256(text.encode()).hexdigest()[:16]


def render_set(name: str) -> None:
    """Render a set ``RIG/SEED``, completely or not at all, then its manifest."""
    rig, seed = name.split("/")
    folder = Path(FOLDER) / name
    room = folder.with_name(f".{seed}")
    for left in (folder, room):  # of an older rig, or of a killed job
        shutil.rmtree(left, ignore_errors=True)
    room.mkdir(parents=True)
    made = room / seed
    try:
        render = importlib.import_module(COMMAND).main
        words = ["render", rig_file(name), "--out", str(made), "--seed", seed]
        if render(words):
            raise InputError(
                f"{rig_file(name)}: raxel render failed; see the line above"
            )
        os.rename(made, folder)
    finally:
        shutil.rmtree(room)
    files = sorted(path for path in folder.rglob("*") if path.is_file())
    WRITTEN.extend(files)
    hashes = {p.relative_to(folder).as_posix(): hash_of(p) for p in files}
    write_json(Path(manifest(name)), {"rig": rig, "seed": int(seed), "files": hashes})
