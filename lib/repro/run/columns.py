"""Rows of cells as columns: the form in which figures and tables keep their data."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from io import StringIO


def columns(names: Iterable[str], rows: Iterable[Sequence]) -> dict[str, list]:
    """Column name -> its cells, one from each row; a row has a cell for every name."""
    found: dict[str, list] = {name: [] for name in names}
    for row in rows:
        for name, cell in zip(found, row, strict=True):
            found[name].append(cell)
    return found


def csv_text(columns: Mapping[str, Sequence]) -> str:
    """CSV of named columns, numbers in full precision."""
    buffer = StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    return buffer.getvalue()
