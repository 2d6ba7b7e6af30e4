"""The rows of the scoreboard: published and regenerated values of the thesis.

The rows come from `repro.judge.verdict`. This module validates, sorts and counts them.
Pages and scoreboard use the same functions, so they cannot disagree.
"""

from __future__ import annotations

import re
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from repro.judge import firmness, ledger, verdict
from repro.judge.firmness import ALL
from repro.judge.number_rules import VerdictError
from repro.judge.schema import faults, hint

KINDS = ("artefact", "section", "claim", "number")
# The first of these verdicts among its claims is that of a statement.
WEAKEST = ("quick", "not yet", "differs", "undecided", "not comparable", "reproduced")
MEANINGS = {
    "reproduced": "The stated test holds. An artefact: all its decided claims hold, or "
    "the drawing equals the computed geometry.",
    "differs": "The test does not hold. The reason states by how much.",
    "undecided": "The interval crosses the boundary of the test.",
    "counterpart": "Measured on hardware we do not have. A rendered value is shown "
    "with its ratio to the published one. There is no verdict on agreement.",
    "set": "A number that was put into the rig or solved for. It is not a test of the "
    "thesis. The reason states how it was set.",
    "setting": "A number that describes an experiment; not a result.",
    "not comparable": "No comparison is possible. The reason states why.",
    "not yet": "Nothing produces it so far; its chapter is not built.",
    "quick": "Few trials: a value and no verdict.",
}


def checked(rows: Sequence[Mapping]) -> list[dict]:
    """Return the rows in the order of the board; VerdictError names an invalid row and
    field."""
    wrong = faults(list(rows), "scoreboard", "scoreboard")
    wrong += [
        f"scoreboard: {name}: id: {count} rows have it; rename one"
        for name, count in Counter(row["id"] for row in rows).items()
        if count > 1
    ]
    if wrong:
        raise VerdictError(wrong[0])
    return sorted(rows, key=_order)


def _order(row: Mapping) -> tuple:
    return (
        chapter_order(str(row["chapter"])),
        KINDS.index(row["kind"]),
        natural(row["id"]),
    )


def chapter_order(number: str) -> tuple:
    """Return the sort key of a chapter's number: appendices are last."""
    return not number.isdigit(), natural(number)


def natural(name: str) -> list:
    """Return a sort key by which 10 comes after 9."""
    return [
        (1, int(part), "") if part.isdigit() else (0, 0, part)
        for part in re.split(r"(\d+)", name)
        if part
    ]


def headline(rows: Sequence[Mapping]) -> dict:
    """Count the rows: all, by kind, by verdict; claims by verdict, and the firm
    ones."""
    verdicts = Counter(row["verdict"] for row in rows)
    of_claims = [row for row in rows if row["kind"] == "claim"]
    claims = Counter(row["verdict"] for row in of_claims)
    firm = Counter(row["verdict"] for row in of_claims if row["firmness"] == ALL)
    return {
        "all": len(rows),
        "kind": Counter(row["kind"] for row in rows),
        "verdict": {v: verdicts[v] for v in MEANINGS if verdicts[v]},
        "claims": {v: claims[v] for v in MEANINGS if claims[v]},
        "firm": {v: firm[v] for v in verdict.JUDGED if claims[v]},
        "changed": [row["id"] for row in rows if row["changed"]],
    }


def rows_of(root: Path, effort: str, folder: Path) -> list[dict]:
    """Return the validated rows for the judged files below ``folder``."""
    judged = verdict.read_judged(folder)
    unfinished = verdict.read_unfinished(root)
    return checked(verdict.rows(ledger.load(root), judged, unfinished, effort))


def read_statements(root: Path) -> list[dict]:
    """Return goals, contributions and summaries of the thesis, each with the ids of its
    claims; LedgerError for an invalid file or an unknown claim."""
    name, known = "conclusions.yaml", ledger.load(root).claims
    content = ledger.read_yaml(root / ledger.FOLDER / name)
    wrong = faults(content, "conclusions", name) or [
        f"{name}: {one['id']}: claims: found {claim!r}, no claim of claims.yaml"
        f"{hint(claim, known) or '; list it there'}"
        for one in content["statements"]
        for claim in one["claims"]
        if claim not in known
    ]
    if wrong:
        raise ledger.LedgerError(wrong[0])
    return content["statements"]


def verdict_of(verdicts: Iterable[str]) -> str:
    """Return the verdict of a statement from those of its claims.

    A claim that is not comparable leaves a part of the statement undecided.
    """
    weakest = min(verdicts, key=WEAKEST.index)
    return "undecided" if weakest == "not comparable" else weakest


def concluded(statements: Sequence[Mapping], rows: Sequence[Mapping]) -> list[dict]:
    """Return statements with verdict and firmness; their claims become rows."""
    board = {row["id"]: row for row in rows}
    found = [{**s, "claims": [board[c] for c in s["claims"]]} for s in statements]
    for one in found:
        one["verdict"] = verdict_of(row["verdict"] for row in one["claims"])
        one |= firmness.of_claims(one["verdict"], one["claims"])
    return found
