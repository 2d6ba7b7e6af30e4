"""The scoreboard as a page: complete without JavaScript, filtered with it.

python -m repro.site.scoreboard --effort full --judged DIR --out-json F --out-page F
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from pathlib import Path

from jinja2 import Environment

from repro.judge.firmness import ALL, NONE, SOME
from repro.judge.ledger import LedgerError
from repro.judge.number_rules import VerdictError
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
from repro.run import discover
from repro.run.results import write_atomic, write_json

TEMPLATES = Path(__file__).with_name("templates")


def page(
    rows: Sequence[Mapping],
    sources: Iterable[str] = (),
    statements: Sequence[Mapping] = (),
) -> str:
    """The scoreboard's page, MyST with HTML. ``rows`` have passed `checked`.

    ``sources`` are the pages whose file the site offers, ``statements`` those whose
    leading claims the first screen shows.
    """
    template = _templates().get_template("scoreboard.md.jinja")
    leading = concluded([one for one in statements if "leading" in one], rows)
    return template.render(_shown(rows), sources=set(sources), leading=leading) + "\n"


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


def main(argv: list[str] | None = None) -> int:
    """Write the board's JSON and page; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m repro.site.scoreboard")
    parser.add_argument("--effort", choices=("quick", "full"), required=True)
    parser.add_argument("--judged", type=Path, required=True)
    parser.add_argument("--out-json", type=Path, required=True)
    parser.add_argument("--out-page", type=Path, required=True)
    a = parser.parse_args(argv)
    root = Path.cwd()
    try:
        rows = rows_of(root, a.effort, a.judged)
        statements = read_statements(root)
    except (VerdictError, LedgerError) as error:
        print(error, file=sys.stderr)
        return 1
    sources = {discover.page_id(root, path) for path in discover.page_files(root)}
    write_json(a.out_json, rows)
    write_atomic(a.out_page, page(rows, sources, statements))
    for name, count in headline(rows)["verdict"].items():
        print(f"{count:5d} {name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
