"""The accepted build, and what a later build moved.

    python -m repro.judge.reference reference|compare --effort full

`data/reference/<effort>.csv` has a line for each row of the scoreboard: its verdict,
and the value of a number or claim with its 95 % interval.
"""

from __future__ import annotations

import argparse
import csv
import math
import sys
from collections.abc import Mapping, Sequence
from io import StringIO
from pathlib import Path
from textwrap import shorten
from typing import NamedTuple

from raxel.errors import InputError
from raxel.io.files import write_whole
from repro.judge.scoreboard import rows_of

FIELDS = ("id", "verdict", "value", "low", "high")
INTERVAL_SDS = 2 * 1.96  # width of a 95 % interval in SD of the value
ROUNDING = 1e-9  # relative difference of the same sum on other processors

Entries = Mapping[str, Mapping[str, str]]


class Moved(NamedTuple):
    """A value that changed; ``sds`` is None if trials give it no scatter."""

    id: str
    before: str
    after: str
    sds: float | None


def entries(rows: Sequence[Mapping]) -> dict[str, dict[str, str]]:
    """Return id -> texts of `FIELDS`, for rows of the scoreboard in their order."""
    found = {}
    for row in rows:
        numbers = row["regenerated"], *(row["interval"] or (None, None))
        kept = numbers if row["kind"] in ("claim", "number") else [None] * 3
        texts = ("" if number is None else str(number) for number in kept)
        values = (row["id"], row["verdict"], *texts)
        found[row["id"]] = dict(zip(FIELDS, values, strict=True))
    return found


def compare(before: Entries, after: Entries) -> tuple[list[Moved], list[str]]:
    """Return moved values and changed verdicts; an id in one of the two counts as one.

    Exact values come first, then those that moved most.
    """
    both = [name for name in before if name in after]
    verdicts = [
        *(f"{name}: not in this build" for name in before if name not in after),
        *(f"{name}: not in the reference" for name in after if name not in before),
        *(
            f"{name}: {before[name]['verdict']} -> {after[name]['verdict']}"
            for name in both
            if before[name]["verdict"] != after[name]["verdict"]
        ),
    ]
    found = [_moved(before[name], after[name]) for name in both]
    moved = sorted(
        (one for one in found if one), key=lambda one: -abs(one.sds or math.inf)
    )
    return moved, verdicts


def _moved(old: Mapping[str, str], new: Mapping[str, str]) -> Moved | None:
    """The change of one value, in standard deviations of the value in ``old``."""
    texts = old["value"], new["value"]
    try:
        first, second = map(float, texts)
    except ValueError:
        same = texts[0] == texts[1]
        return None if same else Moved(old["id"], *texts, None)
    if math.isclose(first, second, rel_tol=ROUNDING):
        return None
    width = float(old["high"] or 0) - float(old["low"] or 0)
    scattered = 0 < width < math.inf
    sds = (second - first) * INTERVAL_SDS / width if scattered else None
    return Moved(old["id"], f"{first:.6g}", f"{second:.6g}", sds)


def written(found: Entries) -> str:
    """Return the text of a reference file."""
    out = StringIO()
    writer = csv.DictWriter(out, FIELDS, lineterminator="\n")
    writer.writeheader()
    writer.writerows(found.values())
    return out.getvalue()


def shown(moved: Sequence[Moved], verdicts: Sequence[str], values: int) -> str:
    """Return lines: the moved values, the changed verdicts, the counts."""
    lines = [
        f"{one.id:34} {shorten(one.before, 40):>14} -> {shorten(one.after, 40):14} "
        + ("exact" if one.sds is None else f"{one.sds:+.2g} SD")
        for one in moved
    ]
    largest = max((abs(one.sds) for one in moved if one.sds), default=0)
    counts = (
        f"{len(moved)} of {values} values moved (by at most {largest:.2g} SD), "
        f"{len(verdicts)} verdicts changed"
    )
    return "\n".join([*lines, *verdicts, counts])


def built(root: Path, effort: str) -> dict[str, dict[str, str]]:
    """Return the entries of a finished build; raises InputError without one."""
    base = root / "figures" / effort
    if not (base / "scoreboard.json").is_file():
        target = "quick" if effort == "quick" else "report"
        raise InputError(f"no finished {effort} build; run make {target}")
    return entries(rows_of(root, effort, base / "judged"))


def main(argv: Sequence[str] | None = None) -> int:
    """Write or compare the reference; exit status 1 for a changed verdict."""
    parser = argparse.ArgumentParser(prog="python -m repro.judge.reference")
    parser.add_argument("action", choices=("reference", "compare"))
    parser.add_argument("--effort", choices=("quick", "full"), default="full")
    asked = parser.parse_args(argv)
    name = f"data/reference/{asked.effort}.csv"
    try:
        now = built(Path.cwd(), asked.effort)
        if asked.action == "compare":
            _compare(name, now)
        else:
            write_whole(name, written(now))
            print(f"{name}: {len(now)} rows; commit it with the reason")
    except InputError as error:
        print(f"make {asked.action}: {error}", file=sys.stderr)
        return 1
    return 0


def _compare(name: str, now: Entries) -> None:
    """Print what moved; raises InputError for a changed verdict."""
    if not Path(name).is_file():
        raise InputError(f"{name}: no reference; run make reference")
    with open(name, encoding="utf-8", newline="") as file:
        before = {row["id"]: row for row in csv.DictReader(file)}
    moved, verdicts = compare(before, now)
    print(shown(moved, verdicts, sum(bool(row["value"]) for row in before.values())))
    if verdicts:
        raise InputError("verdicts changed; if intended, run make reference")


if __name__ == "__main__":
    sys.exit(main())
