"""The job that runs every claim test of a page, and collects its numbers."""

from __future__ import annotations

import json
from collections.abc import Callable, Mapping, Sequence
from dataclasses import replace
from pathlib import Path

from repro.judge.readings import crossed, open_questions
from repro.run import discover, jobs, results
from repro.run.outcomes import Reading


def judge(
    root: Path, page: str, effort: str, folder: Path, out: Path, readings: str = "open"
) -> None:
    """Run every claim test of a page, and collect its numbers and artefacts.

    ``readings`` is "open", or "all" to include settled questions.
    """
    mine = [p for p in discover.producers(root) if p.page == page]
    claims, numbers, artefacts = {}, {}, {}
    for found in mine:
        origin = {
            "evidence": found.details.get("evidence"),
            "source": [found.path, found.function],
        }
        if found.kind in ("claim", "numbers"):
            opened = results.opened(folder / "results", found.needs)
            function = jobs.function_of(found)
            data = [f"results/{need}.json" for need in found.needs]
        if found.kind == "claim":
            questions = found.details.get("readings", ())
            known = open_questions(root) if questions else {}
            claim = None if readings == "all" else found.id
            made = in_every_reading(function, opened, known, questions, claim)
            claims[found.id] = {
                **origin,
                "readings": [_finite(reading.as_dict()) for reading in made],
                "data": data,
            }
        elif found.kind == "numbers":
            numbers |= {
                key: _finite({**vars(value), **origin, "data": data})
                for key, value in function(opened).items()
            }
        elif found.kind in ("figure", "table"):
            described = json.loads((folder / f"{found.id}.json").read_text("utf-8"))
            endings = ["svg", "png", "csv"] if found.kind == "figure" else ["csv"]
            endings += ["html"] if found.details.get("scene") else []
            artefacts[found.id] = {
                **origin,
                "files": [(folder / f"{found.id}.{e}").as_posix() for e in endings],
                "check": described["check"],
            }
    results.write_json(
        out,
        {
            "page": page,
            "effort": effort,
            "claims": claims,
            "numbers": numbers,
            "artefacts": artefacts,
        },
    )


def in_every_reading(
    judge: Callable[..., Reading],
    results: Mapping,
    known: Mapping[str, dict],
    questions: Sequence[str],
    claim: str | None = None,
) -> list[Reading]:
    """Return the readings of a claim, one call of its test each, the primary one first.

    known: the ledger's questions (`repro.judge.readings.open_questions`). claim: leave
    out what is settled for it.
    """
    if not questions:
        return [judge(results)]
    return [
        replace(judge(results, options), reading=options)
        for options in crossed(known, questions, claim)
    ]


def _finite(values: dict) -> dict:
    """Infinite or missing floats as text or null, so that the JSON is plain."""

    def plain(value: object) -> object:
        if isinstance(value, tuple | list):
            return [plain(v) for v in value]
        if hasattr(value, "item"):
            value = value.item()
        if isinstance(value, float) and value != value:
            return None
        if isinstance(value, float) and value in (float("inf"), float("-inf")):
            return str(value)
        return value

    return {key: plain(value) for key, value in values.items()}
