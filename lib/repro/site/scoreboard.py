"""The scoreboard as a page: every row without JavaScript, filtered with it.

python -m repro.site.scoreboard --effort full --judged DIR --out-json F --out-page F
"""

from __future__ import annotations

import argparse
import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from pathlib import Path

from repro.judge.ledger import LedgerError
from repro.judge.number_rules import VerdictError
from repro.judge.scoreboard import KINDS, MEANINGS, chapter_order, headline, rows_of
from repro.page.rows import (
    SIGNS,
    badge,
    judged_badge,
    links,
    name_of,
    published,
    regenerated,
    said,
    text,
)
from repro.run import discover
from repro.run.results import write_atomic, write_json


def page(rows: Sequence[Mapping], sources: Iterable[str] = ()) -> str:
    """The scoreboard's page, MyST with HTML. ``rows`` have passed `checked`.

    ``sources`` are the pages whose file the site offers.
    """
    known = set(sources)
    found = [row for row in rows if row["verdict"] != "not yet"]
    pending = [row for row in rows if row["verdict"] == "not yet"]
    return f"""---
hide-toc: true
---

# Scoreboard

Every artefact, section, number and claim that the thesis printed has one row here, and
every row has one verdict. {written_before(headline(rows)["changed"])} The same rows
are in <a href="scoreboard.json">scoreboard.json</a>.

<div id="rx-board" class="rx tex2jax_ignore mathjax_ignore">
{summary_table(rows, KINDS, MEANINGS)}
{_form(rows)}
<p id="rx-shown" class="rx-shown" role="status" aria-live="polite">{len(rows)} rows</p>
{_table("Rows with a value", found, known)}{_pending(pending, known)}
</div>
<script src="_static/scoreboard.js" defer></script>
"""


def written_before(changed: Sequence[str]) -> str:
    """When the tests were written, and which of them have been changed since."""
    said = "Each test was written down before its run"
    if not changed:
        return f"{said}."
    links = [
        f'<a href="scoreboard.html#{name}"><code>{text(name)}</code></a>'
        for name in changed
    ]
    which = "that of" if len(links) == 1 else "those of"
    return (
        f"{said}, except {which} {', '.join(links)}, changed after a run had been seen."
    )


def _table(caption: str, rows: Sequence[Mapping], known: set[str]) -> str:
    heads = (
        "row", "verdict", "published", "regenerated", "reason, test, readings", "links",
    )  # fmt: skip
    head = "".join(f'<th scope="col">{name}</th>' for name in heads)
    return "\n".join(
        [
            f'<table class="rx-rows"><caption>{caption}</caption>',
            f"<thead><tr>{head}</tr></thead>",
            "<tbody>",
            *(_line(row, known) for row in rows),
            "</tbody></table>",
        ]
    )


def _pending(rows: Sequence[Mapping], known: set[str]) -> str:
    """What nothing produces yet, folded away: most of a board that is being filled."""
    if not rows:
        return ""
    return (
        '\n<details class="rx-pending"><summary>Not yet (nothing produces it so far): '
        f"{len(rows)}</summary>\n{_table('Not yet', rows, known)}\n</details>"
    )


def _line(row: Mapping, sources: set[str]) -> str:
    chapter = text(row["chapter"])
    about = f"{row['kind']}, chapter {chapter}"
    if row["evidence"]:
        about += f", {text(row['evidence'])}"
    cells = (
        ("v", judged_badge(row)),
        ("p", published(row)),
        ("g", regenerated(row)),
        ("r", said(row)),
        ("l", links(row, "", sources)),
    )
    inside = "".join(f'<td class="{key}">{cell}</td>' for key, cell in cells)
    known = name_of(row)
    return (
        f'<tr id="{row["id"]}" data-chapter="{chapter}" data-kind="{row["kind"]}" '
        f'data-verdict="{row["verdict"]}"><th scope="row">{known}<small>{about}</small>'
        f"</th>{inside}</tr>"
    )


def _form(rows: Sequence[Mapping]) -> str:
    chapters = sorted({str(row["chapter"]) for row in rows}, key=chapter_order)
    have = {row["verdict"] for row in rows}
    choices = {
        "chapter": {name: f"chapter {name}" for name in chapters},
        "kind": {kind: f"{kind}s" for kind in KINDS},
        "verdict": {v: f"{SIGNS[v]} {v}" for v in MEANINGS if v in have},
    }
    chosen = "".join(_choice(name, options) for name, options in choices.items())
    return (
        f'<form id="rx-filter" class="rx-filter" role="search" hidden>{chosen}'
        '<label for="rx-q">text <input id="rx-q" name="q" type="search" '
        'autocomplete="off" spellcheck="false"></label>'
        '<button type="reset">show all</button></form>'
    )


def _choice(name: str, options: Mapping[str, str]) -> str:
    listed = "".join(
        f'<option value="{text(value)}">{text(said)}</option>'
        for value, said in options.items()
    )
    return (
        f'<label for="rx-{name}">{name} <select id="rx-{name}" name="{name}">'
        f'<option value="">all</option>{listed}</select></label>'
    )


def summary_table(
    rows: Sequence[Mapping], kinds: Sequence[str], meanings: Mapping[str, str]
) -> str:
    """Counts by verdict and kind, each a link to the board filtered, with meanings."""
    found = Counter((row["verdict"], row["kind"]) for row in rows)
    head = "".join(f'<th scope="col" class="rx-count">{kind}s</th>' for kind in kinds)
    lines = [
        '<table class="rx-summary"><caption>Rows by verdict and kind</caption><thead>'
        f'<tr><th scope="col">verdict</th>{head}'
        '<th scope="col" class="rx-count">all</th>'
        '<th scope="col">what it means</th></tr></thead><tbody>'
    ]
    for verdict, meaning in meanings.items():
        counts = [found[verdict, kind] for kind in kinds]
        if not sum(counts) and verdict == "quick":
            continue
        cells = [
            _count(n, {"kind": kind, "verdict": verdict})
            for n, kind in zip(counts, kinds, strict=True)
        ]
        cells.append(_count(sum(counts), {"verdict": verdict}))
        lines.append(
            f'<tr><th scope="row">{badge(verdict)}</th>{"".join(cells)}'
            f"<td>{text(meaning)}</td></tr>"
        )
    sums = [_count(sum(r["kind"] == k for r in rows), {"kind": k}) for k in kinds]
    lines.append(
        f'</tbody><tfoot><tr><th scope="row">all</th>{"".join(sums)}'
        f'<td class="rx-count">{len(rows)}</td><td></td></tr></tfoot></table>'
    )
    return "\n".join(lines)


def _count(number: int, filters: Mapping[str, str]) -> str:
    if not number:
        return '<td class="rx-count rx-none">0</td>'
    state = "&amp;".join(f"{k}={v.replace(' ', '+')}" for k, v in filters.items())
    said = ", ".join(filters.values())
    return (
        f'<td class="rx-count"><a href="#{state}" '
        f'aria-label="{number}: show {said}">{number}</a></td>'
    )


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
    except (VerdictError, LedgerError) as error:
        print(error, file=sys.stderr)
        return 1
    sources = {discover.page_id(root, path) for path in discover.page_files(root)}
    write_json(a.out_json, rows)
    write_atomic(a.out_page, page(rows, sources))
    for name, count in headline(rows)["verdict"].items():
        print(f"{count:5d} {name}")
    return 0


if __name__ == "__main__":
    sys.exit(main())
