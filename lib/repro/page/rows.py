"""HTML of a scoreboard row: badge, values, readings, links. All text is escaped."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from html import escape
from itertools import chain
from pathlib import Path, PurePosixPath

from repro.judge import ledger, scoreboard, verdict
from repro.page.wording import UNSPOKEN, label, rounded
from repro.run import discover
from repro.run.deciding import judged_with
from repro.run.discover import PAGE_FILE

SIGNS = {
    "reproduced": "✓",
    "differs": "≠",
    "undecided": "?",
    "counterpart": "≈",
    "setting": "=",
    "not comparable": "∅",
    "not yet": "…",
    "quick": "~",
}


def text(value: object) -> str:
    """Escaped text on one line: a blank line would end the HTML inside Markdown."""
    return "" if value is None else escape(" ".join(str(value).split()))


def badge(verdict: str, note: str = "") -> str:
    """The verdict as a word with a sign; its colour only repeats what they say."""
    name = verdict.replace(" ", "-")
    return (
        f'<span class="rx-badge rx-{name}"><span aria-hidden="true">{SIGNS[verdict]}'
        f"</span> {text(verdict)}{text(note)}</span>"
    )


def judged_badge(row: Mapping) -> str:
    """The badge of a row; where readings disagree, how many of them share it."""
    verdicts = [variant["verdict"] for variant in row["variants"]]
    agree = 1 + verdicts.count(row["verdict"])
    if agree > len(verdicts):
        return badge(row["verdict"])
    return (
        f'{badge(row["verdict"])} <span class="rx-primary">primary reading; {agree} of '
        f"{len(verdicts) + 1} agree</span>"
    )


def name_of(row: Mapping) -> str:
    """The row's id, after the name that people use where the thesis has one."""
    known = label(row["id"])
    spoken = f"{text(known)} " if known else ""
    return f"{spoken}<code>{breakable(row['id'])}</code>"


def breakable(identifier: str) -> str:
    """An id that a narrow column may break behind its underscores."""
    return text(identifier).replace("_", "_<wbr>")


def published(row: Mapping) -> str:
    """What the thesis printed: a statement, a title, or a value with its unit."""
    value = row["published"]
    if value is None:
        return '<span class="rx-none">none</span>'
    unit = row["unit"] if row["kind"] == "number" else ""
    unit = "" if unit in UNSPOKEN else unit
    return f"{text(value)} {text(unit)}".strip()


def regenerated(row: Mapping, unit: str | None = None) -> str:
    """What came out here, with interval and unit; a dash where nothing did."""
    value = row["regenerated"]
    if value is None:
        return '<span class="rx-none">–</span>'
    unit = row["unit"] if unit is None else unit
    said = text(rounded(value, row["interval"], unit))
    if row["interval"] is None or not said.endswith(")"):
        return said
    value, _, interval = said.rpartition(" (")
    return f'{value} <span class="rx-interval">({interval}</span>'


def limits_of(row: Mapping) -> str:
    """The test of a claim with its limits, folded away, and what changed in it."""
    changed = ""
    if row["changed"]:
        changed = f'<p class="rx-changed">Test changed: {text(row["changed"])}</p>'
    if not row["test"]:
        return changed
    return (
        f'{changed}<details class="rx-test"><summary>the test and its limits</summary>'
        f"<p>{text(row['test'])}</p></details>"
    )


def readings(row: Mapping) -> str:
    """The readings of an open text, folded away, grouped by verdict."""
    variants = row["variants"]
    if not variants:
        return ""
    groups: dict[str, list[Mapping]] = {verdict: [] for verdict in SIGNS}
    for variant in variants:
        groups[variant["verdict"]].append(variant)
    groups = {verdict: mine for verdict, mine in groups.items() if mine}
    tally = ", ".join(f"{len(mine)} {verdict}" for verdict, mine in groups.items())
    lists = "".join(_group(row, verdict, mine) for verdict, mine in groups.items())
    word = "other reading" if len(variants) == 1 else "other readings"
    return (
        f"<details><summary>{len(variants)} {word}: {text(tally)}</summary>"
        f"{lists}</details>"
    )


def _group(row: Mapping, verdict: str, variants: Sequence[Mapping]) -> str:
    """Variants of one verdict; what all of them share is said once, before them."""
    taken = [{*v["reading"].items()} for v in variants]
    common = set.intersection(*taken) if len(variants) > 1 else set()
    reasons = {v["reason"] for v in variants}
    reason = reasons.pop() if len(reasons) == 1 else None
    items = "".join(_variant(row, v, common, reason is None) for v in variants)
    first = {q: o for q, o in variants[0]["reading"].items() if (q, o) in common}
    said = "; ".join(part for part in (_pairs(first), text(reason)) if part)
    return f"<div>{badge(verdict)} {said}<ul>{items}</ul></div>"


def _variant(row: Mapping, variant: Mapping, common: set, with_reason: bool) -> str:
    own = {q: o for q, o in variant["reading"].items() if (q, o) not in common}
    value = regenerated(variant, row["unit"])
    reason = f" {text(variant['reason'])}" if with_reason else ""
    return f"<li>{_pairs(own)} → <b>{value}</b>{reason}</li>"


def _pairs(reading: Mapping[str, str]) -> str:
    return text("; ".join(f"{q}: {o}" for q, o in reading.items()).replace("_", " "))


def links(row: Mapping, up: str, sources: Iterable[str]) -> str:
    """Links to the row's page, its data and its source; ``up`` leads to the top."""
    found = []
    if row["page"]:
        found.append((row["page"], "page", f"page of {row['id']}"))
    for address in row["data"]:
        path = PurePosixPath(address)
        if path.suffix not in (".csv", ".json"):
            continue
        short = path.stem if path.parent.name == "results" else path.suffix[1:].upper()
        found.append((address, short, path.name))
    name = (row["page"] or "").removesuffix(".html")
    if name in sources:
        found.append((f"source/{name}/{PAGE_FILE}", "source", f"source of {row['id']}"))
    return " ".join(
        f'<a href="{escape(up + address)}" title="{escape(said)}" '
        f'aria-label="{escape(said)}">{breakable(short)}</a>'
        for address, short, said in found
    )


def said(row: Mapping) -> str:
    """The reason, the test behind a verdict that there is, and the other readings."""
    reason = f'<span class="rx-reason">{text(row["reason"])}</span>'
    return reason + limits_of(row) + readings(row)


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
    rows = scoreboard.checked(verdict.rows(book, judged, elsewhere, effort))
    own = [row for row in rows if row["id"] in mine]
    tests = {
        p.id: f"source/{p.path}.html#{p.function}"
        for p in discover.producers(root)
        if p.kind == "claim"
    }
    return comparison(own, effort, "../" * page.count("/"), tests)


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
            f'<td class="r">{said(row)}{_behind(row, up, tests)}</td></tr>'
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
