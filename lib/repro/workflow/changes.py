"""Say which functions changed since the last build, for every result they reach."""

from __future__ import annotations

import json

from repro.run.jobs import CODE
from repro.run.results import write_json
from repro.workflow.terminal import say
from repro.workflow.work import Work

KINDS = ("experiment", "figure", "table")


def _parts(work: Work) -> dict[str, dict[str, str]]:
    sets = {name: work.rendered.parts(name) for name in work.rendered.names}
    return sets | {
        identifier: work.reach.parts(
            (producer.module, producer.function),
            *(CODE if kind == "experiment" else ()),
        )
        for (kind, identifier), producer in work.producers.items()
        if kind in KINDS
    }


def _record(work: Work):
    return work.root / work.base / "code.json"


def remember(work: Work, built: set[str]) -> None:
    """Keep the parts of the keys of what was built, to name a difference later."""
    parts = {name: part for name, part in _parts(work).items() if name in built}
    write_json(_record(work), _remembered(work) | parts)


def _remembered(work: Work) -> dict[str, dict[str, str]]:
    """What was remembered; nothing where nobody can read it any more."""
    try:
        return json.loads(_record(work).read_text("utf-8"))
    except (OSError, ValueError):
        return {}


def say_changes(work: Work) -> None:
    """Print, for each changed result, the functions that changed."""
    before = _remembered(work)
    reasons: dict[str, list[str]] = {}
    for identifier, parts in _parts(work).items():
        if identifier in before and before[identifier] != parts:
            old = before[identifier].items()
            names = sorted({name for name, _ in old ^ parts.items()})
            reasons.setdefault(", ".join(names[:4]), []).append(identifier)
    for names, identifiers in reasons.items():
        say(f"changed: {names} -> {', '.join(identifiers)}")
