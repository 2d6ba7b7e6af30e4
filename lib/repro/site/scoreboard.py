"""The scoreboard as a page: complete without JavaScript, filtered with it."""

from __future__ import annotations

from collections import Counter
from collections.abc import Mapping, Sequence
from functools import cache
from pathlib import Path

from jinja2 import Environment

from repro.judge.firmness import ALL, NONE, SOME
from repro.judge.scoreboard import (
    KINDS,
    MEANINGS,
    chapter_order,
    concluded,
    headline,
    read_statements,
    rows_of,
)
from repro.page.rows import SIGNS, row_templates, words_of
from repro.run.results import write_atomic, write_json

TEMPLATES = Path(__file__).with_name("templates")


def page(rows: Sequence[Mapping], statements: Sequence[Mapping] = ()) -> str:
    """The scoreboard's page, MyST with HTML. ``rows`` have passed `checked`.

    ``statements`` are those whose leading claims the first screen shows.
    """
    template = _templates().get_template("scoreboard.md.jinja")
    leading = concluded([one for one in statements if "leading" in one], rows)
    return template.render(_shown(rows), leading=leading) + "\n"


@cache
def _templates() -> Environment:
    templates = row_templates(TEMPLATES)
    templates.globals["state"] = state
    return templates


def state(filters: Mapping[str, str]) -> str:
    """Part of the address that the page's script adds for these filters."""
    return "&".join(f"{k}={v.replace(' ', '+')}" for k, v in filters.items())


def _shown(rows: Sequence[Mapping]) -> dict:
    """Values of the page's template."""
    count = Counter((row["verdict"], row["kind"]) for row in rows)
    have = {row["verdict"] for row in rows}
    chapters = sorted({str(row["chapter"]) for row in rows}, key=chapter_order)
    counts = headline(rows)
    return {
        "all": len(rows),
        "changed": counts["changed"],
        "claims": counts["claims"],
        "words": words_of(rows),
        "firm": [
            (
                f"{number} of the {counts['claims'][verdict]} {verdict}",
                {"kind": "claim", "verdict": verdict, "readings": ALL},
            )
            for verdict, number in counts["firm"].items()
        ],
        "not_firm": sum(row["firmness"] == NONE for row in rows),
        "kinds": KINDS,
        "summary": [
            (verdict, meaning, {kind: count[verdict, kind] for kind in KINDS})
            for verdict, meaning in MEANINGS.items()
            if verdict in have or verdict != "quick"
        ],
        "sums": {kind: sum(row["kind"] == kind for row in rows) for kind in KINDS},
        "choices": {
            "chapter": {name: f"chapter {name}" for name in chapters},
            "kind": {kind: f"{kind}s" for kind in KINDS},
            "verdict": {v: f"{SIGNS[v]} {v}" for v in MEANINGS if v in have},
            "readings": {
                ALL: f"in {ALL}",
                SOME: f"in {SOME} only",
                NONE: "no claim is firm",
            },
            "test": {"changed": "changed after a run"},
        },
        "found": [row for row in rows if row["verdict"] != "not yet"],
        "pending": [row for row in rows if row["verdict"] == "not yet"],
    }


def written_before(changed: Sequence[str]) -> str:
    """Return when the tests were written, and which of them were changed since."""
    macros = _templates().get_template("changed.html.jinja").module
    return str(macros.written_before(changed))


def write_board(
    root: Path, effort: str, judged: Path, rows_file: Path, page_file: Path
) -> None:
    """Write the board's JSON and page."""
    rows = rows_of(root, effort, judged)
    statements = read_statements(root)
    write_json(rows_file, rows)
    write_atomic(page_file, page(rows, statements))
    for name, count in headline(rows)["verdict"].items():
        print(f"{count:5d} {name}")
