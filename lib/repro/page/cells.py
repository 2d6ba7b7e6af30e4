"""Columns of a table's CSV, formatted for the page."""

from __future__ import annotations

import re
from collections.abc import Mapping, Sequence

from repro.page.wording import alike, number_in, rounded
from repro.run.as_columns import ends_of

NOTHING = "–"
# A number, alone or before its interval in parentheses.
MEASURED = re.compile(r"\S+( \(\S+ to \S+\))?")


def as_read(
    columns: Mapping[str, Sequence[str]],
    measured: Sequence[str],
    texts: Sequence[str],
    digits: int,
) -> dict[str, list[str]]:
    """Format the columns of a CSV: rounded numbers with intervals, no empty cell.

    ``measured`` are the columns with an interval in two more columns, ``texts`` those
    that are shown unchanged.
    """
    ends = {end for name in measured for end in ends_of(name)}
    return {
        name: list(cells)
        if name in texts
        else [
            cell or NOTHING
            for cell in (
                _with_interval(cells, *(columns[end] for end in ends_of(name)))
                if name in measured
                else alike(list(cells), digits)
            )
        ]
        for name, cells in columns.items()
        if name not in ends
    }


def _with_interval(
    values: Sequence[str], lows: Sequence[str], highs: Sequence[str]
) -> list[str]:
    return [
        rounded(float(value), (float(low), float(high)))
        if number_in(low) is not None and number_in(high) is not None
        else value
        for value, low, high in zip(values, lows, highs, strict=True)
    ]


def is_numeric(cells: Sequence[str]) -> bool:
    """Return whether a column contains numbers only: it is aligned to the right."""
    filled = [cell for cell in cells if cell != NOTHING]
    return bool(filled) and all(
        MEASURED.fullmatch(cell) and number_in(cell.split(" ")[0]) is not None
        for cell in filled
    )
