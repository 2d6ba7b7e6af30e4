"""The rows of the scoreboard as HTML: a page's own, and the parts of any row."""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping, Sequence
from functools import cache
from itertools import chain
from pathlib import Path, PurePosixPath

from jinja2 import Environment
from markupsafe import Markup, escape

from repro.judge import ledger, scoreboard, verdict
from repro.judge.firmness import ALL, NONE, SOME
from repro.page.templates import environment
from repro.page.wording import HIDDEN_UNITS, label, rounded, significant
from repro.run import discover
from repro.run.deciding import judged_with

SIGNS = {
    "reproduced": "✓",
    "differs": "≠",
    "undecided": "?",
    "counterpart": "∥",
    "set": "⊙",
    "setting": "=",
    "not comparable": "∅",
    "not yet": "…",
    "quick": "~",
}


def row_templates(*folders: Path) -> Environment:
    """Return the templates for rows: those of this package, and of ``folders``."""
    templates = environment(*folders)
    templates.filters |= {"line": line, "breakable": breakable, "linked": linked}
    templates.globals |= {
        "ALL": ALL,
        "NONE": NONE,
        "SIGNS": SIGNS,
        "SOME": SOME,
        "addresses": addresses,
        "agreement": agreement,
        "computed": computed,
        "grouped": grouped,
        "label": label,
        "printed": printed,
    }
    return templates


@cache
def _own() -> Environment:
    return row_templates()


def part(name: str, *values: object) -> str:
    """Return one part of a row, by the name of its macro in `rows.html.jinja`."""
    macros = _own().get_template("rows.html.jinja").module
    return str(getattr(macros, name)(*values))


def line(value: object) -> str:
    """Return text on one line: a blank line would end the HTML inside Markdown."""
    return "" if value is None else " ".join(str(value).split())


def breakable(identifier: str) -> Markup:
    """Return an id that a narrow column may break after its underscores."""
    return escape(line(identifier)).replace("_", Markup("_<wbr>"))


def words_of(rows: Iterable[Mapping]) -> dict[str, str]:
    """Return id -> name of the row in a sentence: Fig. 2.3, or its words as a
    quotation."""
    return {
        row["id"]: label(row["id"]) or f"“{line(row['words']).rstrip('.')}”"
        for row in rows
    }


def linked(text: object, words: Mapping[str, str], up: str) -> Markup:
    """Return text on one line with ids of rows replaced by their words, with links.

    ``up`` leads to the top of the site.
    """
    link = Markup('<a href="{}scoreboard.html#{}" title="{}">{}</a>')
    parts = re.split(r"\b([A-Za-z]\w*_\w+)\b", line(text))
    return Markup().join(
        link.format(up, part, part, words[part]) if part in words else escape(part)
        for part in parts
    )


def agreement(row: Mapping) -> str:
    """Firmness of a verdict in words; empty without a judgement."""
    if row["ratio"] is not None:
        return f"{significant(row['ratio'], 3)} × published"
    text = (_readings_that_agree(row), "few seeds" if row["few_seeds"] else "")
    return ", ".join(part for part in text if part)


def _readings_that_agree(row: Mapping) -> str:
    if not row["agree"]:
        return ""
    agree, among = row["agree"]
    if row["kind"] != "claim":
        claims = "claim" if among == 1 else "claims"
        return f"{agree or 'none'} of {among} {claims} firm"
    if agree == among:
        return {1: "", 2: "in both interpretations"}.get(
            among, f"in all {among} interpretations"
        )
    if agree == 1:
        return f"in the primary interpretation only, of {among}"
    return f"in {agree} of {among} interpretations"


def printed(row: Mapping) -> str | None:
    """Return the printed number with its unit; None without one."""
    if row["published"] is None or row["kind"] != "number":
        return None
    unit = row["unit"]
    return (
        f"{line(row['published'])} {'' if unit in HIDDEN_UNITS else line(unit)}".strip()
    )


def computed(row: Mapping, unit: str) -> tuple[str | None, str]:
    """Return the regenerated value with its unit, and its interval; None without
    one."""
    if row["regenerated"] is None:
        return None, ""
    text = line(rounded(row["regenerated"], row["interval"], unit))
    if row["interval"] is None or not text.endswith(")"):
        return text, ""
    value, _, interval = text.rpartition(" (")
    return value, interval


def grouped(variants: Sequence[Mapping]) -> list[dict]:
    """Group readings by verdict; common parts of a group are written once, before
    them."""
    groups: dict[str, list[Mapping]] = {verdict: [] for verdict in SIGNS}
    for variant in variants:
        groups[variant["verdict"]].append(variant)
    return [_group(verdict, mine) for verdict, mine in groups.items() if mine]


def _group(verdict: str, variants: Sequence[Mapping]) -> dict:
    taken = [{*v["reading"].items()} for v in variants]
    common = set.intersection(*taken) if len(variants) > 1 else set()
    reasons = {v["reason"] for v in variants}
    reason = reasons.pop() if len(reasons) == 1 else None
    first = [pair for pair in variants[0]["reading"].items() if pair in common]
    return {
        "verdict": verdict,
        "shared": [text for text in (_pairs(first), line(reason)) if text],
        "variants": [
            (
                _pairs(pair for pair in v["reading"].items() if pair not in common),
                v,
                v["reason"] if reason is None else "",
            )
            for v in variants
        ],
    }


def _pairs(reading: Iterable[tuple[str, str]]) -> str:
    return line("; ".join(f"{q}: {o}" for q, o in reading).replace("_", " "))


def addresses(row: Mapping) -> list[tuple[str, str, str]]:
    """Address, short name and description of a row's page, its data, its code.

    The page opens at the row; an artefact's figure is its own anchor, and a section has
    only the comparison as a whole. Results lead to their provenance.
    """
    found = []
    if row["page"]:
        anchor = "compared" if row["kind"] == "section" else row["id"]
        found.append((f"{row['page']}#{anchor}", "page", f"page of {row['id']}"))
    for address in row["data"]:
        path = PurePosixPath(address)
        if path.suffix == ".json":
            about = f"provenance of {path.stem}"
            found.append((f"provenance/{path.stem}.html", path.stem, about))
        elif path.suffix == ".csv":
            found.append((address, "CSV", path.name))
    if row["source"]:
        found.append((row["source"], "code", f"code of {row['id']}"))
    return found


def comparison_table(page: str, effort: str, root: Path) -> str:
    """Return the rows of one page as HTML: claims, numbers, artefacts judged there.

    ``page`` is its id, ``root`` the checkout. Reads the judged files of `judged_with`;
    those of other pages are not needed.
    """
    folder = root / "figures" / effort / "judged"
    book = ledger.load(root)
    made = discover.producers(root)
    needed = judged_with(made, page, book)
    judged = verdict.read_judged(folder, needed)
    mine = {i for c in judged if c["page"] == page for k in verdict.KINDS for i in c[k]}
    every = chain(book.artefacts, book.numbers, book.claims, book.sections)
    elsewhere = {str(book.chapter(i)): "judged on another page" for i in every}
    rows = scoreboard.checked(verdict.rows(book, judged, elsewhere, effort))
    own = [row for row in rows if row["id"] in mine]
    return comparison(own, effort, "../" * page.count("/"), words_of(rows))


def comparison(
    rows: Sequence[Mapping], effort: str, up: str, words: Mapping[str, str]
) -> str:
    """Rows as one table per kind; ``up`` leads to the top of the site.

    ``words`` says what to write for the id of a row.
    """
    kinds = [
        (kind, [row for row in rows if row["kind"] == kind])
        for kind in ("claim", "number", "artefact")
    ]
    template = _own().get_template("compared.html.jinja")
    return template.render(
        kinds=kinds, effort=effort, up=up, words=words, empty=not rows
    )
