"""Validate the files of `repro` against their schemas, as the library does."""

from __future__ import annotations

from collections.abc import Iterable
from pathlib import Path

from raxel.errors import did_you_mean
from raxel.io import documents

FOLDER = Path(__file__).parent / "schemas"


def faults(content: object, schema: str, name: str) -> list[str]:
    """As `raxel.io.documents.faults`; ``schema`` names a file in `judge/schemas`.

    ``name`` is the file's name, for the lines.
    """
    return documents.faults(content, name, FOLDER / f"{schema}.schema.json")


def hint(name: str, known: Iterable[str]) -> str:
    """Return '; did you mean x?' if one of the known names is similar."""
    near = did_you_mean(name, known)
    return f"; {near}" if near else ""
