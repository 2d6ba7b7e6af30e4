"""`make where ID`: where something is made, from its id to the algorithm.

    python -m repro.run.where table_3_4 s3_2_results:omni.left_out

Takes figures, tables, claims, numbers, experiments, rendered sets, pages, and the names
that prose quotes. One line for each thing behind it, as `file:line`. Everything is
parsed, and only the files that the id concerns; no chapter is imported.
"""

from __future__ import annotations

import sys
from collections.abc import Sequence
from pathlib import Path

from raxel.errors import InputError
from repro.run.where.marked import STEMS
from repro.run.where.whereabouts import PlaceLine, UnknownId, Whereabouts, shown

__all__ = ["STEMS", "PlaceLine", "UnknownId", "Whereabouts", "main", "shown"]


def main(argv: Sequence[str] | None = None) -> int:
    """Print where the given ids are made; exit status 1 for one that nothing has."""
    given = list(sys.argv[1:] if argv is None else argv)
    if not given:
        print("make where ID: give an id, such as table_3_4", file=sys.stderr)
        return 1
    atlas = Whereabouts(Path.cwd())
    try:
        found = [shown(atlas.lines(one)) for one in joined(atlas, given)]
    except (UnknownId, InputError) as error:
        print(f"make where: {error}", file=sys.stderr)
        return 1
    print("\n\n".join(found))
    return 0


def joined(atlas: Whereabouts, words: Sequence[str]) -> list[str]:
    """Ids of words: `make` parts a quoted name that has blanks in it."""
    found, rest = [], list(words)
    while rest:
        lengths = range(len(rest), 1, -1)
        fit = (n for n in lengths if atlas.quoting(" ".join(rest[:n])))
        count = next(fit, 1)
        found.append(" ".join(rest[:count]))
        rest = rest[count:]
    return found
