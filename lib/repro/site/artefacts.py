"""The page of all artefacts: each with image, verdict, finding and sources.

A finding is one sentence from the build: from the verdicts of the claims that name the
artefact, or else from its own check or its caption.
"""

from __future__ import annotations

import csv
import json
import re
from collections.abc import Container, Mapping, Sequence
from dataclasses import dataclass
from functools import cache
from itertools import groupby, islice
from pathlib import Path

from jinja2 import Environment

from repro.judge.scoreboard import chapter_order, natural
from repro.page.furniture import Behind, Furnisher
from repro.page.rows import row_templates
from repro.page.wording import label, number_in, plain, rounded
from repro.site.numbered import listed

TEMPLATES = Path(__file__).with_name("templates")
# Columns, rows and length of a cell in the preview of a table.
COLUMNS, ROWS, CELL = 3, 4, 22
# An exclamation mark is part of a camera's name, and does not end a caption.
SENTENCE = re.compile(r"(?<=[.?])\s+(?=[A-Z(])")
CLAUSE = re.compile(r"[;:(]")


@dataclass(frozen=True)
class Artefact:
    """A figure or table of the build, with all its links.

    lines: its card shows no image (`repro.page.style.only_lines`).
    """

    name: str
    label: str
    caption: str
    page: str
    row: Mapping | None
    finding: str
    files: Sequence[tuple[str, str]]
    behind: Behind
    picture: str
    lines: bool
    head: Sequence[str]
    cells: Sequence[Sequence[str]]


def artefacts(
    furnisher: Furnisher, pages: Sequence[str], board: Sequence[Mapping]
) -> list[Artefact]:
    """Return the artefacts of a build, page by page, those of the thesis first.

    ``pages`` are the ids of its pages in order, ``board`` the rows of the scoreboard.
    """
    base = furnisher.base
    known = {p.id for p in furnisher.made if p.kind in ("figure", "table")}
    rows = {row["id"]: row for row in board}
    found = []
    for path in base.glob("*.json"):
        name = path.stem
        if name in known:
            about = json.loads(path.read_text("utf-8"))
            page = _page(about)
            if page in pages:
                claims = [rows[c] for c in furnisher.book.claims_of(name) if c in rows]
                found.append(
                    _artefact(
                        base, name, about, page, rows.get(name), claims, furnisher
                    )
                )
    return sorted(
        found, key=lambda a: (pages.index(a.page), not a.label, natural(a.name))
    )


def page(
    found: Sequence[Artefact],
    chapters: Sequence[tuple[str, Sequence]],
    thesis: Mapping[str, dict],
) -> str:
    """Return the page, MyST with HTML; ``chapters`` are titles with the pages of each.

    ``thesis`` are the artefacts of the ledger: those of a page come first, and its
    extensions are folded below them.
    """
    by_page: dict[str, tuple[list[Artefact], list[Artefact]]] = {}
    for artefact in found:
        extends = artefact.name not in thesis
        by_page.setdefault(artefact.page, ([], []))[extends].append(artefact)
    parts = [
        (title, [(page, *by_page[page.name]) for page in own if page.name in by_page])
        for title, own in chapters
    ]
    template = _templates().get_template("artefacts.md.jinja")
    shown = template.render(
        chapters=[part for part in parts if part[1]],
        own=sum(len(own) for own, _ in by_page.values()),
        more=sum(len(more) for _, more in by_page.values()),
        index=_index(thesis, {artefact.name for artefact in found}),
    )
    return shown + "\n"


def _index(thesis: Mapping[str, dict], built: Container[str]) -> list[dict]:
    """By chapter of the thesis: kind -> ids that are built, and the others as text."""
    chapters: dict[str, list[str]] = {}
    for identifier, entry in thesis.items():
        chapters.setdefault(str(entry["chapter"]), []).append(identifier)
    return [
        {
            "chapter": number,
            "kinds": {
                kind: list(of_kind)
                for kind, of_kind in groupby(
                    sorted((i for i in own if i in built), key=natural),
                    key=lambda i: label(i).rpartition(" ")[0],
                )
            },
            "missing": listed(sorted((i for i in own if i not in built), key=natural)),
        }
        for number, own in sorted(chapters.items(), key=lambda c: chapter_order(c[0]))
    ]


@cache
def _templates() -> Environment:
    return row_templates(TEMPLATES)


def _artefact(
    base: Path,
    name: str,
    about: Mapping,
    page: str,
    row: Mapping | None,
    claims: Sequence[Mapping],
    furnisher: Furnisher,
) -> Artefact:
    drawn = (base / f"{name}.png").is_file()
    head, cells = ([], []) if drawn else preview(base / f"{name}.csv")
    endings = ("svg", "png", "csv") if drawn else ("csv",)
    scene = [(f"figures/{name}.html", about["scene"])] if about.get("scene") else []
    return Artefact(
        name=name,
        label=label(name),
        caption=first_sentence(about["caption"]),
        page=page,
        row=row,
        finding=finding(row, claims) or first_sentence(about["caption"]),
        files=[(f"figures/{name}.{ending}", ending.upper()) for ending in endings]
        + scene,
        behind=furnisher.behind(name, about),
        picture=f"figures/{name}.png" if drawn else "",
        lines=not drawn or about["lines"],
        head=head,
        cells=cells,
    )


def _page(about: Mapping) -> str:
    """Id of the page of an artefact."""
    return "/".join(about["source"][0].split("/")[:2])


def finding(row: Mapping | None, claims: Sequence[Mapping]) -> str:
    """Return one sentence on the result, from verdicts; empty without any.

    ``row`` is the artefact's row of the scoreboard, ``claims`` those of its claims.
    """
    by_verdict: dict[str, list[Mapping]] = {}
    for claim in claims:
        by_verdict.setdefault(claim["verdict"], []).append(claim)
    held = by_verdict.get("reproduced", [])
    lost = by_verdict.get("differs", [])
    open_ = by_verdict.get("undecided", [])
    decided = len(held) + len(lost)
    if lost and decided == 1:
        return f"Does not hold here: {_quoted(lost)}"
    if lost:
        hold = f"{len(held)} of {decided} decided claims"
        return f"{hold} {'holds' if len(held) == 1 else 'hold'}; not: {_quoted(lost)}"
    if held:
        hold = "Holds" if decided == 1 else f"All {decided} decided claims hold"
        return f"{hold}: {_quoted(held)}"
    if open_:
        return f"Undecided: {_quoted(open_)}"
    _, checked, check = (row["reason"] if row else "").rpartition("check: ")
    drawn = row and checked and row["verdict"] in ("reproduced", "differs")
    return f"{check[:1].upper()}{check[1:]}." if drawn else ""


def _quoted(claims: Sequence[Mapping]) -> str:
    """The statement of the first claim, and the number of others with its verdict.

    The regenerated value follows: words, or a number and its meaning.
    """
    first, more = claims[0], len(claims) - 1
    statement, found = (first[key] for key in ("published", "regenerated"))
    parts = [f"“{' '.join(statement.split()).rstrip('.')}”"]
    if isinstance(found, str):
        parts.append(f" (here: {' '.join(found.split())})")
    if more:
        parts.append(f", and {more} more")
    if isinstance(found, int | float):
        number = rounded(found, first["interval"], first["unit"])
        parts.append(f"; here {number}, {_meaning(first['reason'])}".rstrip(", "))
    return f"{''.join(parts)}."


def _meaning(reason: str) -> str:
    """Meaning of the number of a claim: the first clause of its reason."""
    return " ".join(CLAUSE.split(reason, maxsplit=1)[0].split()).rstrip(" ,")


def first_sentence(caption: str) -> str:
    """Return the first sentence of a caption, without markup."""
    return SENTENCE.split(plain(caption), maxsplit=1)[0]


def preview(path: Path) -> tuple[list[str], list[list[str]]]:
    """Return head and first cells of a table, without the ends of intervals."""
    with path.open(encoding="utf-8", newline="") as file:
        head, *rows = islice(csv.reader(file), ROWS + 1)
    shown = [
        place for place, name in enumerate(head) if not name.endswith((" low", " high"))
    ][:COLUMNS]
    lines = [[_cut(line[place]) for place in shown] for line in (head, *rows)]
    return lines[0], lines[1:]


def _cut(cell: str) -> str:
    text = plain(cell)
    number = number_in(text)
    text = text if number is None else f"{number:.4g}"
    return text if len(text) <= CELL else f"{text[: CELL - 1]}…"
