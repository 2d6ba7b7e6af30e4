"""The readings of an ambiguous text: every combination of options in the ledger.

`settings.yaml` lists each ambiguous question with its options, the primary one first. A
claim is tested with all options, in all combinations with the options of the other
questions that concern it, except those that `not_crossed_with` excludes. A question is
`settled` for a claim if all its options gave the same verdict: a normal build then
judges the claim with the primary option only.
"""

from __future__ import annotations

from collections.abc import Mapping, Sequence
from functools import cache
from itertools import product
from pathlib import Path

from repro.judge.ledger import FOLDER, LedgerError, read_yaml
from repro.judge.schema import hint


def open_questions(root: Path) -> Mapping[str, dict]:
    """Return question -> its entry of `settings.yaml` in the checkout at ``root``."""
    path = root / FOLDER / "settings.yaml"
    return _questions(path, path.stat().st_mtime_ns)


@cache
def _questions(path: Path, changed: int) -> Mapping[str, dict]:
    """Entries of a file with this modification time; an unchanged one is read once."""
    return {entry["id"]: entry for entry in read_yaml(path)["readings"]}


def crossed(
    known: Mapping[str, dict], questions: Sequence[str], claim: str | None = None
) -> list[dict[str, str]]:
    """Return options by question: every combination that is judged, the primary one
    first.

    known: entries of `open_questions`. claim: questions settled for it have the primary
    option only. Raises LedgerError for a question that is not in `known`.
    """
    for question in questions:
        if question not in known:
            raise LedgerError(
                f"reading: question {question!r} is not in settings.yaml"
                f"{hint(question, list(known))}"
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
    """Whether a combination of options is judged.

    Other options of a question are combined with only the primary options of the
    questions in `not_crossed_with`, because each combination would need runs of its
    own.
    """
    away = [q for q, option in reading.items() if option != known[q]["primary"]]
    return not any(
        other in away
        for question in away
        for other in known[question].get("not_crossed_with", ())
    )
