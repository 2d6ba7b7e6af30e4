"""What becomes of a page when Sphinx has read it: what is found, and what goes below.

A Sphinx extension. `site.json` says which artefacts of the thesis a page has: the
search finds each by its number. Imports must run first, and nobody comes to read them:
on the page they stand last, whereas the notebook keeps its order.
"""

from __future__ import annotations

import json
from collections.abc import Iterable
from pathlib import Path

from docutils import nodes
from sphinx import addnodes

from repro.page.folding import IMPORTS_TAG
from repro.page.wording import label


def add_entries(doctree: nodes.document, identifiers: Iterable[str]) -> None:
    """Entries of the search for artefacts of the thesis, as people type their names."""
    entries = [
        ("single", name, identifier, "main", None)
        for identifier in identifiers
        for name in _names(label(identifier))
    ]
    if entries:
        doctree.insert(0, addnodes.index(entries=entries))


def _names(said: str) -> list[str]:
    word, _, number = said.rpartition(" ")
    return [said, f"Fig {number}", f"Figure {number}"] if word == "Fig." else [said]


def imports_last(doctree: nodes.document) -> None:
    """Put the cells with a page's imports at its end."""
    cells = [
        cell
        for cell in doctree.findall(nodes.container)
        if f"tag_{IMPORTS_TAG}" in cell["classes"]
    ]
    for cell in cells:
        cell.parent.remove(cell)
        next(doctree.findall(nodes.section)).append(cell)


def _on_page(app, doctree: nodes.document) -> None:
    add_entries(doctree, app.config.raxel_held.get(app.env.docname, ()))
    imports_last(doctree)


def setup(app) -> dict:
    """Pages are read anew when what they hold or this file changes."""
    site = json.loads((Path(app.srcdir) / "site.json").read_text("utf-8"))
    app.add_config_value("raxel_held", site["held"], "env")
    app.add_config_value("raxel_reading_file", Path(__file__).read_text("utf-8"), "env")
    app.connect("doctree-read", _on_page)
    return {"parallel_read_safe": True, "parallel_write_safe": True}
