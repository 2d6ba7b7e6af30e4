"""The ledger as pages: settings with their reasons, and the errata.

Each setting, reading and erratum has its code as anchor.
"""

from __future__ import annotations

import re
from collections.abc import Iterable, Mapping
from functools import cache
from pathlib import Path

from jinja2 import Environment

from repro.judge import ledger
from repro.page.furniture import in_words
from repro.page.rows import line
from repro.page.templates import environment
from repro.page.wording import label

TEMPLATES = Path(__file__).with_name("templates")
ENTRY = re.compile(r"^- \*\*(E-[0-9A-Z]+\.[0-9]+)\*\*", re.MULTILINE)


def ledger_pages(root: Path, book: ledger.Ledger) -> dict[str, str]:
    """`settings.md` and `errata.md` for the site."""
    return {
        "settings.md": _settings_page(book),
        "errata.md": errata_page(_errata(root)),
    }


def codes(root: Path, book: ledger.Ledger, rows: Iterable[Mapping]) -> dict[str, str]:
    """Return the target of each code: errata, settings, readings, rows of the
    scoreboard.

    An id without an underscore may be any word and gets no link.
    """
    found = {row["id"]: f"scoreboard.html#{row['id']}" for row in rows}
    found |= {name: f"settings.html#{name}" for name in book.settings}
    found |= {name: f"settings.html#reading-{name}" for name in book.readings}
    found = {name: address for name, address in found.items() if "_" in name}
    return found | {c: f"errata.html#{c}" for c in ENTRY.findall(_errata(root))}


def errata_page(text: str) -> str:
    """The errata with an anchor at each entry."""
    return ENTRY.sub(r'- <span id="\1"></span>**\1**', text)


def _errata(root: Path) -> str:
    return (root / ledger.FOLDER / "errata.md").read_text("utf-8")


def _settings_page(book: ledger.Ledger) -> str:
    template = _templates().get_template("settings.md.jinja")
    chosen = [entry for entry in book.settings.values() if "chosen" in entry]
    return template.render(book=book, chosen=chosen) + "\n"


@cache
def _templates() -> Environment:
    templates = environment(TEMPLATES)
    templates.filters |= {"line": line, "words": in_words}
    templates.globals["label"] = label
    return templates
