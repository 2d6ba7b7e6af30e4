"""Rows of cells as columns: the form in which figures and tables store their data."""

from __future__ import annotations

import csv
from collections.abc import Iterable, Mapping, Sequence
from io import StringIO
from math import isfinite

from repro.run.outcomes import Measured

ENDS = ("low", "high")


def columns(names: Iterable[str], rows: Iterable[Sequence]) -> dict[str, list]:
    """Return column name -> its cells; each row has a cell for every name."""
    found: dict[str, list] = {name: [] for name in names}
    for row in rows:
        for name, cell in zip(found, row, strict=True):
            found[name].append(cell)
    return found


def in_columns(rows: Iterable[Mapping]) -> dict[str, list]:
    """Return column name -> its cells, from rows with the same names."""
    first, *others = rows
    return {name: [row[name] for row in (first, *others)] for name in first}


def cell(number: float) -> float | None:
    """Return a number as a cell of a table; None (empty) if it is not finite."""
    return float(number) if isfinite(number) else None


def measured(columns: Mapping[str, Sequence]) -> list[str]:
    """Return the names of the columns that contain numbers with intervals."""
    return [
        name
        for name, cells in columns.items()
        if any(isinstance(cell, Measured) for cell in cells)
    ]


def ends_of(name: str) -> list[str]:
    """Return the names of the CSV columns with the interval of a column."""
    return [f"{name}, {end}" for end in ENDS]


def in_numbers(columns: Mapping[str, Sequence]) -> dict[str, Sequence]:
    """Return the columns with each `Measured` as three: value and ends of the
    interval."""
    found: dict[str, Sequence] = {}
    with_interval = measured(columns)
    for name, cells in columns.items():
        if name not in with_interval:
            found[name] = cells
            continue
        found[name] = [getattr(cell, "value", cell) for cell in cells]
        for column, end in zip(ends_of(name), ENDS, strict=True):
            found[column] = [getattr(cell, end, None) for cell in cells]
    return found


def csv_text(columns: Mapping[str, Sequence]) -> str:
    """CSV of named columns, numbers in full precision."""
    buffer = StringIO()
    writer = csv.writer(buffer, lineterminator="\n")
    writer.writerow(columns)
    writer.writerows(zip(*columns.values(), strict=True))
    return buffer.getvalue()
