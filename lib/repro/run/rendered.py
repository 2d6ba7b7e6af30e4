"""Rendered image sets: an experiment opens only those that its decorator declares.

A set is the folder `data/synthetic/RIG/SEED`, which a separate job renders from
`data/rigs/RIG.yaml` (`repro.workflow.rendering`). Next to it is its manifest,
`SEED.json`: the files with their hashes, which represent the set as an input.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Iterator
from contextlib import contextmanager
from pathlib import Path

FOLDER = "data/synthetic"
RIGS = "data/rigs"
NAME = re.compile(r"([A-Za-z0-9][\w.-]*)/(0|[1-9]\d*)")
CHECKOUT = Path(__file__).resolve().parents[3]

_declared: list[frozenset[str]] = []


def manifest(name: str) -> str:
    """Return the path of the manifest of the set ``RIG/SEED`` in the checkout."""
    return f"{FOLDER}/{name}.json"


def rig_file(name: str) -> str:
    """Return the path of the rig of the set ``RIG/SEED`` in the checkout."""
    return f"{RIGS}/{name.partition('/')[0]}.yaml"


@contextmanager
def declared(names: Iterable[str]) -> Iterator[None]:
    """Allow `rendered_set` to open these sets inside, and no others."""
    _declared.append(frozenset(names))
    try:
        yield
    finally:
        _declared.pop()


def rendered_set(rig: str, seed: int) -> Path:
    """Return the folder of the set that was rendered from a rig and a seed.

    Raises LookupError inside an experiment whose decorator does not declare the set:
    the experiment would not be repeated when the set changes. Elsewhere, as in a
    notebook, it raises FileNotFoundError for a set that was not rendered yet.
    """
    name = f"{rig}/{seed}"
    if _declared and name not in _declared[-1]:
        known = ", ".join(sorted(_declared[-1])) or "none"
        raise LookupError(
            f"rendered set {name}: not declared by the experiment (declared: {known}); "
            "add it to rendered= of its decorator"
        )
    folder = CHECKOUT / FOLDER / rig / str(seed)
    if not (folder / "set.yaml").is_file():
        place = f"{FOLDER}/{name}"
        raise FileNotFoundError(
            f"{place}: not rendered yet; build what reads it, or run: raxel render "
            f"{rig_file(name)} --out {place} --seed {seed}"
        )
    return folder
