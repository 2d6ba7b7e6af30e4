"""Rows of cells as columns: the form in which figures and tables keep their data."""

from __future__ import annotations

from collections.abc import Iterable, Sequence


def columns(names: Iterable[str], rows: Iterable[Sequence]) -> dict[str, list]:
    """Column name -> its cells, one from each row; a row has a cell for every name."""
    found: dict[str, list] = {name: [] for name in names}
    for row in rows:
        for name, cell in zip(found, row, strict=True):
            found[name].append(cell)
    return found
