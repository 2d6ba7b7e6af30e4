"""The readings of an open text: every combination of options that the ledger asks for.

A question that the text leaves open stands in `settings.yaml` with its options, the
primary one first. A claim is tested in all of them, and in all combinations with those
of the other questions that touch it, but for what `not_crossed_with` leaves out. A
question whose options were all found to give a claim the verdict of the primary one is
`settled` for that claim: a normal build judges it with the primary option only.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from itertools import product
from pathlib import Path

from repro.judge.ledger import FOLDER, LedgerError, read_yaml
from repro.judge.schema import hint


def open_questions(root: Path) -> Mapping[str, dict]:
    """Question -> its entry of `settings.yaml`, of the checkout at ``root``."""
    path = root / FOLDER / "settings.yaml"
    return _questions(path, path.stat().st_mtime_ns)


@cache
def _questions(path: Path, changed: int) -> Mapping[str, dict]:
    """Entries of a file with this time of change; one that stays is read once."""
    return {entry["id"]: entry for entry in read_yaml(path)["readings"]}


def crossed(
    known: Mapping[str, dict], questions: Sequence[str], claim: str | None = None
) -> list[dict[str, str]]:
    """Options by question: every combination that is judged, the primary one first.

    known: entries of `open_questions`. claim: of the questions that are settled for it,
    only the primary option. LedgerError for a question that `known` does not list.
    """
    for question in questions:
        if question not in known:
            raise LedgerError(
                f"reading: found the question {question!r}, which settings.yaml does "
                f"not list{hint(question, list(known))}"
            )
    options = [_options(known[question], claim) for question in questions]
    taken = (dict(zip(questions, chosen, strict=True)) for chosen in product(*options))
    return [reading for reading in taken if _asked(known, reading)]


def _options(entry: Mapping, claim: str | None) -> list[str]:
    settled = claim in entry.get("settled", {"claims": ()})["claims"]
    return [entry["primary"]] if settled else entry["options"]


def primary(known: Mapping[str, dict], questions: Sequence[str]) -> dict[str, str]:
    """The primary option of each question."""
    return {question: known[question]["primary"] for question in questions}


def _asked(known: Mapping[str, dict], reading: Mapping[str, str]) -> bool:
    """Whether a combination of options is asked for.

    Every other option of a question stands with the primary ones of those that the
    question is `not_crossed_with`: each of its runs would cost as much again for them.
    """
    away = [q for q, option in reading.items() if option != known[q]["primary"]]
    return not any(
        other in away
        for question in away
        for other in known[question].get("not_crossed_with", ())
    )
