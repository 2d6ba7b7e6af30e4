"""Say which functions changed since the last build, for every result they reach."""

from __future__ import annotations

import json
from collections.abc import Mapping

from repro.run.jobs import CODE
from repro.run.reach import Place
from repro.run.results import write_json
from repro.workflow.terminal import say
from repro.workflow.work import Work

KINDS = ("experiment", "figure", "table")


def remember(work: Work, built: set[str]) -> None:
    """Keep the keys of what was built with their parts, to name a difference later."""
    before = _remembered(work)
    keys = {name: key for name, key in _keys(work).items() if name in built}
    new = {
        name: {"key": key, "parts": _parts(work, name)}
        for name, key in keys.items()
        if _key_of(before, name) != key
    }
    if new:
        write_json(_record(work), before | new)


def say_changes(work: Work) -> None:
    """Print, for each changed result, the functions that changed."""
    before = _remembered(work)
    reasons: dict[str, list[str]] = {}
    for identifier, key in _keys(work).items():
        if _key_of(before, identifier) not in (None, key):
            parts = _parts(work, identifier)
            names = changed_parts(before[identifier]["parts"], parts)
            reasons.setdefault(", ".join(names[:4]), []).append(identifier)
    for names, identifiers in reasons.items():
        say(f"changed: {names} -> {', '.join(identifiers)}")


def changed_parts(old: Mapping[str, str], new: Mapping[str, str]) -> list[str]:
    """Names of the parts that differ; what only moved or was renamed is none."""
    both = set(old.values()) & set(new.values())
    differing = old.items() ^ new.items()
    names = {name for name, part in differing if part not in both}
    return sorted(names or {name for name, _ in differing})


def _keys(work: Work) -> dict[str, str]:
    sets = {name: work.rendered.key(name) for name in work.rendered.names}
    made = _made(work).items()
    return sets | {name: work.reach.key(*functions) for name, functions in made}


def _parts(work: Work, identifier: str) -> dict[str, str]:
    functions = _made(work).get(identifier)
    return (
        work.reach.parts(*functions) if functions else work.rendered.parts(identifier)
    )


def _made(work: Work) -> dict[str, tuple[Place, ...]]:
    """The functions behind each experiment, figure and table."""
    return {
        identifier: (
            (producer.module, producer.function),
            *(CODE if kind == "experiment" else ()),
        )
        for (kind, identifier), producer in work.producers.items()
        if kind in KINDS
    }


def _record(work: Work):
    return work.root / work.base / "code.json"


def _remembered(work: Work) -> dict[str, dict]:
    """What was remembered; nothing where nobody can read it any more."""
    try:
        return json.loads(_record(work).read_text("utf-8"))
    except (OSError, ValueError):
        return {}


def _key_of(remembered: Mapping[str, dict], name: str) -> str | None:
    """Key of a result at its last build; None if it was none, or noted otherwise."""
    return remembered.get(name, {}).get("key")
