"""The scoreboard: everything the thesis printed, and what came out here.

    python -m repro.judge.scoreboard --effort full --judged DIR --out-json F --out-page F.md

The rows come from `repro.judge.verdict`. They are checked against a schema, written as JSON,
and set as a page that shows every row without JavaScript and filters with it. A
chapter page takes its own rows from the same function, so the two cannot disagree.
"""

from __future__ import annotations

import argparse
import re
import sys
from collections import Counter
from collections.abc import Iterable, Mapping, Sequence
from itertools import chain
from pathlib import Path

from repro.judge import ledger, verdict
from repro.judge.number_rules import VerdictError
from repro.judge.row_html import (
    SIGNS,
    breakable,
    judged_badge,
    limits_of,
    links,
    name_of,
    published,
    readings,
    regenerated,
    summary_table,
    text,
)
from repro.judge.schema import faults
from repro.run import discover
from repro.run.results import write_atomic, write_json

KINDS = ("artefact", "section", "claim", "number")
MEANINGS = {
    "reproduced": "The stated test holds. An artefact: all its decided claims hold, or "
    "what is drawn equals what was computed.",
    "differs": "The test does not hold. The reason says by how much.",
    "undecided": "The interval crosses the boundary of the test.",
    "counterpart": "Measured on hardware we do not have. A rendered value stands "
    "beside it and is not expected to be equal.",
    "setting": "A number that describes an experiment; not a result.",
    "not comparable": "No comparison is possible; the reason says why.",
    "not yet": "Nothing produces it so far; its chapter is not built.",
    "quick": "Few trials: a value and no verdict.",
}


def checked(rows: Sequence[Mapping]) -> list[dict]:
    """The rows in the order of the board; VerdictError names a faulty row and field."""
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
    """Sort key of a chapter's number: appendices stand last."""
    return not number.isdigit(), natural(number)


def natural(name: str) -> list:
    """Sort key by which 10 comes after 9."""
    return [
        (1, int(part), "") if part.isdigit() else (0, 0, part)
        for part in re.split(r"(\d+)", name)
        if part
    ]


def headline(rows: Sequence[Mapping]) -> dict:
    """Rows in all, by kind, by verdict, and of claims by verdict."""
    verdicts = Counter(row["verdict"] for row in rows)
    claims = Counter(row["verdict"] for row in rows if row["kind"] == "claim")
    return {
        "all": len(rows),
        "kind": Counter(row["kind"] for row in rows),
        "verdict": {v: verdicts[v] for v in MEANINGS if verdicts[v]},
        "claims": {v: claims[v] for v in MEANINGS if claims[v]},
        "changed": [row["id"] for row in rows if row["changed"]],
    }


def page(rows: Sequence[Mapping], sources: Iterable[str] = ()) -> str:
    """The scoreboard's page, MyST with HTML. ``rows`` have passed `checked`.

    ``sources`` are the pages whose chapter file the site offers.
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
        ("r", _said(row)),
        ("l", links(row, "", sources)),
    )
    inside = "".join(f'<td class="{key}">{cell}</td>' for key, cell in cells)
    known = name_of(row)
    return (
        f'<tr id="{row["id"]}" data-chapter="{chapter}" data-kind="{row["kind"]}" '
        f'data-verdict="{row["verdict"]}"><th scope="row">{known}<small>{about}</small>'
        f"</th>{inside}</tr>"
    )


def _said(row: Mapping) -> str:
    """The reason, the test behind a verdict that there is, and the other readings."""
    reason = f'<span class="rx-reason">{text(row["reason"])}</span>'
    return reason + limits_of(row) + readings(row)


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


def comparison_table(page: str, effort: str, root: Path) -> str:
    """The rows of one page as HTML: claims, numbers, artefacts judged there.

    ``page`` is its id, ``root`` the checkout. Reads the judged files of
    `judged_with`; what other pages produce plays no part, and may be missing.
    """
    folder = root / "figures" / effort / "judged"
    book = ledger.load(root)
    needed = judged_with(root, page, book)
    judged = [c for c in verdict.read_judged(folder) if c["page"] in needed]
    mine = {i for c in judged if c["page"] == page for k in verdict.KINDS for i in c[k]}
    every = chain(book.artefacts, book.numbers, book.claims, book.sections)
    elsewhere = {str(book.chapter(i)): "judged on another page" for i in every}
    rows = checked(verdict.rows(book, judged, elsewhere, effort))
    own = [row for row in rows if row["id"] in mine]
    tests = {
        p.id: f"source/{p.path}.html#{p.function}"
        for p in discover.producers(root)
        if p.kind == "claim"
    }
    return comparison(own, effort, "../" * page.count("/"), tests)


def judged_with(root: Path, page: str, book: ledger.Ledger) -> list[str]:
    """The page, and the pages whose claims decide the verdict of its artefacts."""
    made = discover.producers(root)
    drawn = [p.id for p in made if p.page == page and p.kind in ("figure", "table")]
    deciding = {claim for name in drawn for claim in book.claims_of(name)}
    pages = {p.page for p in made if p.kind == "claim" and p.id in deciding}
    return [page, *sorted(pages - {page})]


def comparison(
    rows: Sequence[Mapping], effort: str, up: str, tests: Mapping[str, str]
) -> str:
    """Rows as one table per kind; ``up`` leads to the top of the site.

    ``tests`` says where in the site the code of a claim's test is shown.
    """
    parts = ['<div class="rx tex2jax_ignore mathjax_ignore">']
    if effort == "quick":
        parts.append(
            "<p>A quick build: values from few trials. Verdicts are given at full "
            "size only.</p>"
        )
    for kind in ("claim", "number", "artefact"):
        own = [row for row in rows if row["kind"] == kind]
        if own:
            parts.append(_compared(kind, own, up, tests))
    if not rows:
        parts.append("<p>This page has no rows on the scoreboard.</p>")
    return "\n".join([*parts, "</div>"])


def _compared(
    kind: str, rows: Sequence[Mapping], up: str, tests: Mapping[str, str]
) -> str:
    head = "".join(
        f'<th scope="col">{name}</th>'
        for name in (f"{kind}, verdict", "published", "regenerated", "reason, readings")
    )
    lines = []
    for row in rows:
        name = (
            f'<a href="{up}scoreboard.html#{row["id"]}"><code>{breakable(row["id"])}'
            "</code></a>"
        )
        lines.append(
            f'<tr data-id="{row["id"]}" data-verdict="{row["verdict"]}">'
            f'<th scope="row">{name} {judged_badge(row)}</th>'
            f'<td class="p">{published(row)}</td><td class="g">{regenerated(row)}</td>'
            f'<td class="r">{_said(row)}{_behind(row, up, tests)}</td></tr>'
        )
    caption = f"{kind.capitalize()}s of this page"
    return "\n".join(
        [
            f'<table class="rx-rows rx-compared"><caption>{caption}</caption>',
            f"<thead><tr>{head}</tr></thead><tbody>",
            *lines,
            "</tbody></table>",
        ]
    )


def _behind(row: Mapping, up: str, tests: Mapping[str, str]) -> str:
    """Links to the test of a claim and to the data it read."""
    if row["id"] not in tests:
        return ""
    test = f'<a href="{text(up + tests[row["id"]])}">code of the test</a>'
    return f'<p class="rx-behind">{test} {links({**row, "page": None}, up, ())}</p>'


def rows_of(root: Path, effort: str, folder: Path) -> list[dict]:
    """The checked rows for the judged files below ``folder``."""
    judged = verdict.read_judged(folder)
    unfinished = verdict.read_unfinished(root)
    return checked(verdict.rows(ledger.load(root), judged, unfinished, effort))


def main(argv: list[str] | None = None) -> int:
    """Write the board's JSON and page; return the exit status."""
    parser = argparse.ArgumentParser(prog="python -m repro.judge.scoreboard")
    parser.add_argument("--effort", choices=("quick", "full"), required=True)
    parser.add_argument("--judged", type=Path, required=True)
    parser.add_argument("--out-json", type=Path, required=True)
    parser.add_argument("--out-page", type=Path, required=True)
    a = parser.parse_args(argv)
    root = Path.cwd()
    try:
        rows = rows_of(root, a.effort, a.judged)
    except (VerdictError, ledger.LedgerError) as error:
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
