"""Rendered image sets: an experiment opens those that its mark declares, and no other.

A set is the folder `data/synthetic/RIG/SEED`, made from `data/rigs/RIG.yaml` by a job
of its own (`repro.workflow.rendering`). Beside it lies its manifest, `SEED.json`: the
files with their hashes, which stand for the set wherever it is somebody's input.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

FOLDER = "data/synthetic"
RIGS = "data/rigs"
TIMES = f"{FOLDER}/.times"
NAME = re.compile(r"([A-Za-z0-9][\w.-]*)/(0|[1-9]\d*)")
CHECKOUT = Path(__file__).resolve().parents[3]

_declared: list[frozenset[str]] = []


def manifest(name: str) -> str:
    """Path in the checkout of the manifest of the set ``RIG/SEED``."""
    return f"{FOLDER}/{name}.json"


def rig_file(name: str) -> str:
    """Path in the checkout of the rig of the set ``RIG/SEED``."""
    return f"{RIGS}/{name.partition('/')[0]}.yaml"


@contextmanager
def declared(names: Iterable[str]) -> Iterator[None]:
    """Let `rendered_set` open these sets inside, and no other."""
    _declared.append(frozenset(names))
    try:
        yield
    finally:
        _declared.pop()


def rendered_set(rig: str, seed: int) -> Path:
    """Folder of the set that the laboratory made from a rig and a seed.

    Raises LookupError inside an experiment whose mark does not declare the set:
    nothing would run it again when the set changes. Outside any, as in a notebook,
    it raises FileNotFoundError for a set that nobody has made.
    """
    name = f"{rig}/{seed}"
    if _declared and name not in _declared[-1]:
        known = ", ".join(sorted(_declared[-1])) or "none"
        raise LookupError(
            f"rendered set {name}: not declared by the mark of what runs (declared: "
            f"{known}); add it to the experiment's rendered="
        )
    folder = CHECKOUT / FOLDER / rig / str(seed)
    if not (folder / "set.yaml").is_file():
        place = f"{FOLDER}/{name}"
        raise FileNotFoundError(
            f"{place}: not made yet; make what reads it, or run: raxel render "
            f"{rig_file(name)} --out {place} --seed {seed}"
        )
    return folder
